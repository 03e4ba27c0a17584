//! What a target does, as far as it can be known.

use coaxle_curve::profile::Kinematics;

use super::differences::Differences;
use super::envelope::Envelope;

/// The positions of a target, and what it states of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    series: Differences,
    /// The position before the last, u.
    from: f64,
    stated: Kinematics,
    last_position: f64,
}

/// What a target is taken to do: its mean velocity of the last cycle, u/s, and its acceleration, u/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Course {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

impl Target {
    pub(super) fn at(state: &Kinematics, cycle_time: f64) -> Self {
        Self {
            series: Differences::up_to(state, cycle_time),
            from: state.position,
            stated: *state,
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
        Self {
            series: self.series.then(next.position, cycles, rate),
            from: self.series.position,
            stated: *next,
            last_position,
        }
    }

    /// The last position that was a number, u.
    pub(super) const fn last_position(&self) -> f64 {
        self.last_position
    }

    /// Its positions decide. Where they jump, there is nothing but what it states.
    pub(super) fn course(&self, envelope: &Envelope) -> Course {
        if envelope.is_smooth(&self.series, self.from) {
            Course {
                velocity: self.series.velocity_of_cycle(envelope.cycle_time),
                acceleration: self.series.acceleration,
            }
        } else {
            self.stated_course(envelope)
        }
    }

    fn stated_course(&self, envelope: &Envelope) -> Course {
        let stated = self.stated.acceleration;
        let believed = envelope.allows_acceleration(stated);
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
