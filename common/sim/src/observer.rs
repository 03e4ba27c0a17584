//! The simulation's interface to observers.

use coaxle_clock::Instant;
use coaxle_clock::cycle::Tick;
use coaxle_node::{Arrival, CommandOutcome};

use crate::true_time::True;

/// A cycle of a node, as seen by the world.
#[derive(Debug)]
pub struct CycleSeen<'a, N> {
    /// Number of the node.
    pub index: usize,
    /// The node, after its cycle.
    pub node: &'a N,
    /// Number and ideal start of the cycle.
    pub tick: Tick,
    /// Ideal start in true time.
    pub ideal_start: Instant<True>,
    /// Actual start in true time.
    pub woke: Instant<True>,
}

/// Observes the world from outside.
pub trait Observer<N> {
    /// Called after every cycle of every node.
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, N>);

    /// Called after every cycle, before [`Self::cycle_seen`], for each measurement that a node took
    /// in during the cycle `tick`, which ideally started at `ideal_start`.
    fn arrived(
        &mut self,
        index: usize,
        ideal_start: Instant<True>,
        tick: &Tick,
        arrival: &Arrival,
    ) {
        let _ = (index, ideal_start, tick, arrival);
    }

    /// Called after every order, with the number under which it was sent.
    fn order_executed(&mut self, number: usize, outcome: &CommandOutcome) {
        let _ = (number, outcome);
    }
}
