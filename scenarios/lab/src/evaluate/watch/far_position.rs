//! Comparison of a far axis's position with its master's at that instant.

use std::collections::VecDeque;

use coaxle_axis::Modulo;
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::config::Positions;

use super::blending::longest_blending;
use super::far_error::{stated, wanted_offset};
use super::found::{Found, WatchedCycle};
use super::interpolation_error::InterpolationError;
use crate::event::Event;
use crate::invariants::{Invariant, InvariantViolation, WatchedPart};
use crate::row::Row;
use crate::topology::{ReceiverAxis, View};

/// Time after which a change of mode is blended in for certain, in blending times: until then the mode does not define the position.
// A block that falls back meanwhile blends once more, and back again: 0.2 s by default.
const BLENDED: f64 = 10.0 / 3.0;
/// Cycles by which the master's acceleration may appear late: it is taken from differences of its velocity.
const LATE: f64 = 3.0;
/// Most cycles over which a difference of two velocities is the acceleration between them.
const KNOWN_OVER: f64 = 4.5;
/// Rounding error, relative to the position.
const ROUNDING: f64 = 1e-11;

/// Watches the position of a far axis whose master is known.
#[derive(Debug)]
pub(in super::super) struct FarPositionWatch {
    of: WatchedPart,
    cycle_time: f64,
    /// Time after which a change of mode is blended in, s.
    blended: f64,
    /// Period of a position that comes within its turn.
    period: Option<f64>,
    /// Time since which it is in sync without a break, s.
    since: Option<f64>,
    /// Position and velocity of the master in the cycle before, and its time.
    before: Option<[f64; 3]>,
    interpolation: InterpolationError,
    /// Changes of the parameters by orders up to now.
    parameter_changes: u32,
    /// Recent motion of the master.
    lately: VecDeque<Recently>,
    /// Greatest velocity of the master up to now, u/s.
    fastest: f64,
    found: Found,
}

