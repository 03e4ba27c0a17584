//! Motions that keep limits: profiles one after the other.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_position, to_velocity};

use super::random::Random;

/// An axis, and how it is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) limits: Limits,
    pub(super) cycle_time: f64,
    /// Where it is, about, u.
    pub(super) origin: f64,
}

impl Axis {
    /// From drives that have their acceleration within a small part of a cycle, and their velocity in one,
    /// to such that need hundreds.
    pub(super) fn by_chance(random: &mut Random) -> Self {
        Self::that_needs(1e-3, 0.1, random)
    }

    /// The same, but no drive that is at its limits within a cycle.
    pub(super) fn usual(random: &mut Random) -> Self {
        Self::that_needs(0.3, 2.0, random)
    }

    /// At least so many cycles to its acceleration, and with that to its velocity.
    fn that_needs(to_acceleration: f64, to_velocity: f64, random: &mut Random) -> Self {
        let cycle_time = random.decades(0.25e-3, 4e-3);
        let jerk = random.decades(1e3, 1e8);
        let acceleration = jerk * random.decades(to_acceleration * cycle_time, 0.1);
        let velocity = acceleration * random.decades(to_velocity * cycle_time, 0.5);
        let origin = if random.percent(50) {
            0.0
        } else {
            random.decades(1.0, 1e6)
        };
        Self {
            limits: Limits::new(velocity, acceleration, acceleration, jerk).unwrap(),
            cycle_time,
            origin,
        }
    }
}

impl Axis {
    /// How long it takes to its velocity and back, about, s.
    pub(super) fn ramp(&self) -> f64 {
        let limits = &self.limits;
        2.0 * (limits.velocity() / limits.acceleration() + limits.acceleration() / limits.jerk())
    }
}

/// The same limits, each times a number.
pub(super) fn scaled(limits: &Limits, share: f64) -> Limits {
    Limits::new(
        share * limits.velocity(),
        share * limits.acceleration(),
        share * limits.deceleration(),
        share * limits.jerk(),
    )
    .unwrap()
}

/// A motion without end that keeps limits, looked at once per cycle.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    limits: Limits,
    profile: Profile,
    since: f64,
    /// When it goes over to the next profile.
    until: f64,
    pub(super) here: Kinematics,
}

impl Motion {
    pub(super) fn starting_at(here: Kinematics, limits: Limits) -> Self {
        Self {
            limits,
            profile: to_velocity(&here, here.velocity, &limits),
            since: 0.0,
            until: 0.0,
            here,
        }
    }

    pub(super) fn next(&mut self, random: &mut Random, cycle_time: f64) -> Kinematics {
        if self.since >= self.until {
            self.turn(random);
        }
        self.since += cycle_time;
        self.here = self.profile.at(Seconds(self.since));
        self.here
    }

    /// Goes on at a part of its velocity.
    pub(super) fn cruise(&mut self, share: f64) {
        self.profile = to_velocity(&self.here, share * self.limits.velocity(), &self.limits);
        self.since = 0.0;
        self.until = f64::INFINITY;
    }

    /// Is elsewhere at once, at a part of its velocity.
    pub(super) fn jump(&mut self, by: f64, share: f64) {
        let here = Kinematics {
            position: self.here.position + by,
            velocity: share * self.limits.velocity(),
            acceleration: 0.0,
        };
        *self = Self::starting_at(here, self.limits);
    }

    /// The next profile, from where the last one is in this cycle.
    fn turn(&mut self, random: &mut Random) {
        let (from, limits) = (self.here, &self.limits);
        let ramp =
            limits.velocity() / limits.acceleration() + limits.acceleration() / limits.jerk();
        self.profile = match random.below(4) {
            0 => to_velocity(&from, 0.0, limits),
            1 => to_velocity(&from, random.between(-1.0, 1.0) * limits.velocity(), limits),
            2 => to_velocity(
                &from,
                limits.velocity() * if random.percent(50) { 1.0 } else { -1.0 },
                limits,
            ),
            _ => {
                let way = limits.velocity() * ramp * random.decades(1e-3, 3.0);
                let way = if random.percent(50) { way } else { -way };
                to_position(&from, from.position + way, limits)
            }
        };
        self.since = 0.0;
        let duration = self.profile.duration().0;
        // Not always to the end.
        let share = if random.percent(70) {
            1.0
        } else {
            random.between(0.1, 1.0)
        };
        self.until = share * duration
            + if random.percent(50) {
                random.between(0.0, ramp)
            } else {
                0.0
            };
    }
}
