//! Comparison of a far axis's position with its master's at that instant.

use std::collections::VecDeque;

use coaxle_axis::Modulo;
use coaxle_clock::Span;
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::Positions;

use super::far_error::{stated, wanted_offset};
use super::found::{Found, WatchedCycle};
use super::interpolation_error::InterpolationError;
use crate::invariants::{Invariant, InvariantViolation, WatchedPart};
use crate::row::Row;
use crate::topology::{ReceiverAxis, View};

/// Duration of blending after a change of mode, in which the mode does not define the position, s.
// More than three times the default of 0.06 s (`blending-time-s`).
const BLENDED: f64 = 0.2;
/// Cycles by which the master's acceleration may appear late: it is taken from differences of its velocity.
const LATE: f64 = 3.0;
/// Rounding error, relative to the position.
const ROUNDING: f64 = 1e-11;

/// Watches the position of a far axis whose master is known.
#[derive(Debug)]
pub(in super::super) struct FarPositionWatch {
    of: WatchedPart,
    cycle_time: f64,
    /// Period of a position that comes within its turn.
    period: Option<f64>,
    /// Time since which it is in sync without a break, s.
    since: Option<f64>,
    /// Position and velocity of the master in the cycle before, and its time.
    before: Option<[f64; 3]>,
    interpolation: InterpolationError,
    /// Recent accelerations, differences between its positions and its velocities, and times.
    lately: VecDeque<[f64; 3]>,
    found: Found,
}

impl FarPositionWatch {
    /// Absent for the receiver's own axes, or one that comes in increments.
    /// Its master's jerk is at most `jerk`, and it is shown that much `later`.
    pub(in super::super) fn new(
        config: &ReceiverConfig,
        view: &View,
        jerk: Option<f64>,
        later: Span,
    ) -> Option<Self> {
        let ReceiverAxis::Far { axis, .. } = view.of else {
            return None;
        };
        let (_, far, followed) = config.far_axes().nth(axis)?;
        let modulo = followed.modulo.or(far.modulo);
        let turns = modulo.filter(|_| followed.position == Positions::WithinTurn);
        followed.encoder.is_none().then(|| Self {
            of: WatchedPart {
                receiver: config.name.to_string(),
                part: config.far_axis_names().into_iter().nth(axis),
            },
            cycle_time: config.cycle_time_us.0.as_secs_f64(),
            period: turns.map(Modulo::length),
            since: None,
            before: None,
            interpolation: InterpolationError::new(jerk, later),
            lately: VecDeque::new(),
            found: Found::default(),
        })
    }

    /// Takes the next cycle; `is_known` unless a clock has just jumped. Far time may be off by `unnoticed_us` beside its stated error, as
    /// a change of the clocks' rates is not known at once.
    pub(in super::super) fn push(&mut self, row: &Row, unnoticed_us: f64, is_known: bool) {
        self.interpolation.note(row);
        let Some((position, velocity)) = row.truth else {
            self.before = None;
            self.since = None;
            return;
        };
        self.learn(row, [position, velocity]);
        let axis = &row.record.axis;
        let (Some(bound), Some(corrected), true) = (stated(row), axis.corrected_position, is_known)
        else {
            self.since = None;
            return;
        };
        let since = *self.since.get_or_insert(row.t_s);
        // Set values of the observer are blended in each time that it begins to lead.
        if row.t_s - since < BLENDED {
            return;
        }
        // Nothing is predicted between two frames.
        let predicted = axis
            .correction_us
            .filter(|_| axis.interpolated != Some(true));
        let age = predicted.unwrap_or_default().abs() * 1e-6;
        let late = (bound + unnoticed_us) * 1e-6;
        // The axis shows its master that much later, at the velocity that it has now.
        let ahead = wanted_offset(row) * 1e-6;
        let [hardest, changed, jumped] = self.since(row.t_s - age - late - ahead.abs());
        // A time that is off by `late` shows the master at another instant: v·t, with the greatest velocity within that time.
        let by_time = (velocity.abs() + hardest * late) * late;
        // A change within a cycle is averaged over it.
        let over = age.max(self.cycle_time);
        // Extrapolation with the acceleration of the newest frame: a change by Δa since then moves the master by ½·Δa·t².
        // A jump of the master is unknown until its frame comes.
        let predicted = 0.5 * (changed * over * over + hardest * ahead * ahead) + jumped;
        let limit = by_time + predicted + self.interpolation.most(row);
        let beside = corrected - position - velocity * ahead;
        let value = match self.period {
            // Which turn it is in nobody can know of a position within it.
            Some(period) => (beside - period * (beside / period).round()).abs(),
            None => beside.abs(),
        };
        if value > limit + ROUNDING * position.abs() {
            let cycle = WatchedCycle {
                number: row.record.node.cycle,
                t_s: row.t_s,
                since: None,
            };
            (self.found).add(&cycle, Invariant::FarPosition, value, limit);
        }
    }

    /// Notes the master's motion since the cycle before.
    fn learn(&mut self, row: &Row, [position, velocity]: [f64; 2]) {
        let before = self.before.replace([position, velocity, row.t_s]);
        let [acceleration, beside] = before.map_or([0.0; 2], |[from, slower, t_s]| {
            // Rows after a clock's jump may be closer than a cycle, and a difference over no time is none.
            let passed = (row.t_s - t_s).max(self.cycle_time);
            // The rest of the way beside the trapezoidal rule is a jump.
            let way = 0.5 * (slower + velocity) * passed;
            [(velocity - slower) / passed, (position - from - way).abs()]
        });
        self.lately.push_back([acceleration, beside, row.t_s]);
        let oldest = row.t_s - LONGEST;
        while (self.lately.front()).is_some_and(|[.., t_s]| *t_s < oldest) {
            self.lately.pop_front();
        }
    }

    /// The master's motion since then: greatest acceleration, its change, and jump. Zero counts among the accelerations, as
    /// one of them may be unknown.
    fn since(&self, t_s: f64) -> [f64; 3] {
        let from = t_s - LATE * self.cycle_time;
        let lately = self.lately.iter().rev();
        let lately = lately.take_while(|[.., at]| *at >= from);
        let none = (0.0_f64, 0.0_f64, 0.0_f64);
        let (low, high, jumped) = lately.fold(none, |(low, high, jumped), [value, beside, _]| {
            (low.min(*value), high.max(*value), jumped + beside)
        });
        // `low` is at most 0 and `high` at least 0, as the fold begins there.
        [high.max(-low), high - low, jumped]
    }

    pub(in super::super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> {
        self.found.violations(self.of.clone())
    }
}

/// The oldest frame that counts, s.
const LONGEST: f64 = 2.0;
