//! Follows the runs of a subject with the observer and with the simple references.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::peers::{Follower, Observer};
use crate::recorded::{Recording, StampedBy};
use crate::references::{MinimaLine, MinimaServo, RunsRegression};
use crate::scores::{Scope, Score, score};
use crate::world::{Case, Run};

/// The servo's natural frequencies, rad/s. The first is the default.
pub(crate) const BANDWIDTHS: [f64; 4] = [0.2, 0.1, 0.4, 0.8];

/// Part of a recording for starting.
// Enough for all followers to have found their line, also in the short pieces of the repository.
const SKIPPED: f64 = 1.0 / 3.0;

/// Source of arrivals.
#[derive(Clone, Copy)]
pub(crate) enum Subject<'a> {
    Generated(&'a Case),
    Recorded(&'a Recording, StampedBy),
}

impl Subject<'_> {
    fn cycle(self) -> f64 {
        match self {
            Self::Generated(case) => case.cycle,
            Self::Recorded(..) => Recording::CYCLE,
        }
    }

    /// The first seed leaves a recording the usual drift.
    fn run(self, seed: u64, is_first: bool) -> Run {
        match self {
            Self::Generated(case) => Run::new(case, seed),
            Self::Recorded(recording, by) => recording.run(by, seed, is_first),
        }
    }

    fn scope(self) -> Scope {
        match self {
            Self::Generated(case) => Scope::of_case(case),
            Self::Recorded(recording, _) => Scope::undisturbed(recording.cycles(), SKIPPED),
        }
    }
}

/// Scores of one seed.
pub(crate) struct Scores {
    pub(crate) observer: Score,
    pub(crate) line: Score,
    /// Scores for each of the [`BANDWIDTHS`].
    pub(crate) servos: [Score; BANDWIDTHS.len()],
    pub(crate) regression: Score,
}

fn follow(subject: Subject<'_>, run: &Run) -> Scores {
    let (cycle, scope) = (subject.cycle(), subject.scope());
    let of = |follower: &mut dyn Follower| score(follower, run, &scope);
    Scores {
        observer: of(&mut Observer::new(cycle)),
        line: of(&mut MinimaLine::new(cycle)),
        servos: BANDWIDTHS.map(|bandwidth| of(&mut MinimaServo::new(cycle, bandwidth))),
        regression: of(&mut RunsRegression::new(cycle)),
    }
}

/// Follows as many runs as there are seeds, on all cores.
pub(crate) fn all(subject: Subject<'_>, first: u64, seeds: u64) -> Vec<Scores> {
    let next = AtomicU64::new(0);
    let done = Mutex::new(Vec::new());
    let work = || {
        loop {
            // Runs take different times, so each thread takes the next one and not a fixed share.
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= seeds {
                break;
            }
            let run = subject.run(first + number, number == 0);
            let scores = follow(subject, &run);
            done.lock().unwrap().push((number, scores));
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            let _ = scope.spawn(work);
        }
    });
    let mut done = done.into_inner().unwrap();
    // Threads end in any order, and sums of floats depend on it.
    done.sort_by_key(|(number, _)| *number);
    done.into_iter().map(|(_, scores)| scores).collect()
}
