//! What a receiver says of how wrong its corrected time is, against how wrong it is.

use coaxle_clock::delay::DelayState;
use coaxle_receiver::{ReceiverConfig, StateName};

use super::found::{Found, WatchedCycle};
use crate::invariants::{Invariant, InvariantViolation, Watched};
use crate::row::Row;
use crate::topology::{View, Viewed};

/// Nobody can know of a clock that jumped: of what was measured before, exchanges count for ten seconds, and then
/// the delay is slewed, s.
const AFTER_A_JUMP: f64 = 12.0;
/// The cycle in which it jumps may have begun a little earlier, s.
const BEFORE_IT: f64 = 0.1;

/// Watches the corrected time of a far axis.
#[derive(Debug)]
pub(in super::super) struct FarErrorWatch {
    of: Watched,
    /// When a clock jumps, or begins anew, s after the start of the run: what nobody can know beforehand.
    jumps: Vec<f64>,
    found: Found,
}

impl FarErrorWatch {
    /// None of one of the receiver's own axes.
    pub(in super::super) fn new(
        config: &ReceiverConfig,
        view: &View,
        jumps: &[f64],
    ) -> Option<Self> {
        let Viewed::Far { axis, .. } = view.of else {
            return None;
        };
        Some(Self {
            of: Watched {
                receiver: config.name.to_string(),
                part: config.far_axis_names().into_iter().nth(axis),
            },
            jumps: jumps.to_vec(),
            found: Found::default(),
        })
    }

    /// In sync with a measured delay it is wrong by its uncertainty at most, and by what it says is still to be made up.
    pub(in super::super) fn push(&mut self, row: &Row) {
        let (Some(error), Some(bound)) = (row.time_error_us, stated(row)) else {
            return;
        };
        let has_jumped = |at: &f64| (at - BEFORE_IT..at + AFTER_A_JUMP).contains(&row.t_s);
        if error.abs() <= bound || self.jumps.iter().any(has_jumped) {
            return;
        }
        let cycle = WatchedCycle {
            number: row.record.node.cycle,
            t_s: row.t_s,
            since: None,
        };
        (self.found).add(&cycle, Invariant::FarError, error.abs(), bound);
    }

    pub(in super::super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> {
        self.found.violations(self.of.clone())
    }
}

/// How wrong it is at most, as it says, µs; none while it says nothing of it.
fn stated(row: &Row) -> Option<f64> {
    let far = &row.record.far;
    // In another mode the observer runs on beside it, and says what would be.
    let leads = far.mode == StateName::Observer && row.record.axis.synced;
    let says = leads && far.delay_state == Some(DelayState::Measured);
    let uncertainty = far.delay_uncertainty_us.filter(|_| says)?;
    Some(uncertainty + far.slew_remaining_us.unwrap_or_default().abs())
}
