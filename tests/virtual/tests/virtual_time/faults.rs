//! Faults, each alone, against its expectations and against the invariants of every run.
//!
//! The table in `docs/FAULTS.md` is made here. All seeds of the long run:
//! `SEEDS=1..200 cargo test --release --workspace --test virtual_time every_fault_with_many_seeds -- --ignored`.

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use coaxle_clock::cycle_lock::CycleLockState;
use coaxle_clock::timing::TimingState;
use coaxle_lab::catalog::FAULTS;
use coaxle_lab::summary::Summary;
use coaxle_lab::verdict::Verdict;

/// Seeds of every test run, after the first, which makes the table.
const FEW: RangeInclusive<u64> = 2..=3;
/// Seeds of the long run.
const MANY: RangeInclusive<u64> = 1..=200;

/// Update after a change: `UPDATE_DOCS=1 cargo test --workspace --test virtual_time faults`.
#[test]
fn the_table_of_faults_is_what_was_seen() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/FAULTS.md");
    let runs = FAULTS.iter().map(|(name, _)| crate::common::run(name, &[]));
    let runs: Vec<_> = runs.collect();
    for run in &runs {
        let failed: Vec<_> = run.failed().map(ToString::to_string).collect();
        assert!(failed.is_empty(), "{}: {}", run.scenario, failed.join("\n"));
    }
    let written = table(&runs);
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(path, &written).expect("docs can be written");
    }
    let there = std::fs::read_to_string(path).expect("docs/FAULTS.md");
    assert!(
        there == written,
        "docs/FAULTS.md is not what was seen: UPDATE_DOCS=1 writes it"
    );
}

/// The bounds of its cycle are an invariant of every run.
#[test]
fn every_fault_with_a_receiver_whose_cycle_is_locked() {
    let observed = FAULTS
        .iter()
        .filter(|(_, text)| text.contains("name = \"observer\""));
    let mut locked = 0;
    for (name, _) in observed {
        let run = crate::common::run(name, &["receiver.observer.lock-cycle={}"]);
        let failed: Vec<_> = run.failed().map(ToString::to_string).collect();
        assert!(failed.is_empty(), "{name}: {}", failed.join("\n"));
        let lock = run.receivers["observer"].last.node.cycle_lock;
        // A drift of more than 400 ppm is not followed.
        let is_beyond = *name == "faults/drift";
        let expected = if is_beyond {
            CycleLockState::Refused
        } else {
            CycleLockState::Locked
        };
        assert_eq!(lock, Some(expected), "{name}");
        locked += 1;
    }
    assert!(locked > 20, "{locked}");
}

/// The error that is stated, which a common time makes small, is an invariant of every run.
#[test]
fn every_fault_with_a_time_in_common() {
    let time = "{grandmaster=\"0000000000000001\", bound-us=0.2}";
    let overrides = [
        // Ways that take nothing bound a clock better than any statement.
        "timing-network={latency-us=5, jitter={exponential-us=2}}".to_owned(),
        "sender.belt.timing={listen=\"127.0.0.1:7450\"}".to_owned(),
        "receiver.observer.timing={connect=\"127.0.0.1:7450\"}".to_owned(),
        format!("sender.belt.time={time}"),
        format!("receiver.observer.time={time}"),
    ];
    let overrides = overrides.each_ref().map(String::as_str);
    let mut timed = 0;
    let followed = FAULTS.iter().filter(|(_, text)| {
        text.contains("name = \"observer\"") && text.contains("name = \"belt\"")
    });
    for (name, _) in followed {
        let run = crate::common::run(name, &overrides);
        let failed: Vec<_> = run.failed().map(ToString::to_string).collect();
        assert!(failed.is_empty(), "{name}: {}", failed.join("\n"));
        let state = run.receivers["observer"].last.far.common_time_state;
        assert_eq!(state, Some(TimingState::InUse), "{name}");
        timed += 1;
    }
    assert!(timed > 20, "{timed}");
}

#[test]
fn every_fault_with_a_few_seeds() {
    run_all(FEW);
}

#[test]
#[ignore = "takes minutes"]
fn every_fault_with_many_seeds() {
    run_all(asked_for().unwrap_or(MANY));
}

/// `SEEDS`, a range of them.
fn asked_for() -> Option<RangeInclusive<u64>> {
    let asked = std::env::var("SEEDS").ok()?;
    let (from, to) = asked.split_once("..").expect("SEEDS: expected FROM..TO");
    let number = |text: &str| text.parse().expect("SEEDS: expected FROM..TO");
    Some(number(from)..=number(to))
}

/// Every fault with every seed, on all processors.
fn run_all(seeds: RangeInclusive<u64>) {
    let runs = FAULTS
        .iter()
        .flat_map(|(name, _)| seeds.clone().map(move |seed| (*name, seed)));
    let runs: Vec<_> = runs.collect();
    let next = AtomicUsize::new(0);
    let failures = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                // Relaxed suffices: the counter alone hands out the runs, and the end of the scope orders the rest.
                while let Some((name, seed)) = runs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let run = crate::common::run(name, &[&format!("seed={seed}")]);
                    let failed = run
                        .failed()
                        .map(|verdict| format!("{name}, seed {seed}: {verdict}"));
                    failures.lock().expect("no panic").extend(failed);
                }
            });
        }
    });
    let mut failures = failures.into_inner().expect("no panic");
    // Threads end in any order.
    failures.sort();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

