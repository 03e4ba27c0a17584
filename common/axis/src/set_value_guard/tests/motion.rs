//! Motions within limits: profiles one after the other.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_position, to_velocity};

use super::random::Random;

/// An axis, and its sampling.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) limits: Limits,
    pub(super) cycle_time: f64,
    /// Approximate position, u.
    pub(super) origin: f64,
}

impl Axis {
    /// A random axis: from drives that reach their acceleration within a small part of a cycle, and
    /// their velocity in one, to those that need hundreds.
    pub(super) fn by_chance(random: &mut Random) -> Self {
        Self::that_needs(1e-3, 0.1, random)
    }

    /// A random axis, but not one that reaches its limits within a cycle.
    pub(super) fn usual(random: &mut Random) -> Self {
        Self::that_needs(0.3, 2.0, random)
    }

    /// A random axis that needs at least these numbers of cycles to its acceleration, and with that
    /// to its velocity.
    fn that_needs(to_acceleration: f64, to_velocity: f64, random: &mut Random) -> Self {
        let cycle_time = random.decades(0.25e-3, 4e-3);
        // Limits from slow axes to direct drives, as in the streams that the guard was designed with.
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
    /// Approximate time to its velocity and back, s.
    pub(super) fn ramp(&self) -> f64 {
        let limits = &self.limits;
        2.0 * (limits.velocity() / limits.acceleration() + limits.acceleration() / limits.jerk())
    }
}

/// Limits, each multiplied by a share.
pub(super) fn scaled(limits: &Limits, share: f64) -> Limits {
    Limits::new(
        share * limits.velocity(),
        share * limits.acceleration(),
        share * limits.deceleration(),
        share * limits.jerk(),
    )
    .unwrap()
}

/// A motion without end within limits, sampled once per cycle.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    limits: Limits,
    profile: Profile,
    since: f64,
    /// End of the current profile.
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

    /// Continues at a share of its velocity.
    pub(super) fn cruise(&mut self, share: f64) {
        self.profile = to_velocity(&self.here, share * self.limits.velocity(), &self.limits);
        self.since = 0.0;
        self.until = f64::INFINITY;
    }

    /// Jumps to another position, at a share of its velocity.
    pub(super) fn jump(&mut self, by: f64, share: f64) {
        let here = Kinematics {
            position: self.here.position + by,
            velocity: share * self.limits.velocity(),
            acceleration: 0.0,
        };
        *self = Self::starting_at(here, self.limits);
    }

    /// Begins the next profile, at the state of the last one in this cycle.
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
