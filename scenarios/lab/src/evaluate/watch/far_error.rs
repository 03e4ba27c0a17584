//! Comparison of the error that a receiver states of its corrected time with the true one.

use coaxle_clock::delay::DelayState;
use coaxle_receiver::{FilterMode, ReceiverConfig};

use super::found::{Found, WatchedCycle};
use crate::invariants::{Invariant, InvariantViolation, WatchedPart};
use crate::row::Row;
use crate::topology::{ReceiverAxis, View};

/// Time after a clock's jump in which it cannot be known: older exchanges count for ten seconds, and then the
/// delay is slewed, s.
// `LONGEST_AGE` of an exchange, 10 s, and two seconds for the slew.
const AFTER_A_JUMP: f64 = 12.0;
/// The cycle of the jump may have begun a little earlier, s.
const BEFORE_IT: f64 = 0.1;

/// Tolerance of the constant error of a time without a measured delay, µs, beside the resolution of arrivals: far more than
/// any jitter causes, and far less than a wrong pace adds up to.
// A pace that is wrong by 1000 ppm, a tenth of a percent, gets there in two seconds.
const STEADY: f64 = 2_000.0;
/// Standard deviations that the receiver states of a line that it is unsure of, by which its time may move beside that.
const SURE: f64 = 3.0;
/// Part of the reference's standard deviation from which another one takes its place.
const SURER: f64 = 0.5;
/// Settling time, s.
const SETTLES: f64 = 2.0;

/// Watches the corrected time of a far axis.
#[derive(Debug)]
pub(in super::super) struct FarErrorWatch {
    of: WatchedPart,
    /// Times at which a clock jumps, or restarts, s after the start of the run, which cannot be known beforehand.
    jumps: Vec<f64>,
    /// Greatest deviation from the settled error, µs, with a delay that is not measured; none where delays change.
    steady: Option<f64>,
    settled: Option<SettledError>,
    found: Found,
}

/// A time without a measured delay: it is wrong by a constant.
#[derive(Clone, Copy, Debug)]
struct SettledError {
    /// Time since which no event has restarted it, s.
    since: f64,
    /// Counters of the events that restart it.
    events: [u64; 5],
    /// Error once settled, and its standard deviation as stated then, µs.
    reference: Option<(f64, f64)>,
}

impl FarErrorWatch {
    /// Absent for the receiver's own axes.
    pub(in super::super) fn new(
        config: &ReceiverConfig,
        view: &View,
        jumps: &[f64],
        resolution_us: Option<f64>,
    ) -> Option<Self> {
        let ReceiverAxis::Far { axis, .. } = view.of else {
            return None;
        };
        Some(Self {
            of: WatchedPart {
                receiver: config.name.to_string(),
                part: config.far_axis_names().into_iter().nth(axis),
            },
            jumps: jumps.to_vec(),
            steady: resolution_us.map(|resolution| STEADY + resolution),
            settled: None,
            found: Found::default(),
        })
    }

    /// Checks a cycle: in sync with a measured delay, the error beside the configured offset is at most the uncertainty
    /// and the rest of the slew, and what a change of the clocks' rates adds that cannot be known yet, µs.
    pub(in super::super) fn push(&mut self, row: &Row, unnoticed_us: f64) {
        let Some((error, bound)) = self.judged(row) else {
            return;
        };
        let bound = bound + unnoticed_us;
        // The comparison first: most cycles pass it, and the list of jumps is not searched.
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

    /// Error to judge, and its bound, µs.
    fn judged(&mut self, row: &Row) -> Option<(f64, f64)> {
        let error = row.time_error_us;
        match stated(row) {
            Some(bound) => {
                // Once the delay is measured the constant error is gone. After a loss of it another one begins.
                self.settled = None;
                Some((error? - wanted_offset(row), bound))
            }
            None => {
                let (error, sigma) = self.beside_settled(row)?;
                Some((error, self.steady? + SURE * sigma))
            }
        }
    }

    /// Deviation of the error from its settled value, without the rest of the slew, and its standard deviation as the receiver states it, µs.
    fn beside_settled(&mut self, row: &Row) -> Option<(f64, f64)> {
        let (far, error) = (&row.record.far, row.time_error_us);
        let is_led = far.mode == FilterMode::Observer && row.record.axis.synced;
        let Some(error) = error.filter(|_| is_led && !self.has_jumped(row.t_s)) else {
            self.settled = None;
            return None;
        };
        // The rest of the slew is a known error, such as that of a delay which an order has changed.
        let error = error + far.slew_remaining_us.unwrap_or_default();
        let events = [
            far.shifts.into(),
            far.relocks.into(),
            far.drift_steps.into(),
            far.parameter_changes.into(),
            far.epoch.unwrap_or_default(),
        ];
        // Each of these events may give the line another constant, without any fault.
        let kept = self.settled.filter(|settled| settled.events == events);
        let settled = self.settled.insert(kept.unwrap_or(SettledError {
            since: row.t_s,
            events,
            reference: None,
        }));
        if row.t_s - settled.since < SETTLES {
            return None;
        }
        // The first error after settling is the reference: the delay that is not measured is in it.
        let sigma = far.offset_sigma_us.unwrap_or_default();
        // A surer reference is a better one: an unsure time may move by all that it is unsure of.
        let kept = (settled.reference).filter(|(_, sigma_then)| sigma >= SURER * sigma_then);
        let (first, sigma_then) = *settled.reference.insert(kept.unwrap_or((error, sigma)));
        Some((error - first, sigma + sigma_then))
    }

    /// True if a clock has just jumped.
    pub(in super::super) fn has_jumped(&self, t_s: f64) -> bool {
        let has_jumped = |at: &f64| (at - BEFORE_IT..at + AFTER_A_JUMP).contains(&t_s);
        self.jumps.iter().any(has_jumped)
    }

    pub(in super::super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> {
        self.found.violations(self.of.clone())
    }
}

/// Configured distance of the corrected time from far time, µs.
pub(in super::super) fn wanted_offset(row: &Row) -> f64 {
    row.record.far.time_offset_us.unwrap_or_default()
}

/// Greatest error that the receiver states, µs; none while it states none.
pub(super) fn stated(row: &Row) -> Option<f64> {
    let far = &row.record.far;
    // In another mode the observer runs on beside it, and reports its own error.
    let leads = far.mode == FilterMode::Observer && row.record.axis.synced;
    let says = leads && far.delay_state == Some(DelayState::Measured);
    let uncertainty = far.delay_uncertainty_us.filter(|_| says)?;
    Some(uncertainty + far.slew_remaining_us.unwrap_or_default().abs())
}
