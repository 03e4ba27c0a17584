//! What a target does, as far as it can be known.

use coaxle_curve::profile::Kinematics;

use super::differences::Differences;
use super::envelope::{Envelope, PACE, ROUNDING};

/// The positions of a target, and what it states of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    series: Differences,
    /// The position before the last, u, and how many cycles ago that was.
    from: f64,
    gap: f64,
    stated: Kinematics,
    /// Cycles in a row in which it did not go as it states.
    beside: u8,
    last_position: f64,
}

/// What a target is taken to do: its mean velocity of the last cycle, u/s, and its acceleration, u/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Course {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// The most by which velocities of a target are beside its positions, as a share of the change of its acceleration in a cycle: an eighth,
/// and four times that for what is stated beside an acceleration that begins within a cycle. Without it, a velocity passed that was 130 %
/// beside its positions where the limits mean "none" (wide schedule 4128).
const CHANGE: f64 = 0.5;

/// A motion may begin and end within a cycle, and positions say little of that; those of one that states what it does not do are
/// beside it again in the next.
const BESIDE: u8 = 3;

/// Over so many cycles differences still tell where a target is going.
const MOST_MISSING: f64 = 4.0;

impl Target {
    pub(super) fn at(state: &Kinematics, cycle_time: f64) -> Self {
        Self {
            series: Differences::up_to(state, cycle_time),
            from: state.position,
            gap: 1.0,
            stated: *state,
            beside: 0,
            last_position: state.position,
        }
    }

    /// The next one, so many cycles later. After one that is no number it takes three more until the
    /// differences are numbers again.
    pub(super) fn then(&self, next: &Kinematics, cycles: f64, rate: f64) -> Self {
        let last_position = if next.position.is_finite() {
            next.position
        } else {
            self.last_position
        };
        let series = self.series.then(next.position, cycles, rate);
        let is_known = cycles == 1.0 && self.gap == 1.0;
        Self {
            series,
            from: self.series.position,
            gap: cycles,
            stated: *next,
            beside: match is_known && !self.goes_on(next, &series, rate) {
                true => self.beside.saturating_add(1),
                false => 0,
            },
            last_position,
        }
    }

    /// Tells a target whose way in a cycle is the mean of the velocities that are stated at its ends.
    ///
    /// That holds of a motion to an eighth of what the acceleration changes by (the trapezoidal rule): by as much as is stated, or
    /// as positions show. A far axis that is blended, or that jumps, states neither.
    fn goes_on(&self, next: &Kinematics, series: &Differences, rate: f64) -> bool {
        let mean = 0.5 * (self.stated.velocity + next.velocity);
        let stated = (next.acceleration - self.stated.acceleration).abs();
        let seen = series.jerk.abs().max(self.series.jerk.abs()) / rate;
        let rounding = 2.0 * ROUNDING * series.position.abs() * rate;
        let most = CHANGE * (stated + seen) / rate + PACE * series.velocity.abs() + rounding;
        (series.velocity - mean).abs() <= most
    }

    /// Tells a target whose newest positions are where its stated velocities have it.
    pub(super) const fn is_consistent(&self) -> bool {
        self.beside < BESIDE
    }

    /// The last position that was a number, u.
    pub(super) const fn last_position(&self) -> f64 {
        self.last_position
    }

    /// Its positions decide. Where they jump, or too many of them are missing, there is nothing but what it states.
    pub(super) fn course(&self, envelope: &Envelope) -> Course {
        if self.gap <= MOST_MISSING && envelope.is_motion(&self.series, self.from) {
            Course {
                velocity: self.series.velocity_of_cycle(envelope.cycle_time),
                acceleration: self.series.acceleration,
            }
        } else {
            self.stated_course(envelope)
        }
    }

    /// Where it was so many cycles before its last position, as far as can be known, and on what course: on the one that it
    /// is on now, but no farther than it has come since the position before.
    pub(super) fn before(&self, cycles: f64, course: &Course, cycle_time: f64) -> (f64, Course) {
        let last = self.series.position;
        let by_course = last - course.way_of_last(cycles, cycle_time);
        let then = course.later(-cycles, cycle_time);
        let (low, high) = (last.min(self.from), last.max(self.from));
        if (low..=high).contains(&by_course) {
            (by_course, then)
        } else {
            let rests = Course {
                velocity: 0.0,
                acceleration: 0.0,
            };
            (by_course.clamp(low, high), rests)
        }
    }

    fn stated_course(&self, envelope: &Envelope) -> Course {
        let stated = self.stated.acceleration;
        let believed = envelope.believes(stated);
        let acceleration = if believed { stated } else { 0.0 };
        Course {
            velocity: self.stated.velocity - acceleration * envelope.cycle_time / 2.0,
            acceleration,
        }
    }
}

impl Course {
    /// How far it has gone in so many cycles that end now, u.
    pub(super) fn way_of_last(&self, cycles: f64, cycle_time: f64) -> f64 {
        let slower = self.acceleration * cycle_time * (cycles - 1.0) / 2.0;
        cycles * cycle_time * (self.velocity - slower)
    }

    /// The same so many cycles later; before, where that is below zero.
    pub(super) fn later(&self, cycles: f64, cycle_time: f64) -> Self {
        Self {
            velocity: self.velocity + self.acceleration * cycle_time * cycles,
            ..*self
        }
    }
}
