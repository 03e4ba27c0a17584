//! Recorded arrivals, and runs made of them: the sender is given a clock that drifts and wanders, the delays and the
//! lateness of the sender stay as recorded.

use std::path::{Path, PathBuf};

use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::world::{Exchange, Message, Run};

const CYCLE: f64 = Recording::CYCLE;
const CYCLE_NS: i64 = 1_000_000;
/// Standard deviation of the drift's random walk, 1/√s.
const WALK: f64 = 1e-8;
/// Drift of the sender's clock in the first run of each recording.
const USUAL_DRIFT: f64 = 10e-6;

/// A message as it was recorded, ns.
struct Row {
    count: i64,
    /// Lateness of sending after the ideal start.
    late: i64,
    /// Time from sending until the receiving thread had the message.
    to_thread: i64,
    /// Time from sending until the kernel had the message. None where it was not reported.
    to_kernel: Option<i64>,
}

/// A file of arrivals and, if it has one, that of its exchanges. Ideal start of count `k` is `k·T`, and both sides
/// used a common clock.
pub(crate) struct Recording {
    pub(crate) name: String,
    rows: Vec<Row>,
    exchanges: Vec<Exchange>,
}

/// Origin of the arrival stamps.
#[derive(Clone, Copy)]
pub(crate) enum StampedBy {
    Thread,
    Kernel,
}

/// Loads the recordings of a directory, by name.
pub(crate) fn load(directory: &Path) -> Result<Vec<Recording>, String> {
    let unreadable = |error| format!("{}: {error}", directory.display());
    let entries = std::fs::read_dir(directory).map_err(unreadable)?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "i32"))
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(format!("{}: no *.i32 in it", directory.display()));
    }
    files.iter().map(|file| Recording::load(file)).collect()
}

impl Recording {
    /// Cycle time of every recording, s.
    pub(crate) const CYCLE: f64 = 1e-3;

    fn load(file: &Path) -> Result<Self, String> {
        let wrong = |what: &dyn std::fmt::Display| format!("{}: {what}", file.display());
        let bytes = std::fs::read(file).map_err(|error| wrong(&error))?;
        let mut rows = parse_rows(&bytes).ok_or_else(|| wrong(&"no rows of four i32"))?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let exchanges = file.with_file_name(format!("{name}-exchanges.csv"));
        let mut exchanges = if exchanges.exists() {
            let text = std::fs::read_to_string(&exchanges).map_err(|error| wrong(&error))?;
            parse_exchanges(&text).ok_or_else(|| wrong(&"its exchanges are not t1,t2,t3,t4"))?
        } else {
            Vec::new()
        };
        // A piece from the middle of a recording keeps its counts.
        let first = rows[0].count;
        for row in &mut rows {
            row.count -= first;
        }
        for exchange in &mut exchanges {
            *exchange = exchange.moved(-first * CYCLE_NS, -first * CYCLE_NS);
        }
        Ok(Self {
            name: name.into_owned(),
            rows,
            exchanges,
        })
    }

    pub(crate) fn has_kernel_stamps(&self) -> bool {
        self.rows.iter().any(|row| row.to_kernel.is_some())
    }

    pub(crate) fn cycles(&self) -> usize {
        self.rows.last().map_or(0, |row| row.count as usize + 1)
    }

    /// Makes a run of the recording with a drifting sender's clock. The usual drift is +10 ppm; else the seed chooses
    /// it, log-uniform 1 to 100 ppm of either sign.
    pub(crate) fn run(&self, stamped_by: StampedBy, seed: u64, usual_drift: bool) -> Run {
        let due = wandering_clock(self.cycles() + 20, seed, usual_drift);
        let at = |count: i64| (due[count as usize] * 1e9).round() as i64;
        let mut messages: Vec<Message> = self
            .rows
            .iter()
            .filter_map(|row| {
                let delay = match stamped_by {
                    StampedBy::Thread => row.to_thread,
                    StampedBy::Kernel => row.to_kernel?,
                };
                Some(Message {
                    count: row.count,
                    // The path and the sender's lateness stay as recorded. Only the clock that makes cycles is another one.
                    arrived: at(row.count) + row.late + delay,
                    stamp: Some(row.late),
                })
            })
            .collect();
        messages.sort_by_key(|message| message.arrived);
        let mut run = Run::of_parts(messages, due, CYCLE);
        run.exchanges = self.warped_exchanges(&run);
        run
    }

    /// An exchange moves with the cycle in which the sender got the request.
    fn warped_exchanges(&self, run: &Run) -> Vec<Exchange> {
        let warped = self.exchanges.iter().filter_map(|recorded| {
            let count = recorded.t2.div_euclid(CYCLE_NS);
            let due = run.due(usize::try_from(count).ok()?)? * 1e9;
            let by = due.round() as i64 - count * CYCLE_NS;
            let local = recorded.moved(by, by);
            let far = |local: i64| (run.far(local as f64 * 1e-9) * 1e9).round() as i64;
            Some(Exchange {
                t2: far(local.t2),
                t3: far(local.t3),
                ..local
            })
        });
        let mut warped: Vec<Exchange> = warped.collect();
        warped.sort_by_key(|exchange| exchange.t4);
        warped
    }
}

/// Due time of each count by a clock that drifts and wanders, s.
fn wandering_clock(counts: usize, seed: u64, usual_drift: bool) -> Vec<f64> {
    // Another stream than that of generated cases of the same seed.
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x7777);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let mut now = 0.0123 + uniform() * CYCLE;
    // Log-uniform: quartzes of 1 ppm are as usual as those of 100.
    let size = 1e-6 * 100f64.powf(uniform());
    let chosen = if uniform() < 0.5 { size } else { -size };
    let mut drift = if usual_drift { USUAL_DRIFT } else { chosen };
    let step_of_walk = WALK * CYCLE.sqrt();
    let mut next = || {
        let due = now;
        now += CYCLE * (1.0 + drift);
        let normal: f64 = StandardNormal.sample(&mut random);
        drift += step_of_walk * normal;
        due
    };
    (0..counts).map(|_| next()).collect()
}

fn parse_rows(bytes: &[u8]) -> Option<Vec<Row>> {
    let (rows, []) = bytes.as_chunks::<16>() else {
        return None;
    };
    let rows: Vec<Row> = rows.iter().map(parse_row).collect();
    (!rows.is_empty()).then_some(rows)
}

fn parse_row(row: &[u8; 16]) -> Row {
    let (columns, _) = row.as_chunks::<4>();
    let [count, late, to_thread, to_kernel] =
        [0, 1, 2, 3].map(|column| i64::from(i32::from_le_bytes(columns[column])));
    Row {
        count,
        late,
        to_thread,
        // Files have 0 where the kernel gave no stamp.
        to_kernel: (to_kernel != 0).then_some(to_kernel),
    }
}

fn parse_exchanges(text: &str) -> Option<Vec<Exchange>> {
    text.lines().skip(1).map(parse_exchange).collect()
}

fn parse_exchange(line: &str) -> Option<Exchange> {
    let mut columns = line.split(',').map(|column| column.trim().parse().ok());
    Some(Exchange {
        t1: columns.next()??,
        t2: columns.next()??,
        t3: columns.next()??,
        t4: columns.next()??,
    })
}
