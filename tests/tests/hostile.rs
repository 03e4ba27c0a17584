//! Hostile input: no target panics, takes long, or refuses it without one clear line.
//!
//! `HOSTILE_CASES` and `HOSTILE_SEED` set the number of mutations of each target in the long run, and the first seed.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong, and says what it has done"
)]

use std::fmt::Write as _;
use std::panic::catch_unwind;
use std::path::PathBuf;
use std::time::Duration;

use coaxle_tests::hostile::mutate::Mutator;
use coaxle_tests::hostile::{Kind, Outcome, TARGETS, Target, root, target};

/// The processor time that an input may take: mostly it is a millisecond or so.
const LONGEST: Duration = Duration::from_secs(5);

/// The processor time of this thread: other programs on a busy machine do not count.
fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::try_from(time).unwrap()
}

/// The stored corpus of a target.
fn corpus(target: &Target) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = root().join("tests/corpus").join(target.name);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        // A new target has no corpus yet.
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    // Folders are listed in another order on each machine, and cases depend on the order.
    paths.sort();
    let read = |path: PathBuf| {
        let data = std::fs::read(&path).unwrap();
        (path, data)
    };
    paths.into_iter().map(read).collect()
}

/// Outcomes of many inputs.
#[derive(Debug, Default)]
struct Tally {
    taken: usize,
    refused: usize,
    slowest: Duration,
}

impl Tally {
    fn examine(&mut self, target: &'static Target, data: &[u8], name: &str) -> Outcome {
        let begin = processor_time();
        // A panic would end the test before the input is in a file.
        let outcome = catch_unwind(|| target.examine(data));
        let took = processor_time() - begin;
        self.slowest = self.slowest.max(took);
        let Ok(outcome) = outcome else {
            panic!("{}: {name}: {}", target.name, kept(target, data));
        };
        assert!(
            took <= LONGEST,
            "{}: {name} took {took:?}: {}",
            target.name,
            kept(target, data)
        );
        match outcome {
            Ok(()) => self.taken += 1,
            Err(_) => self.refused += 1,
        }
        outcome
    }
}

/// Stores an input that fails in a file, to examine and to add to the corpus.
fn kept(target: &Target, data: &[u8]) -> String {
    // Targets are examined in parallel, and several runs may share the folder.
    let name = format!("coaxle-hostile-{}-{}", target.name, std::process::id());
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, data).unwrap();
    path.display().to_string()
}

fn mutations(target: &'static Target, cases: usize, seed: u64) -> Tally {
    // Mutations of past failures find their neighbours.
    let stored = corpus(target).into_iter().map(|(_, data)| data);
    let seeds = (target.seeds)().into_iter().map(|(_, data)| data);
    let inputs: Vec<Vec<u8>> = stored.chain(seeds).collect();
    let mut tally = Tally::default();
    let mut mutator = Mutator::new(seed, target.kind);
    for case in 0..cases {
        let data = mutator.next(&inputs);
        // A refusal is as good as any other outcome.
        let _ = tally.examine(target, &data, &format!("case {case} of seed {seed}"));
    }
    tally
}

#[test]
fn what_is_shipped_is_taken() {
    for target in TARGETS {
        for (name, data) in (target.seeds)() {
            let outcome = target.examine(&data);
            assert!(
                // Examples of refusals are shipped with the saw and gear files.
                outcome.is_ok() || ["saw-file", "gear-file"].contains(&target.name),
                "{}: {name}: {outcome:?}",
                target.name
            );
        }
    }
}

/// Runs each input of the corpus, and lists the outcomes.
#[test]
fn the_stored_corpus_holds() {
    let mut table = String::new();
    for target in TARGETS {
        let mut tally = Tally::default();
        for (path, data) in corpus(target) {
            let outcome = tally.examine(target, &data, &path.display().to_string());
            let name = path.file_name().unwrap().to_string_lossy();
            let said = match outcome {
                Ok(()) => "taken".to_owned(),
                Err(message) => without_places(&message),
            };
            writeln!(table, "{}/{name}\n    {said}", target.name).unwrap();
        }
    }
    insta::assert_snapshot!(table);
}

/// A message without the folders of this machine.
fn without_places(message: &str) -> String {
    // The snapshot names no folder of a developer.
    let message = message.replace(&format!("{}/", root().display()), "");
    match message.split_once(".csv") {
        // The path has the number of the process in it.
        Some((scratch, rest)) if scratch.contains("coaxle-hostile-") => {
            format!("scratch.csv{rest}")
        }
        _ => message,
    }
}

/// Mutations of each target in the ordinary tests: seconds in all.
const fn cases(target: &Target) -> usize {
    match (target.name.as_bytes(), target.kind) {
        // A receiver runs for a thousand cycles each time.
        (b"arrivals", _) => 1_000,
        // A gateway runs for a cycle for each sample.
        (b"ads" | b"plc-datagrams" | b"plc-lines", _) => 1_000,
        (_, Kind::Bytes) => 50_000,
        (_, Kind::Text) => 3_000,
    }
}

macro_rules! mutations_hold {
    ($($test:ident: $name:literal,)*) => {
        $(
            #[test]
            fn $test() {
                // A test for each target: they run in parallel, and a failure names its own.
                let target = target($name);
                mutations(target, cases(target), 1);
            }
        )*

        #[test]
        fn every_target_is_tried() {
            let tried = [$($name),*];
            // A new target without a test fails here.
            assert!(TARGETS.iter().map(|target| target.name).eq(tried));
        }
    };
}

mutations_hold! {
    frames: "frame",
    time_requests: "time-request",
    time_responses: "time-response",
    arrivals: "arrivals",
    orders: "order",
    sender_configs: "sender-config",
    receiver_configs: "receiver-config",
    scenarios: "scenario",
    cam_files: "cam-file",
    cam_tables: "cam-table",
    point_tables: "point-table",
    plc_arrays: "plc-array",
    saw_files: "saw-file",
    gear_files: "gear-file",
    recordings: "recording",
    transports: "transport",
    ros_trajectories: "ros-trajectory",
    ads: "ads",
    plc_datagrams: "plc-datagrams",
    plc_lines: "plc-lines",
}

#[test]
#[ignore = "as long as HOSTILE_CASES says"]
fn many_mutations() {
    let number = |name: &str| {
        std::env::var(name)
            .ok()
            .map(|text| text.parse::<u64>().unwrap())
    };
    let only = std::env::var("HOSTILE_TARGET").ok();
    // Seed 1 is that of the ordinary tests, so 2 tries new inputs.
    let seed = number("HOSTILE_SEED").unwrap_or(2);
    for target in TARGETS {
        // A target that fails is run again without the hours of the others.
        if only.as_ref().is_some_and(|only| only != target.name) {
            continue;
        }
        let more = number("HOSTILE_CASES").map(|cases| cases as usize);
        let cases = more.unwrap_or(10 * cases(target));
        let begin = processor_time();
        let tally = mutations(target, cases, seed);
        let took = processor_time() - begin;
        eprintln!("{}: {cases} in {took:.1?}: {tally:?}", target.name);
    }
}
