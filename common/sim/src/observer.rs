//! What the simulation shows to whoever watches it.

use coaxle_clock::Instant;
use coaxle_clock::cycle::Tick;
use coaxle_node::{Arrival, CommandOutcome};

use crate::true_time::True;

/// One cycle of a node, as the world saw it.
#[derive(Debug)]
pub struct CycleSeen<'a, N> {
    /// Number of the node.
    pub index: usize,
    /// The node, after its cycle.
    pub node: &'a N,
    /// Which cycle it was.
    pub tick: Tick,
    /// When that ideally started, in true time.
    pub ideal_start: Instant<True>,
    /// When it really did.
    pub woke: Instant<True>,
}

/// Watches the world from outside.
pub trait Observer<N> {
    /// After every cycle of every node.
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, N>);

    /// After every cycle, before [`Self::cycle_seen`]: each thing that a node took in during the cycle
    /// `tick`, which ideally started at `ideal_start`.
    fn arrived(
        &mut self,
        index: usize,
        ideal_start: Instant<True>,
        tick: &Tick,
        arrival: &Arrival,
    ) {
        let _ = (index, ideal_start, tick, arrival);
    }

    /// After every order, with the number it was sent under.
    fn order_executed(&mut self, number: usize, outcome: &CommandOutcome) {
        let _ = (number, outcome);
    }
}
