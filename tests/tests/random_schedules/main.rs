//! Random schedules in virtual time: whatever goes wrong, no slave leaves its limits, no far time goes back, and
//! when it is quiet again everybody is in sync.
//!
//! Some run with every test run, all with `cargo test --workspace --test random_schedules -- --ignored`. A seed
//! that failed is printed with the scenario it stands for, which `coaxle run FILE` repeats;
//! `SCHEDULES=1234 cargo test …` runs that one alone, `SCHEDULES=1000..2000` a range.

mod schedule;

use std::fmt::Write as _;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use coaxle::catalog::Source;
use coaxle::finished::Finished;
use coaxle::virtual_time;

/// Seeds beyond [`FEW`] that once failed, and why.
const REGRESSIONS: &[(u64, &str)] = &[];

/// Those of every test run.
const FEW: Range<u64> = 0..100;

/// Those of `--ignored`.
const MANY: Range<u64> = 0..1_000;

#[test]
fn some_random_schedules() {
    let seeds = asked_for().unwrap_or(FEW);
    let regressions = REGRESSIONS.iter().map(|(seed, _)| *seed);
    run_all(&regressions.chain(seeds).collect::<Vec<_>>());
}

#[test]
#[ignore = "takes minutes"]
fn a_thousand_random_schedules() {
    run_all(&asked_for().unwrap_or(MANY).collect::<Vec<_>>());
}

/// `SCHEDULES`, a seed or a range of them.
fn asked_for() -> Option<Range<u64>> {
    let asked = std::env::var("SCHEDULES").ok()?;
    let number = |text: &str| {
        text.parse()
            .expect("SCHEDULES: expected a seed, or FROM..TO")
    };
    Some(match asked.split_once("..") {
        Some((from, to)) => number(from)..number(to),
        None => number(&asked)..number(&asked) + 1,
    })
}

/// Runs them on all processors, and fails with what was wrong with each.
fn run_all(seeds: &[u64]) {
    let next = AtomicU64::new(0);
    let failures = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed) as usize;
                    let Some(seed) = seeds.get(place) else {
                        return;
                    };
                    if let Err(wrong) = run(*seed) {
                        failures.lock().expect("no panic").push((*seed, wrong));
                    }
                }
            });
        }
    });
    let mut failures = failures.into_inner().expect("no panic");
    failures.sort();
    let mut text = String::new();
    for (seed, wrong) in &failures {
        let path = std::env::temp_dir().join(format!("schedule-{seed}.toml"));
        std::fs::write(&path, schedule::of(*seed)).expect("a scratch folder");
        let _ = writeln!(text, "seed {seed}, as {}:\n  {wrong}", path.display());
    }
    let count = failures.len();
    assert!(
        failures.is_empty(),
        "{count} of {} failed\n{text}",
        seeds.len()
    );
}

/// Runs the schedule of a seed. What is wrong with it, a line each, otherwise.
fn run(seed: u64) -> Result<(), String> {
    let source = Source {
        name: format!("schedule-{seed}"),
        file: format!("schedule-{seed}.toml"),
        text: schedule::of(seed),
    };
    let scenario = source.read(&[]).map_err(|error| format!("{error:#}"))?;
    let finished =
        virtual_time::run(&scenario, &mut (), &mut ()).map_err(|error| format!("{error:#}"))?;
    let wrong = wrong_with(&finished);
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n  "))
    }
}

fn wrong_with(finished: &Finished) -> Vec<String> {
    let violations = finished.violations().iter().map(ToString::to_string);
    let lost = finished
        .figures()
        .iter()
        .filter(|(_, receiver)| synchronises(receiver.mode) && !receiver.synced_at_end)
        .map(|(name, receiver)| format!("{name} ({}) is not in sync at the end", receiver.mode));
    violations.chain(lost).collect()
}

fn synchronises(mode: &str) -> bool {
    matches!(mode, "observer" | "sync" | "time")
}
