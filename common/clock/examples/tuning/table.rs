//! The table: each constant, and the largest changes that it makes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use coaxle_clock::tuning::TunedBlock;

use crate::cases::NamedCase;
use crate::outcome::RunOutcome;

/// Relative change of a figure that is named.
const NAMED: f64 = 0.01;

/// A tuned constant.
pub(crate) struct TunedConstant {
    pub(crate) block: &'static TunedBlock,
    pub(crate) name: &'static str,
}

impl TunedConstant {
    /// Iterates over all of them.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        coaxle_clock::tuned_blocks()
            .flat_map(|block| block.constants.iter().map(move |name| Self { block, name }))
    }

    pub(crate) fn path(&self) -> String {
        format!("{}.{}", self.block.name, self.name)
    }

    /// True if a word names it or its block.
    pub(crate) fn is(&self, word: &str) -> bool {
        word == self.block.name || word == self.path()
    }
}

/// Prints the table of some constants, each times these factors, over some cases.
pub(crate) fn print(constants: &[TunedConstant], cases: &[NamedCase], factors: [f64; 2]) {
    let base: Vec<RunOutcome> = cases.iter().map(NamedCase::outcome).collect();
    println!(
        "| constant | value | runs of {} that change | × {} | × {} |",
        cases.len(),
        factors[0],
        factors[1]
    );
    println!("|--|--|--|--|--|");
    let rows = Mutex::new(vec![String::new(); constants.len()]);
    // Constants are perturbed for one thread alone, so several can be tried at a time.
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let n = next.fetch_add(1, Ordering::Relaxed);
            let Some(constant) = constants.get(n) else {
                break;
            };
            let row = row(constant, cases, &base, factors);
            rows.lock().unwrap()[n] = row;
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            let _ = scope.spawn(work);
        }
    });
    for row in rows.into_inner().unwrap() {
        println!("{row}");
    }
}

fn row(
    constant: &TunedConstant,
    cases: &[NamedCase],
    base: &[RunOutcome],
    factors: [f64; 2],
) -> String {
    // By 1, to read it.
    let value = (constant.block.perturb)(constant.name, 1.0);
    let changes = factors.map(|factor| {
        let _ = (constant.block.perturb)(constant.name, factor);
        let outcomes = || {
            let outcomes = cases.iter().zip(base).map(|(case, base)| {
                // Without the block in it, a run would only be the same again.
                if case.is_of(constant.block.name) {
                    case.outcome()
                } else {
                    base.clone()
                }
            });
            outcomes.collect::<Vec<_>>()
        };
        // A thousand times a least value is more than the greatest one: clamping panics then.
        match catch_unwind(AssertUnwindSafe(outcomes)) {
            Ok(outcomes) => changes(cases, base, &outcomes),
            Err(_) => (0, "contradicts another one".to_owned()),
        }
    });
    (constant.block.restore)();
    let [(fewer, less), (more, greater)] = changes;
    format!(
        "| `{}` | {value} | {fewer}, {more} | {less} | {greater} |",
        constant.path()
    )
}

/// Number of runs that change, and the figure that changes most.
fn changes(cases: &[NamedCase], base: &[RunOutcome], outcomes: &[RunOutcome]) -> (usize, String) {
    let all = cases.iter().zip(base).zip(outcomes);
    let changed = all
        .clone()
        .filter(|((_, old), new)| old.digest != new.digest);
    let largest = all
        .filter_map(|((case, old), new)| {
            let (new, old, by) = new.largest_change(old)?;
            Some((case, new, old, by))
        })
        .max_by(|a, b| a.3.total_cmp(&b.3));
    let text = match largest {
        Some((case, new, old, by)) if by > NAMED => {
            format!(
                "{}: {} {} → {}",
                case.name,
                old.name,
                digits(old.value),
                digits(new.value)
            )
        }
        _ => "–".to_owned(),
    };
    (changed.count(), text)
}

/// Three digits.
fn digits(value: f64) -> String {
    let places = (2.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{value:.places$}")
}
