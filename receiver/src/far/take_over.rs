//! The choice of one of several nodes with the same axes: one decision, as for the run of each.
//!
//! The node that is followed is kept as long as it is received. When it has been silent for its
//! timeout, the first of the list that is received without such a gap and has a known clock takes
//! over, and is kept likewise: one that returns is a standby. Before its data are too old, any
//! received one is better than none. So there is no alternation between two that are received, and
//! a receiver that received none continues with its previous node.

use coaxle_clock::{Instant, Local, Span};

/// Waiting time for a node that was never received: all may be starting.
const NEVER_HEARD: Span = Span::from_secs(1);

/// Times at which a node was received.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Presence {
    newest: Option<Instant<Local>>,
    /// Time since when there was no gap.
    since: Option<Instant<Local>>,
}

impl Presence {
    /// Notes a message that arrived at `at`. A time longer than `patience` is a gap.
    pub(super) fn heard(&mut self, at: Instant<Local>, patience: Span) {
        let is_gap = self.newest.is_none_or(|newest| at - newest > patience);
        if is_gap {
            self.since = Some(at);
        }
        // An overtaken message does not move it back. None is the least of all.
        self.newest = self.newest.max(Some(at));
    }

    /// Time since its last message; none before the first.
    pub(super) fn silence(&self, now: Instant<Local>) -> Option<Span> {
        Some(now - self.newest?)
    }

    /// True if it is received, and has been for at least `patience`.
    pub(super) fn is_steady(&self, now: Instant<Local>, patience: Span) -> bool {
        // Both ends: received now, and for a while. A node that flickers is no better than the one that it would
        // replace.
        let is_heard = self.silence(now).is_some_and(|silence| silence <= patience);
        is_heard && self.since.is_some_and(|since| now - since >= patience)
    }

    fn is_steady_for(&self, now: Instant<Local>, length: Span) -> bool {
        self.since.is_some_and(|since| now - since >= length)
    }
}

/// Properties of a node for the decision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    pub(super) presence: Presence,
    /// Timeout of its silence.
    pub(super) patience: Span,
    /// Length of its silence after which a node with an unknown clock may take over: soon slaves
    /// would lose their master.
    pub(super) longest: Span,
    /// True if its axes are there in this very cycle.
    pub(super) has_axes: bool,
    /// True if its clock is known.
    pub(super) is_known: bool,
}

/// The decision.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TakeOver {
    followed: usize,
    count: u64,
}

impl TakeOver {
    /// Place of the node that is followed.
    pub(super) const fn followed(&self) -> usize {
        self.followed
    }

    /// Number of take-overs.
    pub(super) const fn count(&self) -> u64 {
        self.count
    }

