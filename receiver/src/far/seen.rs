//! What a master was seen to do: all that is known of its limits where none are given.

use coaxle_curve::profile::Kinematics;
use coaxle_remote::{LASTING, Reach};

/// Acceleration and jerk may be exceeded by a third: those seen are means over a cycle of the sender.
const RESERVE: f64 = 4.0 / 3.0;
/// Frames are neighbours up to this number of cycles of the sender apart: some are always lost. Over more the master may have done
/// anything.
const NEXT: u64 = 4;
/// The cycles of the sender by which a mode that shows what comes may step at once: those of a beat, and of the
/// silence that is borne by default (`age-of-data-limit`).
pub(super) const LARGEST_BEAT: u64 = 8;
/// The mean of two velocities is off by at most this multiple of acceleration × time² (the trapezoidal rule).
const TRAPEZOID: f64 = 0.25;
/// Positions beside the velocities may be off to both sides.
const BOTH_SIDES: f64 = 2.0;
/// What no motion explains is remembered for this time, s, and at most twice as long.
const MEMORY: f64 = 1.0;

/// What a far axis was seen to do: the limits that it is taken to have, unless it is given some.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SeenMotion {
    /// The greatest velocity, u/s, and the greatest acceleration, u/s², stated or by differences of the velocity.
    reach: Reach,
    /// The greatest jerk by differences of the stated acceleration, u/s³.
    jerk: f64,
    /// The rate of the velocity between the newest frames, u/s², where they were neighbours.
    rate: Option<f64>,
    noise: Noise,
    /// The ways from frame to frame, u, over no more than a beat.
    received_ways: Recent,
}

/// What of the frames no motion explains: of increments, of beats that were handed on, of positions that were set.
#[derive(Clone, Copy, Debug, Default)]
struct Noise {
    /// Of positions beside what velocities say, u.
    position: Recent,
    /// Of velocities from frame to frame, u/s.
    velocity: Recent,
    /// Of accelerations from frame to frame, u/s².
    acceleration: Recent,
}

impl SeenMotion {
    /// Set values, and those that came before: how many seconds, and how many cycles of the sender, earlier.
    pub(super) fn take(&mut self, set: &Kinematics, before: Option<(&Kinematics, f64, u64)>) {
        let reach = &mut self.reach;
        reach.velocity = reach.velocity.max(set.velocity.abs());
        reach.acceleration = reach.acceleration.max(set.acceleration.abs());
        let Some((before, time, cycles)) = before.filter(|(_, time, _)| *time > 0.0) else {
            self.rate = None;
            return;
        };
        let rate = (set.velocity - before.velocity) / time;
        reach.acceleration = reach.acceleration.max(rate.abs());
        let jerk = (set.acceleration - before.acceleration) / time;
        self.jerk = self.jerk.max(jerk.abs());
        let way = set.position - before.position;
        let mean = 0.5 * (set.velocity + before.velocity);
        let explained = TRAPEZOID * self.reach.acceleration * time * time;
        if cycles <= LARGEST_BEAT {
            self.received_ways.see(way.abs());
        }
        self.noise
            .position
            .see((way - mean * time).abs() - explained);
        let rate = (cycles <= NEXT).then_some(rate);
        if let Some(rate) = rate {
            self.noise.velocity.see(rate.abs() * time);
        }
        if let (Some(before), Some(now)) = (self.rate, rate) {
            self.noise.acceleration.see((now - before).abs());
        }
        self.rate = rate;
    }

    /// Own time passes, s.
    pub(super) fn pass(&mut self, passed: f64) {
        let Noise {
            position,
            velocity,
            acceleration,
        } = &mut self.noise;
        for recent in [position, velocity, acceleration, &mut self.received_ways] {
            recent.pass(passed);
        }
    }

    /// The most that it did.
    pub(super) const fn reach(&self) -> Reach {
        self.reach
    }

    /// The longest way of late from one frame to the next that came, u.
    pub(super) fn received_way(&self) -> f64 {
        self.received_ways.largest()
    }

    /// How far the axis may be from where set values of this age are moved on to, u: half of the jerk × age³, or the
    /// change of the acceleration, from one end to the other, × age² / 2.
    pub(super) fn prediction_error(&self, age: f64) -> f64 {
        let age = age.abs();
        let by_jerk = 0.5 * self.jerk * age * age * age;
        let by_acceleration = self.reach.acceleration * age * age;
        by_jerk.min(by_acceleration)
    }

    /// How much more than it moved the axis may move in a cycle, u, with set values of this age.
    pub(super) fn explained(&self, age: f64, passed: f64) -> f64 {
        let by_acceleration = self.reach.acceleration * passed * passed;
        let by_jerk = 0.5 * self.jerk * age * age * passed;
        RESERVE * (by_acceleration + by_jerk)
    }

    /// The greatest velocity that set values have which are moved on by up to `age` seconds, u/s.
    pub(super) fn greatest_velocity(&self, age: f64) -> f64 {
        self.reach.velocity + self.reach.acceleration * age.min(LASTING)
    }

    /// What of its frames no motion explains, moved on by up to `age` seconds, u.
    pub(super) fn unexplained(&self, age: f64) -> f64 {
        let Noise {
            position,
            velocity,
            acceleration,
        } = &self.noise;
        BOTH_SIDES * position.largest()
            + velocity.largest() * age
            + acceleration.largest() * age * age
    }
}

/// The largest value of the last one or two seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Recent {
    now: f64,
    before: f64,
    since: f64,
}

impl Recent {
    pub(super) fn see(&mut self, value: f64) {
        self.now = self.now.max(value);
    }

    pub(super) fn pass(&mut self, passed: f64) {
        self.since += passed;
        if self.since >= MEMORY {
            (self.before, self.now, self.since) = (self.now, 0.0, 0.0);
        }
    }

    pub(super) const fn largest(&self) -> f64 {
        self.now.max(self.before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: f64 = 1e-3;

    #[test]
    fn jerk_and_acceleration_say_how_far_a_prediction_may_be_off() {
        let mut seen = SeenMotion::default();
        let ramp = |k: u32| Kinematics {
            position: 0.0,
            velocity: 500.0,
            acceleration: 100.0 * f64::from(k.min(50)),
        };
        for k in 1..100 {
            seen.take(&ramp(k), Some((&ramp(k - 1), CYCLE, 1)));
        }
        assert!((seen.jerk / 1e5 - 1.0).abs() < 1e-9 && seen.reach.acceleration == 5_000.0);
        let error = |age: f64| seen.prediction_error(age);
        assert!((error(2e-3) - 0.5 * 1e5 * 8e-9).abs() < 1e-15);
        assert!((error(0.5) - 5_000.0 * 0.25).abs() < 1e-9);
    }

    #[test]
    fn what_no_motion_explains_is_remembered_for_a_while() {
        let mut seen = SeenMotion::default();
        let steady = |position: f64| Kinematics {
            position,
            velocity: 500.0,
            acceleration: 0.0,
        };
        seen.take(&steady(1.5), Some((&steady(0.0), CYCLE, 1)));
        assert!(
            (seen.unexplained(0.0) - 2.0).abs() < 1e-12,
            "one beside, to both sides"
        );
        assert_eq!(seen.received_way(), 1.5);
        for _ in 0..2_010 {
            seen.pass(CYCLE);
        }
        assert_eq!((seen.unexplained(1.0), seen.received_way()), (0.0, 0.0));
    }
}
