//! The receiver itself: its cycles.

use coaxle_receiver::signals::NodeSignals;

use super::found::{Found, WatchedCycle};
use crate::invariants::Invariant;
use crate::summary::World;

/// Greatest change of a period by a lock, ppm, with a rounding error (docs/CLOCKS.md).
const MOST_PPM: f64 = 500.000_001;

/// Watches the cycles of a receiver.
#[derive(Debug)]
pub(super) struct NodeWatch {
    /// True if every cycle is shown: a process may leave out some when its telemetry is behind.
    shows_all: bool,
    /// The newest one.
    last: Option<NodeSignals>,
    pub(super) found: Found,
}

impl NodeWatch {
    pub(super) fn new(world: World) -> Self {
        Self {
            shows_all: world == World::Virtual,
            last: None,
            found: Found::default(),
        }
    }

    /// Takes the next cycle, whose ideal start is `t_s` after the start of the run, s.
    pub(super) fn push(&mut self, t_s: f64, node: &NodeSignals) -> WatchedCycle {
        let number = node.cycle;
        let last = self.last.replace(*node);
        // Cycles of another run begin at 0 again.
        let last = last.filter(|last| last.run == node.run);
        let since = last.and_then(|last| {
            let passed = number.checked_sub(last.cycle)?;
            // A repeated or an earlier cycle has none before it, so that the other watches restart instead of dividing by 0.
            u32::try_from(passed).ok().filter(|passed| *passed > 0)
        });
        let cycle = WatchedCycle { number, t_s, since };
        let period = node.cycle_period_ppm.unwrap_or_default();
        if period.is_nan() || period.abs() > MOST_PPM {
            (self.found).add(&cycle, Invariant::CyclePeriod, period, MOST_PPM);
        }
        if let Some(last) = last {
            let next = executed(&last) + 1;
            // Skipped cycles raise both numbers alike, so that executed ones are without gaps.
            let is_next = match self.shows_all {
                true => executed(node) == next,
                false => executed(node) >= next,
            };
            if !is_next || node.overruns < last.overruns {
                (self.found).add(
                    &cycle,
                    Invariant::Cycles,
                    executed(node) as f64,
                    next as f64,
                );
            }
        }
        cycle
    }
}

/// Number of cycles executed before this one.
const fn executed(node: &NodeSignals) -> i128 {
    // Signed, as a wrong counter may exceed the cycle number: the violation is to be reported, not a panic.
    node.cycle as i128 - node.overruns as i128
}
