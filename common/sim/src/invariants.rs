//! What must hold of every node, whatever it does.

use coaxle_clock::cycle::Turn;
use coaxle_clock::{Instant, Local};
use coaxle_node::Node;

/// A node that broke the contract.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Which node.
    pub node: String,
    /// What it did.
    pub what: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "node {}: {}", self.node, self.what)
    }
}

impl std::error::Error for Violation {}

/// Watches one node.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch {
    last: Option<Turn>,
}

impl Watch {
    /// After a cycle at local time `now`.
    pub(crate) fn check<N: Node>(
        &mut self,
        name: &str,
        node: &N,
        turn: Turn,
        now: Instant<Local>,
    ) -> Result<(), Violation> {
        let violation = |what: String| Violation {
            node: name.to_owned(),
            what,
        };
        if let Some(last) = self.last.replace(turn) {
            if turn.count != last.count + u64::from(turn.elapsed) {
                return Err(violation(format!(
                    "cycle {} came {} after cycle {}",
                    turn.count, turn.elapsed, last.count
                )));
            }
            if turn.ideal_start <= last.ideal_start {
                return Err(violation(format!("cycle {} goes back in time", turn.count)));
            }
        }
        if node.next_cycle() <= turn.ideal_start {
            return Err(violation(format!(
                "the cycle after {} is due no later than it",
                turn.count
            )));
        }
        // A node that would be due at once again would catch up with a burst.
        if node.next_cycle() <= now {
            return Err(violation(format!(
                "the cycle after {} is due at {:?}, already past at {now:?}",
                turn.count,
                node.next_cycle()
            )));
        }
        Ok(())
    }
}
