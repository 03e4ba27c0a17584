//! Cycles skipped by the nodes themselves: their messages were never sent, and none was lost.
//!
//! A sender that wakes late continues with the count of the cycle that is due, so a receiver cannot distinguish such a gap from
//! a loss (docs/WIRE.md). The run can: it has the overruns of every node.

use std::collections::VecDeque;

use coaxle_receiver::signals::FarNodeSignals;

use crate::scenario::Scenario;
use crate::topology::Topology;

/// Number of changes kept of a node's overruns: late receivers still use frames from before them.
// A late sender that skips in every cycle at 1 ms fills it in a second.
const KEPT: usize = 1_024;

/// Skipped cycles of every node, and those that each receiver counts as lost.
#[derive(Debug)]
pub(super) struct SkippedCycles {
    nodes: Vec<Overruns>,
    /// Followed nodes of each receiver.
    receivers: Vec<Vec<FollowedRun>>,
}

/// The overruns of a node by its cycles.
#[derive(Debug, Default)]
struct Overruns {
    /// Run, cycle, and number of cycles that the run had skipped before that one, at each change.
    changes: VecDeque<(u64, u64, u64)>,
}

/// A node as a receiver follows it.
#[derive(Debug)]
struct FollowedRun {
    /// Number of the node; none if it is no node of the scenario.
    node: Option<usize>,
    /// Followed run: its epoch, and the number of runs before it.
    run: Option<(u64, u64)>,
    /// The messages that were expected of all runs before.
    expected_before: u64,
    /// Cycles skipped by the run up to the newest frame, if known.
    by_newest: Option<u64>,
    skipped: u64,
}

impl SkippedCycles {
    pub(super) fn new(scenario: &Scenario, topology: &Topology) -> Self {
        let nodes = scenario.senders.len() + scenario.receivers.len();
        let receivers = scenario.receivers.iter().map(|receiver| {
            let heard = receiver.received_nodes().into_iter();
            heard
                .map(|heard| FollowedRun::of(topology.node(heard.node)))
                .collect()
        });
        Self {
            receivers: receivers.collect(),
            nodes: std::iter::repeat_with(Overruns::default)
                .take(nodes)
                .collect(),
        }
    }

    /// Takes a cycle of a node, with the number of cycles that its run had skipped before.
    pub(super) fn push_node(&mut self, node: usize, run: u64, cycle: u64, overruns: u64) {
        self.nodes[node].push(run, cycle, overruns);
    }

    /// Takes a cycle of a receiver: the nodes that it follows.
    pub(super) fn push_receiver(&mut self, receiver: usize, far: &[FarNodeSignals]) {
        for (heard, far) in self.receivers[receiver].iter_mut().zip(far) {
            if let Some(node) = heard.node {
                heard.push(far, &self.nodes[node]);
            }
        }
    }

    /// Number of messages that a receiver misses of this node because they were never sent.
    pub(super) fn of(&self, receiver: usize, heard: usize) -> u64 {
        self.receivers[receiver][heard].skipped
    }
}

impl Overruns {
    fn push(&mut self, run: u64, cycle: u64, overruns: u64) {
        // Only changes are kept: most nodes never skip, and have one entry for each run.
        let is_known = |(of, _, known): &(u64, u64, u64)| (*of, *known) == (run, overruns);
        if self.changes.back().is_some_and(is_known) {
            return;
        }
        if self.changes.len() == KEPT {
            self.changes.pop_front();
        }
        self.changes.push_back((run, cycle, overruns));
    }

    /// Number of cycles that a run had skipped before this one; none if no longer known.
    fn before(&self, run: u64, cycle: u64) -> Option<u64> {
        // The newest first: frames in use are seldom older than a few changes.
        let mut changes = self.changes.iter().rev();
        let known = changes.find(|(of, since, _)| *of == run && *since <= cycle);
        known.map(|(.., overruns)| *overruns)
    }
}

impl FollowedRun {
    const fn of(node: Option<usize>) -> Self {
        Self {
            node,
            run: None,
            expected_before: 0,
            by_newest: None,
            skipped: 0,
        }
    }

    fn push(&mut self, far: &FarNodeSignals, overruns: &Overruns) {
        let (Some(epoch), Some(count)) = (far.epoch, far.count) else {
            return;
        };
        let run = Some((epoch, far.restarts));
        if self.run != run {
            self.run = run;
            let of_run = far.expected.saturating_sub(self.expected_before);
            // The first cycle of the run that the receiver expected: cycles skipped before it were never expected, and never lost.
            let first = (count + 1).saturating_sub(of_run);
            self.by_newest = overruns.before(epoch, first);
        }
        let by_newest = overruns.before(epoch, count);
        if let (Some(before), Some(now)) = (self.by_newest, by_newest) {
            self.skipped += now.saturating_sub(before);
        }
        // Rows of a process may come later than its frames: the last known number waits for them.
        self.by_newest = by_newest.or(self.by_newest);
        self.expected_before = far.expected;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(epoch: u64, count: u64, restarts: u64, expected: u64) -> FarNodeSignals {
        FarNodeSignals {
            epoch: Some(epoch),
            count: Some(count),
            restarts,
            expected,
            ..FarNodeSignals::default()
        }
    }

    #[test]
    fn what_a_run_skipped_between_its_first_and_its_newest_frame_counts() {
        let (mut overruns, mut node) = (Overruns::default(), FollowedRun::of(Some(0)));
        // Four cycles before anybody hears it, and later another three.
        for (cycle, skipped) in [(0, 0), (1, 0), (6, 4), (7, 4), (8, 4), (12, 7), (13, 7)] {
            overruns.push(1, cycle, skipped);
        }
        for (count, expected) in [(7, 1), (8, 2), (12, 6), (13, 7)] {
            node.push(&heard(1, count, 0, expected), &overruns);
        }
        assert_eq!(node.skipped, 3);
        // Another run, which skipped five; the receiver hears of it from its third cycle on.
        for (cycle, skipped) in [(0, 0), (1, 0), (2, 0), (8, 5)] {
            overruns.push(2, cycle, skipped);
        }
        // Expected from its third cycle on: 2 to 8, seven more than the seven of the run before.
        node.push(&heard(2, 8, 1, 7 + 7), &overruns);
        assert_eq!(node.skipped, 8);
    }

    #[test]
    fn what_is_not_known_is_made_up_for_as_soon_as_it_is() {
        let (mut overruns, mut node) = (Overruns::default(), FollowedRun::of(Some(0)));
        overruns.push(1, 0, 0);
        node.push(&heard(1, 0, 0, 1), &overruns);
        // A process whose rows come late.
        node.push(&heard(1, 9, 0, 10), &overruns);
        assert_eq!(node.skipped, 0);
        overruns.push(1, 8, 6);
        node.push(&heard(1, 10, 0, 11), &overruns);
        assert_eq!(node.skipped, 6);
    }
}
