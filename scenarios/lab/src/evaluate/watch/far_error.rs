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

/// A time without a measured delay is wrong by a constant, to this, µs, and what arrivals are rounded to: far more than any jitter
/// makes of it, and far less than one that passes at the wrong pace comes to.
const STEADY: f64 = 2_000.0;
/// It has settled after so long, s.
const SETTLES: f64 = 2.0;

/// Watches the corrected time of a far axis.
#[derive(Debug)]
pub(in super::super) struct FarErrorWatch {
    of: Watched,
    /// When a clock jumps, or begins anew, s after the start of the run: what nobody can know beforehand.
    jumps: Vec<f64>,
    /// How far it may go away from where it was once settled, µs, with a delay that nobody measures; none where delays change.
    steady: Option<f64>,
    settled: Option<Settled>,
    found: Found,
}

/// A time without a measured delay: it is wrong by a constant.
#[derive(Clone, Copy, Debug)]
struct Settled {
    /// Since when nothing has begun again, s.
    since: f64,
    /// What has begun again how often.
    events: [u64; 5],
    /// How wrong it was once it had settled, µs.
    error: Option<f64>,
}

impl FarErrorWatch {
    /// None of one of the receiver's own axes.
    pub(in super::super) fn new(
        config: &ReceiverConfig,
        view: &View,
        jumps: &[f64],
        resolution_us: Option<f64>,
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
            steady: resolution_us.map(|resolution| STEADY + resolution),
            settled: None,
            found: Found::default(),
        })
    }

    /// In sync with a measured delay it is wrong by its uncertainty at most, and by what it says is still to be made up.
    pub(in super::super) fn push(&mut self, row: &Row) {
        let Some((error, bound)) = self.judged(row) else {
            return;
        };
        if error.abs() <= bound || self.has_jumped(row.t_s) {
            return;
        }
        let cycle = WatchedCycle {
            number: row.record.node.cycle,
            t_s: row.t_s,
            since: None,
        };
        (self.found).add(&cycle, Invariant::FarError, error.abs(), bound);
    }

    /// What is judged, and how large it may be, µs.
    fn judged(&mut self, row: &Row) -> Option<(f64, f64)> {
        let error = row.time_error_us;
        match stated(row) {
            Some(bound) => {
                self.settled = None;
                Some((error?, bound))
            }
            None => self.beside_settled(row).zip(self.steady),
        }
    }

    /// How far the time is from where it was once it had settled, µs, but for what is still to be made up.
    fn beside_settled(&mut self, row: &Row) -> Option<f64> {
        let (far, error) = (&row.record.far, row.time_error_us);
        let is_led = far.mode == StateName::Observer && row.record.axis.synced;
        let Some(error) = error.filter(|_| is_led && !self.has_jumped(row.t_s)) else {
            self.settled = None;
            return None;
        };
        let error = error + far.slew_remaining_us.unwrap_or_default();
        let events = [
            far.shifts.into(),
            far.relocks.into(),
            far.drift_steps.into(),
            far.parameter_changes.into(),
            far.epoch.unwrap_or_default(),
        ];
        let kept = self.settled.filter(|settled| settled.events == events);
        let settled = self.settled.insert(kept.unwrap_or(Settled {
            since: row.t_s,
            events,
            error: None,
        }));
        if row.t_s - settled.since < SETTLES {
            return None;
        }
        Some(error - *settled.error.get_or_insert(error))
    }

    /// Whether a clock has just jumped.
    pub(in super::super) fn has_jumped(&self, t_s: f64) -> bool {
        let has_jumped = |at: &f64| (at - BEFORE_IT..at + AFTER_A_JUMP).contains(&t_s);
        self.jumps.iter().any(has_jumped)
    }

    pub(in super::super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> {
        self.found.violations(self.of.clone())
    }
}

/// How wrong it is at most, as it says, µs; none while it says nothing of it.
pub(super) fn stated(row: &Row) -> Option<f64> {
    let far = &row.record.far;
    // In another mode the observer runs on beside it, and says what would be.
    let leads = far.mode == StateName::Observer && row.record.axis.synced;
    let says = leads && far.delay_state == Some(DelayState::Measured);
    let uncertainty = far.delay_uncertainty_us.filter(|_| says)?;
    Some(uncertainty + far.slew_remaining_us.unwrap_or_default().abs())
}