const HEAD: &str = "\
# What goes wrong, and what becomes of it

One scenario for each fault, run in virtual time with its first seed: `coaxle run faults/corruption`, in real processes with
`--processes`. What was seen is what the summary says; what is expected is in the scenario. Besides, in every cycle of every
run: what leaves a node is finite, set positions keep the velocity, acceleration, jerk and software limits of their slave by
their differences, error stop is latched, far time goes strictly on, nobody is followed instead of another uncounted, and
every message is accounted for ([INVARIANTS.md](INVARIANTS.md) has them all). Of processes, no signal kills a node but
where the scenario does. This table is made by a test (`UPDATE_DOCS=1 cargo test --workspace --test
virtual_time faults`), which runs some more seeds of each every time, and 200 of each by
`cargo test --release --workspace --test virtual_time every_fault_with_many_seeds -- --ignored`.

A sender's wall clock is no fault: nothing reads a wall clock but log lines (`clippy.toml` refuses it everywhere else).

Besides what has a name of its own, the drift of a node's clock and the delay of a link are sums of terms over the time since the
start: `drift-terms-ppm = [...]` of `clock`, `delay-terms-us = [...]` of `[network]` and of `faults`, up to 16 each.

A scenario has `clock` and `faults` at its nodes. The config of a node of its own has them in a table `[lab]`, and is refused with it
unless the node is started with `--lab`; then log, status and recording say that it is an experiment:

```toml
[lab]
clock = { drift-ppm = 500 }                     # of a sender, a receiver or a gateway
[[lab.far]]                                     # of a receiver: the link to a node that it follows
node = \"conveyor\"
faults = { latency-us = 300, loss = 0.1 }
request-faults = { latency-us = 900 }           # over the time requests instead
timing-faults = { loss = 0.2 }                  # over the beacons of the timing channel
```

| term | what it is |
|--|--|
| `{ constant = 3 }` | always the same |
| `{ sine = { amplitude = 5, period-s = 60 } }`, `triangle` | around zero, beginning upwards; `phase = 0.25` begins a quarter later |
| `{ pulse = { height = 200, period-s = 5, duty = 0.2 } }` | rectangular: `height` for the first fifth of each period, else 0; `phase` as above |
| `{ step = { at-s = 10, by = -4 } }` | from then on; with `over-s = 20` evenly within that time, a ramp |
| `{ uniform = { from = -1, to = 2 } }`, `{ exponential = 3 }`, `{ normal = 0.5 }` | noise, the latter two by mean and standard deviation: drawn for each message, for a clock every 10 ms |
| `{ file = { path = 'drift.csv' } }` | two columns, seconds and value, on straight lines or with `between = 'held'` by steps; the first value before, the last one after. Relative to the file it is named in |

A clock goes by pieces of 10 ms with the mean of its terms in each, so that what it reads is exact at their ends whatever edges lie
within, and reading and asking when it reads that are inverses. Terms of a drift may come to 300 000 ppm in sum, noise with six standard
deviations or twenty means: with all else no clock stands still.

The reading of a clock jumps ahead or back by `phase-us` of its `steps`, up to 100 s. After a jump ahead a node skips the cycles that it
has missed and counts them. After a jump back it waits until its clock has come again to where its next cycle is due: no cycle is run
twice and no count is used again, so for everybody else it stood still for so long. A real node reads the machine's monotonic clock, which does
neither by itself.

| `coaxle run` | injected | expected | seen |
|--|--|--|--|
";

fn table(runs: &[Summary]) -> String {
    let mut text = HEAD.to_owned();
    for ((name, source), run) in FAULTS.iter().zip(runs) {
        let described = description_of(source);
        let (injected, expected) = described
            .split_once("Expected: ")
            // The column of the table is the part of the description behind this word.
            .unwrap_or_else(|| panic!("{name} says what is expected"));
        let injected = match injected.trim() {
            "" => String::new(),
            injected => format!("<br>{injected}"),
        };
        let seen: Vec<_> = run.expectations.iter().map(seen).collect();
        let (title, seen) = (&run.title, seen.join("<br>"));
        let _ = writeln!(
            text,
            "| `{name}` | **{title}**{injected} | {expected} | {seen} |"
        );
    }
    text
}

fn description_of(source: &str) -> String {
    let table: toml::Table = source.parse().expect("TOML");
    let description = table["description"].as_str().expect("a description");
    description.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn seen(verdict: &Verdict) -> String {
    let (place, received, expected) = (verdict.place(), &verdict.received, &verdict.expected);
    let shown = match (received.as_str(), received.as_f64()) {
        (Some(text), _) => text.to_owned(),
        (None, Some(number)) if number.fract() != 0.0 => format!("{number:.2}"),
        (None, _) => received.to_string(),
    };
    // An exact expectation repeats the value, and that of a text repeats it in quotes.
    if shown == *expected || received.is_string() {
        format!("`{place}` {shown}")
    } else {
        format!("`{place}` {shown}, {expected}")
    }
}
