//! Observed motion of a master: the only information on its limits if none are configured.

use coaxle_curve::profile::Kinematics;
use coaxle_remote::{LASTING, Reach};

/// Acceleration and jerk may be exceeded by a third: the observed ones are means over a cycle of
/// the sender.
const RESERVE: f64 = 4.0 / 3.0;
/// An acceleration that grows from 0 in a cycle of the sender is twice its mean: the master of `master-in-motion` passes to the bit. With
/// 4/3 its first frame in motion was moved on by less, and the next one was a step of 0.02 u.
const GROWING: f64 = 2.0;
/// Rounding of a velocity by differences, relative.
const ROUNDING: f64 = 1e-9;
/// Frames are neighbours up to this number of cycles of the sender apart: some are always lost.
/// Over more the motion of the master is unknown.
// Up to three frames may be lost between neighbours.
const NEXT: u64 = 4;
/// Cycles of the sender by which a mode that shows values as received may step at once: those of a
/// beat, and of the silence that is tolerated by default (`age-of-data-limit`).
pub(super) const LARGEST_BEAT: u64 = 8;
/// The mean of two velocities is off by at most this multiple of acceleration × time² (the trapezoidal rule).
const TRAPEZOID: f64 = 0.25;
/// Positions may deviate from the velocities in both directions.
const BOTH_SIDES: f64 = 2.0;
/// Time for which deviations that no motion explains are remembered, s, at most twice as long.
const MEMORY: f64 = 1.0;

/// Observed motion of a far axis: the limits that it is assumed to have without configured ones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObservedMotion {
    /// The greatest velocity, u/s, and the greatest acceleration, u/s², stated or by differences of the velocity.
    reach: Reach,
    /// The greatest acceleration by differences of the velocity, u/s².
    by_velocities: f64,
    /// Greatest velocity and acceleration of an axis that comes in increments, once those are smoothed.
    smoothed: Option<Reach>,
    /// The greatest jerk by differences of the stated acceleration, u/s³.
    jerk: f64,
    /// The rate of the velocity between the newest frames, u/s², if they were neighbours.
    rate: Option<f64>,
    noise: UnexplainedDeviations,
    /// The ways from frame to frame, u, over no more than a beat.
    received_ways: RecentPeak,
}

/// Deviations of the frames that no motion explains: from increments, beats that were passed on,
/// positions that were set.
#[derive(Clone, Copy, Debug, Default)]
struct UnexplainedDeviations {
    /// Deviation of positions from the velocities, u.
    position: RecentPeak,
    /// Deviation of velocities from frame to frame, u/s.
    velocity: RecentPeak,
    /// Deviation of accelerations from frame to frame, u/s².
    acceleration: RecentPeak,
}

impl ObservedMotion {
    /// Takes set values, and the previous ones with the seconds and cycles of the sender between them.
    pub(super) fn take(&mut self, set: &Kinematics, before: Option<(&Kinematics, f64, u64)>) {
        let reach = &mut self.reach;
        reach.velocity = reach.velocity.max(set.velocity.abs());
        reach.acceleration = reach.acceleration.max(set.acceleration.abs());
        // Repeated counts have no time between them, and no quotients.
        let Some((before, time, cycles)) = before.filter(|(_, time, _)| *time > 0.0) else {
            self.rate = None;
            return;
        };
        let rate = (set.velocity - before.velocity) / time;
        reach.acceleration = reach.acceleration.max(rate.abs());
        self.by_velocities = self.by_velocities.max(rate.abs());
        let jerk = (set.acceleration - before.acceleration) / time;
        self.jerk = self.jerk.max(jerk.abs());
        let way = set.position - before.position;
        let mean = 0.5 * (set.velocity + before.velocity);
        // The worst motion with given velocities at both ends: full acceleration for half of the time, and back. That
        // is a·(t/2)².
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
        // A rate over a gap says nothing about a jump of the acceleration.
        if let (Some(before), Some(now)) = (self.rate, rate) {
            self.noise.acceleration.see((now - before).abs());
        }
        self.rate = rate;
    }

    /// Own time passes, s.
    pub(super) fn pass(&mut self, passed: f64) {
        let UnexplainedDeviations {
            position,
            velocity,
            acceleration,
        } = &mut self.noise;
        for recent in [position, velocity, acceleration, &mut self.received_ways] {
            recent.pass(passed);
        }
    }

    /// Takes a smoothed set value of an axis that comes in increments.
    pub(super) fn take_smoothed(&mut self, set: &Kinematics) {
        let reach = self.smoothed.get_or_insert_default();
        reach.velocity = reach.velocity.max(set.velocity.abs());
        reach.acceleration = reach.acceleration.max(set.acceleration.abs());
    }

    /// Takes a set value of a plan: velocity and acceleration that its node has stated before any frame shows them.
    pub(super) fn take_planned(&mut self, set: &Kinematics) {
        let acceleration = set.acceleration.abs();
        self.reach.velocity = self.reach.velocity.max(set.velocity.abs());
        self.reach.acceleration = self.reach.acceleration.max(acceleration);
        self.by_velocities = self.by_velocities.max(acceleration);
    }

    /// Largest observed motion; for increments, after smoothing.
    pub(super) fn reach(&self) -> Reach {
        self.smoothed.unwrap_or(self.reach)
    }