    /// Decides in a cycle that ideally began at `now`, with all of them, in the order of the list.
    /// Returns the previously followed one, if it is another from now on.
    pub(super) fn decide(
        &mut self,
        now: Instant<Local>,
        mut nodes: impl Iterator<Item = Standing> + Clone,
    ) -> Option<usize> {
        let followed = nodes.clone().nth(self.followed)?;
        let silence = followed.presence.silence(now);
        // First of all: a node that is received is never left, so that two of them cannot alternate.
        if silence.is_some_and(|silence| silence <= followed.patience) {
            return None;
        }
        let is_there = |node: &Standing| {
            let is_steady = node.presence.is_steady(now, node.patience);
            // A node that was never received may just be starting.
            let is_waited = silence.is_some() || node.presence.is_steady_for(now, NEVER_HEARD);
            node.has_axes && is_steady && is_waited
        };
        // A node with an unknown clock costs a start-up, so it waits until the alternative is a lost master.
        let is_long = silence.is_none_or(|silence| silence > followed.longest);
        // Two passes over the list: a known clock further down goes before an unknown one further up.
        let next = (nodes.clone())
            .position(|node| node.is_known && is_there(&node))
            .or_else(|| nodes.position(|node| is_long && is_there(&node)))?;
        self.count += 1;
        Some(std::mem::replace(&mut self.followed, next))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Span = Span::from_millis(10);

    /// Nodes that are received every millisecond, or are not.
    struct Nodes {
        now: i64,
        decision: TakeOver,
        standings: Vec<Standing>,
    }

    impl Nodes {
        fn new(count: usize) -> Self {
            let standing = Standing {
                presence: Presence::default(),
                patience: PATIENCE,
                longest: PATIENCE * 10,
                has_axes: true,
                is_known: true,
            };
            Self {
                now: 0,
                decision: TakeOver::default(),
                standings: vec![standing; count],
            }
        }

        /// Runs for this number of milliseconds in which these are received; returns the take-overs
        /// and their times.
        fn run(&mut self, millis: i64, heard: &[usize]) -> Vec<(i64, usize)> {
            let mut taken = Vec::new();
            for _ in 0..millis {
                self.now += 1;
                let now = Instant::EPOCH + Span::from_millis(self.now);
                for node in heard {
                    self.standings[*node].presence.heard(now, PATIENCE);
                }
                let before = self.decision.followed();
                if let Some(old) = self.decision.decide(now, self.standings.iter().copied()) {
                    assert_eq!(old, before);
                    taken.push((self.now, self.decision.followed()));
                }
            }
            taken
        }
    }

    #[test]
    fn the_next_takes_over_when_the_first_is_silent_and_keeps_on_when_it_is_back() {
        let mut nodes = Nodes::new(2);
        assert_eq!(nodes.run(1_000, &[0, 1]), []);
        assert_eq!(nodes.run(100, &[1]), [(1_011, 1)]);
        assert_eq!(nodes.run(1_000, &[0, 1]), []);
        assert_eq!(nodes.run(100, &[0]), [(2_111, 0)]);
        assert_eq!(nodes.decision.count(), 2);
    }

    #[test]
    fn the_first_of_the_list_that_is_ready_and_steady_takes_over() {
        let mut nodes = Nodes::new(4);
        nodes.standings[1].is_known = false;
        nodes.run(1_000, &[0, 1, 2, 3]);
        // The third one is missing for a while.
        nodes.run(20, &[0, 1, 3]);
        nodes.run(3, &[0, 1, 2, 3]);
        assert_eq!(nodes.run(50, &[1, 2, 3]), [(1_034, 2)], "heard for 10 ms");
        nodes.standings[1].is_known = true;
        assert_eq!(nodes.run(1_000, &[1, 2, 3]), [], "the second one waits");
        assert_eq!(nodes.run(50, &[1, 3]), [(2_084, 1)]);
    }

    #[test]
    fn when_nobody_was_heard_the_one_that_was_followed_is_again() {
        let mut nodes = Nodes::new(2);
        nodes.run(1_000, &[0, 1]);
        assert_eq!(nodes.run(500, &[]), []);
        // The other one returns first, but only slightly.
        assert_eq!(nodes.run(5, &[1]), []);
        assert_eq!(nodes.run(1_000, &[0, 1]), []);
        assert_eq!(nodes.run(500, &[]), []);
        assert_eq!(nodes.run(100, &[1]).len(), 1);
    }

    #[test]
    fn one_whose_clock_is_not_known_is_better_than_none() {
        let mut nodes = Nodes::new(3);
        nodes.standings[1].has_axes = false;
        nodes.standings[2].is_known = false;
        nodes.run(1_000, &[0, 1, 2]);
        assert_eq!(nodes.run(2_000, &[1, 2]), [(1_101, 2)]);
    }

    #[test]
    fn one_that_was_never_heard_is_waited_for() {
        let mut nodes = Nodes::new(2);
        assert_eq!(nodes.run(900, &[1]), []);
        assert_eq!(nodes.run(500, &[0, 1]), []);
        let mut nodes = Nodes::new(2);
        assert_eq!(nodes.run(2_000, &[1]), [(1_001, 1)]);
    }
}
