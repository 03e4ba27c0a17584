//! Decision about the frames of a run, by what the run says of its axes.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use coaxle_clock::{Instant, Span};
use coaxle_os::machine::Machine;

/// Number of runs that are known at once: the followed one, and one that takes over.
pub(crate) const RUNS: usize = 2;
/// Time in which a run describes its axes, or is of a client that does not.
// Nodes do so within a quarter of a second, with their first status.
const GRACE: Span = Span::from_secs(1);

/// Runs of a followed node by their descriptions; written by the thread that receives these, and read for each frame.
// Relaxed throughout: a frame that slips through before a change is seen is one of those before it.
#[derive(Default)]
pub(crate) struct DescribedRuns {
    /// True if the config states something that a description may contradict.
    is_stated: AtomicBool,
    /// Runs that agree, and runs that contradict; 0: none. Epochs are random, so that none is 0.
    agree: [AtomicU64; RUNS],
    contradict: [AtomicU64; RUNS],
    /// Run without a description, and the arrival of its first frame.
    waiting: AtomicU64,
    since: AtomicI64,
}

/// Decision about a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameAdmission {
    /// Without a contradiction.
    Pass,
    /// The description of the run is still to come.
    Wait,
    /// The description contradicts the config.
    Refuse,
}

impl DescribedRuns {
    /// Has frames wait for the description of their run.
    pub(crate) fn expect(&self) {
        self.is_stated.store(true, Ordering::Relaxed);
    }

    /// Notes the runs that have described themselves, each with whether it contradicts.
    pub(crate) fn note(&self, runs: &[(u64, bool)]) {
        let noted = |contradicts: bool| runs.iter().filter(move |run| run.1 == contradicts);
        for (cells, contradicts) in [(&self.agree, false), (&self.contradict, true)] {
            let mut epochs = noted(contradicts).map(|(epoch, _)| *epoch);
            for cell in cells {
                cell.store(epochs.next().unwrap_or_default(), Ordering::Relaxed);
            }
        }
    }

    /// Decides about a frame of a run.
    pub(crate) fn admission(&self, epoch: u64, arrival: Instant<Machine>) -> FrameAdmission {
        if !self.is_stated.load(Ordering::Relaxed) || is_in(&self.agree, epoch) {
            return FrameAdmission::Pass;
        }
        if is_in(&self.contradict, epoch) {
            return FrameAdmission::Refuse;
        }
        // Another run of a node that describes its axes waits again; those of a client that does not wait once.
        let describes = !is_in(&self.agree, 0) || !is_in(&self.contradict, 0);
        let waiting = self.waiting.load(Ordering::Relaxed);
        if waiting == 0 || (describes && waiting != epoch) {
            self.waiting.store(epoch, Ordering::Relaxed);
            self.since.store(arrival.as_nanos(), Ordering::Relaxed);
        }
        let since = Instant::from_nanos(self.since.load(Ordering::Relaxed));
        match arrival - since < GRACE {
            true => FrameAdmission::Wait,
            false => FrameAdmission::Pass,
        }
    }
}

fn is_in(cells: &[AtomicU64; RUNS], epoch: u64) -> bool {
    match epoch {
        // Asked for an empty list: true if all cells are empty.
        0 => cells.iter().all(|cell| cell.load(Ordering::Relaxed) == 0),
        epoch => cells
            .iter()
            .any(|cell| cell.load(Ordering::Relaxed) == epoch),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use FrameAdmission::{Pass, Refuse, Wait};

    fn at(millis: i64) -> Instant<Machine> {
        Instant::EPOCH + Span::from_millis(millis)
    }

    #[test]
    fn without_anything_stated_all_pass() {
        let runs = DescribedRuns::default();
        assert_eq!(runs.admission(7, at(0)), Pass);
    }

    #[test]
    fn a_run_waits_for_its_description_and_passes_or_is_refused_by_it() {
        let runs = DescribedRuns::default();
        runs.expect();
        assert_eq!(runs.admission(7, at(0)), Wait);
        runs.note(&[(7, false)]);
        assert_eq!(runs.admission(7, at(1)), Pass);
        // A restart: its description comes later, and contradicts.
        assert_eq!(runs.admission(8, at(5_000)), Wait);
        assert_eq!(runs.admission(8, at(5_900)), Wait);
        runs.note(&[(7, false), (8, true)]);
        assert_eq!(
            (runs.admission(8, at(5_901)), runs.admission(7, at(5_902))),
            (Refuse, Pass)
        );
        // Repaired by another restart.
        runs.note(&[(8, true), (9, false)]);
        assert_eq!(runs.admission(9, at(9_000)), Pass);
    }

    #[test]
    fn a_client_that_does_not_describe_its_axes_passes_after_a_second() {
        let runs = DescribedRuns::default();
        runs.expect();
        assert_eq!(runs.admission(7, at(100)), Wait);
        assert_eq!(runs.admission(7, at(1_099)), Wait);
        assert_eq!(runs.admission(7, at(1_100)), Pass);
        // Once for all of its runs: two that take turns would wait for ever.
        assert_eq!(runs.admission(8, at(1_200)), Pass);
    }
}
