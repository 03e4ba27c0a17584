//! Invariants of every node.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local};
use coaxle_node::Node;

/// A node that broke the contract.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("node {node}: {breach}")]
pub struct Violation {
    /// Name of the node.
    pub node: String,
    /// Breach of the contract.
    pub breach: Breach,
}

/// Breach of the contract by a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Breach {
    /// Cycle count that ignores cycles, skipped ones included.
    #[error("cycle {count} came {elapsed} after cycle {last}")]
    Miscounted {
        /// The cycle before.
        last: u64,
        /// Current cycle.
        count: u64,
        /// Number of cycles reported as passed.
        elapsed: u32,
    },
    /// Cycle that ideally starts no later than the one before.
    #[error("cycle {count} goes back in time")]
    BackInTime {
        /// The cycle.
        count: u64,
    },
    /// Next cycle that ideally starts no later than this one.
    #[error("the cycle after {count} is due no later than it")]
    NextNotLater {
        /// Current cycle.
        count: u64,
    },
    /// Next cycle due before the end of this one: the node would catch up with a burst.
    #[error("the cycle after {count} is due at {due:?}, already past at {now:?}")]
    NextIsPast {
        /// Current cycle.
        count: u64,
        /// Due time of the next cycle.
        due: Instant<Local>,
        /// End of this cycle.
        now: Instant<Local>,
    },
}

/// Monitors one node.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    last: Option<Tick>,
}

impl Watch {
    /// Checks a cycle at local time `now`.
    pub(crate) fn check<N: Node>(
        &mut self,
        name: &str,
        node: &N,
        tick: Tick,
        now: Instant<Local>,
    ) -> Result<(), Violation> {
        let last = self.last.replace(tick);
        breach(last, tick, node.next_cycle(), now).map_or(Ok(()), |breach| {
            Err(Violation {
                node: name.to_owned(),
                breach,
            })
        })
    }
}

/// Breach in a cycle, given the one before and the due time of the next.
fn breach(
    last: Option<Tick>,
    tick: Tick,
    due: Instant<Local>,
    now: Instant<Local>,
) -> Option<Breach> {
    let Tick { count, elapsed, .. } = tick;
    if let Some(last) = last {
        // The count first: with a wrong one the times say nothing.
        if count != last.count + u64::from(elapsed) {
            let last = last.count;
            return Some(Breach::Miscounted {
                last,
                count,
                elapsed,
            });
        }
        if tick.ideal_start <= last.ideal_start {
            return Some(Breach::BackInTime { count });
        }
    }
    if due <= tick.ideal_start {
        return Some(Breach::NextNotLater { count });
    }
    // Checked last, because a due time before this cycle's own start is past as well and deserves its own name.
    (due <= now).then_some(Breach::NextIsPast { count, due, now })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Instant<Local> {
        Instant::from_nanos(millis * 1_000_000)
    }

    fn tick(count: u64, elapsed: u32, ideal_start: i64) -> Tick {
        Tick {
            count,
            ideal_start: at(ideal_start),
            elapsed,
        }
    }

    /// Breach of `tick` after cycle 4 at 40 ms, at 55 ms, with the next cycle due at `due`.
    fn after_four(tick: Tick, due: i64) -> Option<Breach> {
        breach(Some(self::tick(4, 1, 40)), tick, at(due), at(55))
    }

    #[test]
    fn a_cycle_after_another_is_right() {
        assert_eq!(after_four(tick(5, 1, 50), 60), None);
        assert_eq!(after_four(tick(7, 3, 41), 56), None);
        let first = tick(9, 3, 50);
        assert_eq!(breach(None, first, at(60), at(55)), None);
    }

    #[test]
    fn cycles_are_counted() {
        for (count, elapsed) in [(5, 2), (5, 0), (6, 1), (4, 1), (3, 1), (7, 2)] {
            let expected = Breach::Miscounted {
                last: 4,
                count,
                elapsed,
            };
            assert_eq!(after_four(tick(count, elapsed, 50), 60), Some(expected));
        }
    }

    #[test]
    fn each_cycle_ideally_starts_later_than_the_one_before() {
        let expected = Some(Breach::BackInTime { count: 5 });
        assert_eq!(after_four(tick(5, 1, 40), 60), expected);
        assert_eq!(after_four(tick(5, 1, 39), 60), expected);
        assert_eq!(
            after_four(tick(4, 0, 40), 60),
            Some(Breach::BackInTime { count: 4 })
        );
    }

    #[test]
    fn the_next_cycle_is_due_after_this_one_and_after_now() {
        let not_later = Some(Breach::NextNotLater { count: 5 });
        assert_eq!(after_four(tick(5, 1, 57), 57), not_later);
        assert_eq!(after_four(tick(5, 1, 50), 49), not_later);
        let is_past = |due| {
            let (due, now) = (at(due), at(55));
            Some(Breach::NextIsPast { count: 5, due, now })
        };
        assert_eq!(after_four(tick(5, 1, 50), 55), is_past(55));
        assert_eq!(after_four(tick(5, 1, 50), 51), is_past(51));
        assert_eq!(breach(None, tick(5, 1, 50), at(54), at(55)), is_past(54));
    }

    #[test]
    fn a_violation_names_the_node_and_the_cycle() {
        let violation = Violation {
            node: "saw".to_owned(),
            breach: Breach::BackInTime { count: 5 },
        };
        assert_eq!(violation.to_string(), "node saw: cycle 5 goes back in time");
    }
}
