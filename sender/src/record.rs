//! One axis in one sender cycle as a flat row: what trace files hold.

use serde::{Deserialize, Serialize};

use crate::node::SenderSnapshot;

/// A row of a sender's trace: one per shown axis and cycle. Instants are nanoseconds of the world's
/// reference clock: true time in the simulation, the machine's monotonic clock in the real one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SenderRecord {
    /// Ideal start of the cycle, ns.
    pub at_ns: i64,
    /// When the cycle really began, ns.
    pub woke_ns: i64,
    /// This run of the sender.
    pub epoch: u64,
    /// Cycle number, skipped ones counted.
    pub count: u64,
    /// Cycles skipped so far.
    pub overruns: u64,
    /// The axis id.
    pub axis: u32,
    /// Where the axis really is at the ideal start of the cycle, u.
    pub position: f64,
    /// Its velocity, u/s.
    pub velocity: f64,
    /// Its acceleration, u/s².
    pub acceleration: f64,
}

impl SenderRecord {
    /// The rows of a cycle whose ideal start and wake-up the world dates in its own clock.
    pub fn rows(at_ns: i64, woke_ns: i64, snapshot: &SenderSnapshot) -> impl Iterator<Item = Self> {
        let SenderSnapshot {
            epoch,
            count,
            overruns,
            ref axes,
            ..
        } = *snapshot;
        axes.iter().map(move |axis| Self {
            at_ns,
            woke_ns,
            epoch,
            count,
            overruns,
            axis: axis.id,
            position: axis.position,
            velocity: axis.velocity,
            acceleration: axis.acceleration,
        })
    }
}
