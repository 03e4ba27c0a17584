//! The way of a velocity to one that moves itself.

use coaxle_curve::profile::{Kinematics, Limits};

/// Leads a velocity to a target that may move in every cycle, within velocity, acceleration,
/// deceleration and jerk, and lands on it exactly.
///
/// It works in differences from cycle to cycle, and relative to the target: with the jerk limit j and
/// the cycle T, `w` is the missing velocity in units of jT² and `b` the acceleration in units of jT.
/// A cycle is `b' = b + u, |u| ≤ 1`, `w' = w + b'`, so that the fastest way to `w = b = 0` has a closed
/// form, and nothing that was planned can go stale when the target moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    limits: Limits,
    velocity: f64,
    acceleration: f64,
    target: f64,
}

impl Ramp {
    /// From the slave's motion; `target` is the velocity that it should have at the same moment.
    pub(super) const fn new(slave: &Kinematics, target: f64, limits: Limits) -> Self {
        Self {
            limits,
            velocity: slave.velocity,
            acceleration: slave.acceleration,
            target,
        }
    }

    pub(super) const fn velocity(&self) -> f64 {
        self.velocity
    }

    pub(super) const fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Other limits from now on.
    pub(super) const fn limit(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// Whether the velocity is the target's.
    pub(super) fn is_there(&self) -> bool {
        self.velocity == self.target
    }

    /// One cycle with the target's own velocity, whatever the limits say.
    pub(super) fn follow(&mut self, target: f64, dt: f64) {
        self.acceleration = (target - self.velocity) / dt;
        self.velocity = target;
        self.target = target;
    }

    /// One cycle towards a target, which says how it accelerates.
    pub(super) fn step(&mut self, target: f64, stated_acceleration: f64, dt: f64) {
        let fastest = self.limits.velocity();
        let reachable = target.max(-fastest).min(fastest);
        let at = self.acceleration_of(reachable, stated_acceleration, dt);
        let (per_cycle, unit) = (self.limits.jerk() * dt, self.limits.jerk() * dt * dt);
        let before = self.velocity - (reachable - at * dt);
        let b = (self.acceleration - at) / per_cycle;
        let (lowest, highest) = self.bounds(dt);
        let wanted = (-optimal(before / unit))
            .max(lowest - at / per_cycle)
            .min(highest - at / per_cycle)
            .max(b - 1.0)
            .min(b + 1.0);
        let mut acceleration = at + wanted * per_cycle;
        let mut velocity = self.velocity + acceleration * dt;
        let rounding = 1e-12 * fastest;
        if (velocity - reachable).abs() <= rounding && wanted.abs() <= 1.0 + 1e-9 {
            acceleration = (reachable - self.velocity) / dt;
            velocity = reachable;
        }
        self.acceleration = acceleration;
        self.velocity = velocity;
        self.target = target;
    }

    /// How the target accelerates: as its velocities say; if they jump, as it says itself.
    fn acceleration_of(&self, target: f64, stated: f64, dt: f64) -> f64 {
        let most = self.limits.acceleration().min(self.limits.deceleration());
        let seen = (target - self.target) / dt;
        [seen, stated]
            .into_iter()
            .find(|acceleration| acceleration.abs() <= most)
            .unwrap_or(0.0)
    }

    /// The lowest and the highest acceleration, per jT.
    fn bounds(&self, dt: f64) -> (f64, f64) {
        let (per_cycle, unit) = (self.limits.jerk() * dt, self.limits.jerk() * dt * dt);
        let faster = self.limits.acceleration() / per_cycle;
        // A deceleration has to be an acceleration by the time the direction changes.
        let in_time = optimal(self.velocity.abs() / unit + faster + gained(faster));
        let slower = (self.limits.deceleration() / per_cycle).min(in_time);
        // From any of these the acceleration can be led to zero before the velocity is beyond its limit,
        // even if the target stops to accelerate at once.
        let fastest = self.limits.velocity();
        let up = optimal((fastest - self.velocity) / unit);
        let down = optimal((fastest + self.velocity) / unit);
        let (downwards, upwards) = if self.velocity > 0.0 {
            (slower, faster)
        } else if self.velocity < 0.0 {
            (faster, slower)
        } else {
            (faster, faster)
        };
        (-downwards.min(down), upwards.min(up))
    }
}

/// What the velocity still gains, in units of jT², while an acceleration b is led to zero.
fn gained(b: f64) -> f64 {
    let n = libm::floor(b.abs());
    (n * b.abs() - 0.5 * n * (n + 1.0)).copysign(b)
}

/// The acceleration from which the velocity is led by c until the acceleration is zero:
/// c = b + [`gained`]`(b)`, solved for b.
fn optimal(c: f64) -> f64 {
    let size = c.abs();
    let n = libm::floor((libm::sqrt(1.0 + 8.0 * size) - 1.0) / 2.0);
    (size / (n + 1.0) + n / 2.0).copysign(c)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const DT: f64 = 1e-3;

    fn limits(acceleration: f64, deceleration: f64, jerk: f64) -> Limits {
        Limits::new(1_000.0, acceleration, deceleration, jerk).unwrap()
    }

    fn moving(velocity: f64, acceleration: f64) -> Kinematics {
        Kinematics {
            position: 0.0,
            velocity,
            acceleration,
        }
    }

    #[test]
    fn a_change_of_velocity_takes_as_long_as_it_has_to() {
        // 500/5000 s, and 5000/100000 s for the jerk.
        let mut ramp = Ramp::new(&moving(0.0, 0.0), 0.0, limits(5e3, 5e3, 1e5));
        let mut cycles = 0;
        while !(ramp.velocity() == 500.0) {
            ramp.step(500.0, 0.0, DT);
            cycles += 1;
            assert!(cycles < 1_000);
        }
        assert!((149..=151).contains(&cycles), "{cycles}");
        ramp.step(500.0, 0.0, DT);
        assert_eq!((ramp.velocity(), ramp.is_there()), (500.0, true));
    }

    #[test]
    fn it_catches_up_with_a_target_that_accelerates() {
        let mut ramp = Ramp::new(&moving(0.0, 0.0), 100.0, limits(5e3, 5e3, 1e5));
        let mut target = 100.0;
        for _ in 0..300 {
            target += 2_000.0 * DT;
            ramp.step(target, 2_000.0, DT);
        }
        assert_eq!(ramp.velocity(), target);
    }

    #[test]
    fn what_is_faster_than_the_slave_may_be_is_not_reached() {
        let mut ramp = Ramp::new(&moving(900.0, 0.0), 900.0, limits(5e3, 5e3, 1e5));
        for _ in 0..500 {
            ramp.step(1_500.0, 0.0, DT);
            assert!(ramp.velocity() <= 1_000.0, "{}", ramp.velocity());
        }
        assert_eq!((ramp.velocity(), ramp.is_there()), (1_000.0, false));
    }

    #[test]
    fn a_target_that_stops_to_accelerate_does_not_lead_beyond_the_velocity() {
        let mut ramp = Ramp::new(&moving(0.0, 0.0), -857.0, limits(7.4e3, 4.1e3, 1.5e4));
        let (mut target, pull) = (-857.0, -310.0);
        for _ in 0..6_000 {
            if target > -950.0 {
                target += pull * DT;
            }
            ramp.step(target, pull, DT);
            assert!(
                ramp.velocity() >= -1_000.0 * (1.0 + 1e-12),
                "{}",
                ramp.velocity()
            );
        }
        assert_eq!(ramp.velocity(), target);
    }

    proptest! {
        #[test]
        fn differences_keep_the_limits_and_land(
            (velocity, target) in (-900.0..900.0, -900.0..900.0),
            (acceleration, deceleration) in (500.0..8e3, 500.0..8e3),
            exponent in 4.0..6.5,
            drift in -1.0..1.0,
            change in prop::option::of((1_usize..200, -900.0..900.0)),
        ) {
            let jerk = libm::pow(10.0, exponent);
            let limits = limits(acceleration, deceleration, jerk);
            let mut ramp = Ramp::new(&moving(velocity, 0.0), target, limits);
            let most = acceleration.min(deceleration);
            let (mut target, pull) = (target, drift * 0.1 * most);
            for cycle in 0..6_000 {
                if let Some((at, to)) = change && cycle == at {
                    target = to;
                }
                let next: f64 = target + pull * DT;
                // It stops to accelerate at once, with time left to land.
                if next.abs() < 950.0 && cycle < 3_000 {
                    target = next;
                }
                let (before, was) = (ramp.velocity(), ramp.acceleration());
                ramp.step(target, pull, DT);
                let now = (ramp.velocity() - before) / DT;
                let allowed = if before * ramp.velocity() < 0.0 {
                    acceleration.max(deceleration)
                } else if ramp.velocity().abs() > before.abs() {
                    acceleration
                } else {
                    deceleration
                };
                prop_assert!(now.abs() <= allowed * (1.0 + 1e-9) + 1e-6, "{now} {allowed}");
                prop_assert!((now - was).abs() <= jerk * DT * (1.0 + 1e-6) + 1e-6, "{now} {was}");
                prop_assert!(ramp.velocity().abs() <= 1_000.0 * (1.0 + 1e-12));
            }
            prop_assert_eq!(ramp.velocity(), target);
        }
    }
}
