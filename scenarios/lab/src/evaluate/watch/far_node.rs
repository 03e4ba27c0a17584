//! A node that is received: the accounts of its messages, and its runs.

use coaxle_node::keys::NodeName;
use coaxle_receiver::signals::FarNodeSignals;

use super::found::{Found, WatchedCycle};
use crate::invariants::Invariant;

/// Watches a node that is received.
#[derive(Debug)]
pub(super) struct FarNodeWatch {
    pub(super) name: String,
    run: Option<FollowedRun>,
    pub(super) found: Found,
}

/// A run of it that is followed.
#[derive(Clone, Copy, Debug)]
struct FollowedRun {
    epoch: u64,
    /// Number of runs followed before it when it was first shown.
    restarts: u64,
}

impl FarNodeWatch {
    pub(super) fn new(name: &NodeName) -> Self {
        Self {
            name: name.to_string(),
            run: None,
            found: Found::default(),
        }
    }

    pub(super) fn push(&mut self, cycle: &WatchedCycle, far: &FarNodeSignals) {
        self.watch_run(cycle, far);
        for [shown, expected] in accounts(far) {
            if shown != expected {
                (self.found).add(cycle, Invariant::Messages, shown as f64, expected as f64);
            }
        }
    }

    fn watch_run(&mut self, cycle: &WatchedCycle, far: &FarNodeSignals) {
        // A receiver that was restarted counts restarts from 0 again.
        if cycle.since.is_none() {
            self.run = None;
        }
        let Some(epoch) = far.epoch else {
            return;
        };
        let run = FollowedRun {
            epoch,
            restarts: far.restarts,
        };
        match self.run {
            // Restarts may be counted before the first frame of the next run is used, so only another epoch is compared.
            Some(before) if before.epoch == epoch => return,
            Some(before) if before.restarts >= run.restarts => {
                let next = before.restarts + 1;
                (self.found).add(cycle, Invariant::Owner, run.restarts as f64, next as f64);
            }
            _ => {}
        }
        self.run = Some(run);
    }
}

/// Pairs of equal sums: of the messages that came, and of those that should have.
fn accounts(far: &FarNodeSignals) -> [[u128; 2]; 2] {
    // Wide enough for any counters: a sum that wraps would hide what is missing.
    let sum = |all: &[u64]| all.iter().map(|one| u128::from(*one)).sum();
    let came = [
        far.in_order,
        far.duplicates,
        far.late,
        far.waiting.into(),
        far.overflow,
        far.foreign_frames,
    ];
    // Duplicates and foreign frames were never expected. An outdated message was expected no more, but came.
    let due = [far.in_order, far.late, far.lost];
    let known = [far.expected, far.outdated];
    [[sum(&came), far.received.into()], [sum(&due), sum(&known)]]
}