    /// Longest recent way from one received frame to the next, u.
    pub(super) fn received_way(&self) -> f64 {
        self.received_ways.largest()
    }

    /// Largest distance of the axis from set values of this age moved on, u: half of the jerk ×
    /// age³, or the change of the acceleration, from one end to the other, × age² / 2.
    pub(super) fn prediction_error(&self, age: f64) -> f64 {
        let age = age.abs();
        let by_jerk = 0.5 * self.jerk * age * age * age;
        let by_acceleration = self.reach.acceleration * age * age;
        // Both bounds hold. The jerk's is the lower one for small ages, and unusable for large ones, as it grows with
        // age³.
        by_jerk.min(by_acceleration)
    }

    /// Largest additional way of the axis in a cycle, u, with set values of this age.
    pub(super) fn explained(&self, age: f64, passed: f64) -> f64 {
        let by_acceleration = self.reach.acceleration * passed * passed;
        // A prediction with constant acceleration is off by j·t³/6 at most. Its derivative j·t²/2 is what a cycle
        // adds.
        let by_jerk = 0.5 * self.jerk * age * age * passed;
        RESERVE * (by_acceleration + by_jerk)
    }

    /// Greatest velocity of set values that are moved on by up to `age` seconds, u/s.
    pub(super) fn greatest_velocity(&self, age: f64) -> f64 {
        // The prediction fades the acceleration out: however old the values are, it adds no more than this time of
        // it.
        let acceleration = (GROWING * self.by_velocities).min(self.reach.acceleration);
        self.reach.velocity + acceleration * age.min(LASTING)
    }

    /// Set values whose acceleration, moved on by `age` seconds, leads to no velocity beyond the [greatest](Self::greatest_velocity).
    ///
    /// A stated acceleration may last for less than a cycle: only as far as velocities have shown one, it is that of a motion. In wide
    /// schedule 500647 a slave stated −3.5 · 10⁶ u/s² in the only frame for 46 ms, and its axis was taken to move at −245 m/s.
    pub(super) fn credible(&self, set: &Kinematics, age: f64) -> Kinematics {
        let lasting = age.clamp(-LASTING, LASTING);
        let most = self.greatest_velocity(age.abs()).max(set.velocity.abs());
        let predicted = set.velocity + set.acceleration * lasting;
        // Otherwise to the bit. An age of 0 predicts the stated velocity, and is no divisor.
        if predicted.abs() <= most * (1.0 + ROUNDING) || lasting == 0.0 {
            return *set;
        }
        Kinematics {
            acceleration: (most.copysign(predicted) - set.velocity) / lasting,
            ..*set
        }
    }

    /// Deviation of its frames that no motion explains, moved on by up to `age` seconds, u.
    pub(super) fn unexplained(&self, age: f64) -> f64 {
        let UnexplainedDeviations {
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
pub(super) struct RecentPeak {
    now: f64,
    before: f64,
    since: f64,
}

impl RecentPeak {
    pub(super) fn see(&mut self, value: f64) {
        self.now = self.now.max(value);
    }

    pub(super) fn pass(&mut self, passed: f64) {
        self.since += passed;
        if self.since >= MEMORY {
            // Two buckets in turn forget in bounded memory. A decaying peak would fall below a ripple between two of its
            // peaks.
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
        let mut seen = ObservedMotion::default();
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
    fn an_acceleration_that_no_velocity_has_shown_is_not_carried_on() {
        let mut seen = ObservedMotion::default();
        let slave = |velocity: f64, acceleration: f64| Kinematics {
            position: 0.0,
            velocity,
            acceleration,
        };
        seen.take(&slave(-507.0, 0.0), None);
        let (before, now) = (slave(-507.0, 0.0), slave(-945.7, -3.5e6));
        seen.take(&now, Some((&before, 0.046, 183)));
        let credible = seen.credible(&now, 0.07);
        let shown = (945.7 - 507.0) / 0.046;
        let predicted = credible.velocity + credible.acceleration * 0.07;
        assert!((predicted + 945.7 + GROWING * shown * 0.07).abs() < 1e-9);
        assert_eq!(seen.credible(&now, 0.0), now);
        assert_eq!(seen.credible(&before, 0.07), before);
        // Looking back as well, where the same acceleration leads to the other side.
        let back = seen.credible(&now, -0.07);
        assert!(back.velocity - 0.07 * back.acceleration <= 945.7 + GROWING * shown * 0.07 + 1e-9);
    }

    /// A ramp from rest with a jerk of 1e5 u/s³: its accelerations pass as stated.
    #[test]
    fn the_acceleration_of_a_ramp_is_credible_from_its_first_frame_on() {
        let mut seen = ObservedMotion::default();
        let ramp = |k: u32| Kinematics {
            position: 0.0,
            velocity: 0.5 * 1e5 * (CYCLE * f64::from(k)).powi(2),
            acceleration: 1e5 * CYCLE * f64::from(k),
        };
        for k in 1..50 {
            seen.take(&ramp(k), Some((&ramp(k - 1), CYCLE, 1)));
            for age in [2e-3, 2e-2, 1.0] {
                assert_eq!(seen.credible(&ramp(k), age), ramp(k), "{k}, {age}");
            }
        }
    }

    #[test]
    fn what_no_motion_explains_is_remembered_for_a_while() {
        let mut seen = ObservedMotion::default();
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