impl FarPositionWatch {
    /// Absent for the receiver's own axes, or one that comes in increments. `events` are those of the whole scenario.
    /// The jerk of the master is at most `jerk`.
    pub(in super::super) fn new(
        config: &ReceiverConfig,
        view: &View,
        events: &[Event],
        jerk: Option<f64>,
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
            blended: BLENDED * longest_blending(config, far, events),
            period: turns.map(Modulo::length),
            since: None,
            before: None,
            interpolation: InterpolationError::new(jerk),
            parameter_changes: 0,
            lately: VecDeque::new(),
            fastest: 0.0,
            found: Found::default(),
        })
    }

    /// Takes the next cycle; `is_known` unless a clock has just jumped. Far time runs at this pace, and may be off by `unnoticed_us` beside
    /// its stated error, as a change of the clocks' rates is not known at once.
    pub(in super::super) fn push(
        &mut self,
        row: &Row,
        pace: f64,
        unnoticed_us: f64,
        is_known: bool,
    ) {
        self.interpolation.note(row);
        let Some((position, velocity)) = row.truth else {
            self.before = None;
            self.since = None;
            // Wide schedule 723586: a sender changed its velocity by 13 u/s while it stood still for 52 ms.
            self.remember(Recently {
                t_s: row.t_s,
                is_unknown: true,
                ..Recently::default()
            });
            return;
        };
        self.learn(row, [position, velocity]);
        let axis = &row.record.axis;
        let (Some(bound), Some(corrected), true) = (stated(row), axis.corrected_position, is_known)
        else {
            self.since = None;
            return;
        };
        // Other parameters begin a blend, too: swarm schedule 80951 was 1.8 µm beside its master for 60 ms.
        let changes = row.record.far.parameter_changes;
        if std::mem::replace(&mut self.parameter_changes, changes) != changes {
            self.since = None;
        }
        let since = *self.since.get_or_insert(row.t_s);
        // Set values of the observer are blended in each time that it begins to lead.
        if row.t_s - since < self.blended {
            return;
        }
        // Nothing is predicted between two frames, nor by a plan.
        let is_certain = [axis.interpolated, axis.planned].contains(&Some(true));
        let predicted = axis.correction_us.filter(|_| !is_certain);
        let age = predicted.unwrap_or_default().abs() * 1e-6;
        let late = (bound + unnoticed_us) * 1e-6;
        // The axis shows its master that much later, at the velocity that it has now.
        let ahead = wanted_offset(row) * 1e-6;
        // Errors and offsets are times of the far clock, in which the master has this velocity. By reference time it has another: swarm
        // schedule 141 was 14.9 ms off at a drift of 750 ppm, and 14 nm beyond v·t.
        let velocity = velocity / pace;
        let MotionSince {
            hardest,
            changed,
            jumped,
            is_unknown,
        } = self.since(row.t_s - age - late - ahead.abs());
        // A time that is off by `late` shows the master at another instant: v·t, with the greatest velocity within that time.
        let by_time = (velocity.abs() + hardest * late) * late;
        // A change within a cycle is averaged over it.
        let over = age.max(self.cycle_time);
        // Extrapolation with the acceleration of the newest frame: a change by Δa since then moves the master by ½·Δa·t².
        // A jump of the master is unknown until its frame comes.
        let by_acceleration = 0.5 * (changed * over * over + hardest * ahead * ahead) + jumped;
        // While the receiver stood still its master was not seen, and what it did meanwhile is bounded by velocities: each may have led
        // the other way all the time. In wide schedule 701866 a master at ±23 u/s turned round twice in 0.6 s of a freeze.
        let by_velocity = match is_unknown {
            true => (self.fastest + shown_velocity(row)) * over,
            false => 0.0,
        };
        let limit = by_time + by_acceleration.max(by_velocity) + self.interpolation.most(row);
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
        self.fastest = self.fastest.max(velocity.abs());
        let mut recently = Recently {
            t_s: row.t_s,
            ..Recently::default()
        };
        if let Some([from, slower, t_s]) = before {
            // Rows after a clock's jump may be closer than a cycle, and a difference over no time is none.
            let passed = (row.t_s - t_s).max(self.cycle_time);
            let way = 0.5 * (slower + velocity) * passed;
            recently.acceleration = (velocity - slower) / passed;
            recently.jump = (position - from - way).abs();
            recently.is_unknown = passed > KNOWN_OVER * self.cycle_time;
        }
        self.remember(recently);
    }

    fn remember(&mut self, recently: Recently) {
        self.lately.push_back(recently);
        let oldest = recently.t_s - LONGEST;
        while (self.lately.front()).is_some_and(|recently| recently.t_s < oldest) {
            self.lately.pop_front();
        }
    }

    /// The master's motion since then. Zero counts among the accelerations, as one of them may be unknown.
    fn since(&self, t_s: f64) -> MotionSince {
        let from = t_s - LATE * self.cycle_time;
        let lately = self.lately.iter().rev();
        let lately = lately.take_while(|recently| recently.t_s >= from);
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        let mut since = MotionSince::default();
        for recently in lately {
            low = low.min(recently.acceleration);
            high = high.max(recently.acceleration);
            since.jumped += recently.jump;
            since.is_unknown |= recently.is_unknown;
        }
        MotionSince {
            // `low` is at most 0 and `high` at least 0, as both begin there.
            hardest: high.max(-low),
            changed: high - low,
            ..since
        }
    }

    pub(in super::super) fn violations(&self) -> impl Iterator<Item = InvariantViolation> {
        self.found.violations(self.of.clone())
    }
}

/// The oldest frame that counts, s.
const LONGEST: f64 = 2.0;

/// Motion of a master from one cycle to the next.
#[derive(Clone, Copy, Debug, Default)]
struct Recently {
    t_s: f64,
    /// Difference of its velocities over the time, u/s².
    acceleration: f64,
    /// The rest of its way beside the trapezoidal rule, u.
    jump: f64,
    /// True if the cycles are so far apart that its motion between them is not known.
    is_unknown: bool,
}

/// Motion of a master since an instant.
#[derive(Clone, Copy, Debug, Default)]
struct MotionSince {
    /// Greatest acceleration, and its change, u/s².
    hardest: f64,
    changed: f64,
    /// Sum of its jumps, u.
    jumped: f64,
    /// True if a part of it is not known.
    is_unknown: bool,
}

/// Greatest velocity with which the axis was moved on from its newest frame, u/s: the acceleration of that fades monotonically.
fn shown_velocity(row: &Row) -> f64 {
    let axis = &row.record.axis;
    let shown = [axis.received_velocity, axis.corrected_velocity];
    shown
        .into_iter()
        .flatten()
        .fold(0.0, |most, velocity| velocity.abs().max(most))
}
