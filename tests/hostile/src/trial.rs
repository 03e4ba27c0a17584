//! Trials of a target: its stored corpus and mutations of it, each with its outcome and its time.

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::mutate::Mutator;
use crate::{Outcome, Target, root};

/// The processor time that an input may take: mostly it is a millisecond or so.
const LONGEST: Duration = Duration::from_secs(5);

/// The processor time of this thread: other programs on a busy machine do not count.
///
/// # Panics
/// The clock of the thread is before its start.
#[must_use]
pub fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::try_from(time).expect("a time since the start")
}

/// The stored corpus of a target.
///
/// # Panics
/// A file of it cannot be read.
#[must_use]
pub fn corpus(target: &Target) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = root().join("tests/corpus").join(target.name);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        // A new target has no corpus yet.
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    // Folders are listed in another order on each machine, and cases depend on the order.
    paths.sort();
    let read = |path: PathBuf| {
        let data = std::fs::read(&path).expect("a stored input");
        (path, data)
    };
    paths.into_iter().map(read).collect()
}

/// Outcomes of many inputs.
#[derive(Debug, Default)]
pub struct Tally {
    taken: usize,
    refused: usize,
    slowest: Duration,
}

impl Tally {
    /// Runs the target over an input of this name.
    ///
    /// # Panics
    /// The target panics or takes too long; the message names a file with the input.
    pub fn examine(&mut self, target: &'static Target, data: &[u8], name: &str) -> Outcome {
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
    std::fs::write(&path, data).expect("a scratch file");
    path.display().to_string()
}

/// Runs a target over mutations of its corpus and its seeds.
///
/// # Panics
/// As [`Tally::examine`].
pub fn mutations(target: &'static Target, cases: usize, seed: u64) -> Tally {
    // Mutations of past failures find their neighbours.
    let inputs: Vec<Vec<u8>> = inputs(target).into_iter().map(|(_, data)| data).collect();
    let mut tally = Tally::default();
    let mut mutator = Mutator::new(seed, target.kind);
    for case in 0..cases {
        let data = mutator.next(&inputs);
        // A refusal is as good as any other outcome.
        let _ = tally.examine(target, &data, &format!("case {case} of seed {seed}"));
    }
    tally
}

/// The corpus of a target and its seeds, each with a name.
#[must_use]
pub fn inputs(target: &Target) -> Vec<(String, Vec<u8>)> {
    let named = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into());
    let stored = corpus(target).into_iter();
    let stored = stored.map(|(path, data)| (named(&path).unwrap_or_default(), data));
    stored.chain((target.seeds)()).collect()
}

/// Runs a target over its stored corpus, and lists the outcomes.
///
/// # Panics
/// As [`Tally::examine`].
#[must_use]
pub fn corpus_outcomes(target: &'static Target) -> String {
    let (mut table, mut tally) = (String::new(), Tally::default());
    for (path, data) in corpus(target) {
        let outcome = tally.examine(target, &data, &path.display().to_string());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let text = match outcome {
            Ok(()) => "taken".to_owned(),
            Err(message) => without_places(&message),
        };
        table += &format!("{}/{name}\n    {text}\n", target.name);
    }
    table
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
