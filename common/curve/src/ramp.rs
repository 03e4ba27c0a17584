//! The path of a slave to a changing velocity: decided from cycle to cycle, not planned.

use crate::profile::{Kinematics, Limits};

/// Greatest deviation of the acceleration from its target's when the velocity reaches the target, as a
/// part of what the jerk permits per cycle: with the full jerk before it and a quarter after it, the
/// differences of the positions still keep the limit.
const LANDING: f64 = 0.25;

/// Part of that deviation that is left in the next cycle, with the opposite sign. All of it would
/// alternate for ever.
const FADING: f64 = 0.75;

/// Leads a slave to a velocity that may change in every cycle, within velocity, acceleration,
/// deceleration and jerk, and reaches it exactly. It starts from the slave's own acceleration.
///
/// In a cycle of T the jerk is constant, so that the differences of the positions keep the limits too.
/// Relative to the target, with the jerk limit j, let `b` be the acceleration in units of jT, and `w` the
/// velocity reached if the acceleration is led to zero evenly within a cycle, in units of jT². Then a
/// cycle is `b' = b + u, |u| ≤ 1`, `w' = w + b'`, so that the fastest path to `w = b = 0` has a closed
/// form, and no plan can go stale when the target moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    limits: Limits,
    slave: Kinematics,
    target: f64,
}

impl Ramp {
    /// Starts from the slave's motion; `target` is the target velocity at the same moment.
    #[must_use]
    pub const fn new(slave: &Kinematics, target: f64, limits: Limits) -> Self {
        Self {
            limits,
            slave: *slave,
            target,
        }
    }

    /// Returns the slave in the last cycle.
    #[must_use]
    pub const fn slave(&self) -> &Kinematics {
        &self.slave
    }

    /// Sets other limits from now on.
    pub const fn limit(&mut self, limits: Limits) {
        self.limits = limits;
    }

    /// True if the velocity is the target's.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.slave.velocity == self.target
    }

    /// Follows another leader of the slave for one cycle of `dt` seconds, without limits.
    pub fn follow(&mut self, led: &Kinematics, dt: f64) {
        let acceleration = self.acceleration_of(led.velocity, led.acceleration, dt);
        self.target = led.velocity;
        self.slave = Kinematics {
            acceleration,
            ..*led
        };
    }

    /// Computes one cycle of `dt` seconds towards a target velocity with its stated acceleration.
    pub fn step(&mut self, target: f64, stated_acceleration: f64, dt: f64) {
        let fastest = self.limits.velocity();
        let reachable = target.max(-fastest).min(fastest);
        // Velocities of the target say what it does. Its stated
        // acceleration may belong to another moment, or be 0.
        let seen = (reachable - self.target) / dt;
        let (before, was_there) = (self.slave, self.is_there());
        // Constant jerk in a cycle changes the velocity by (a + a')/2·T.
        // Solved for the a' that ends at the target.
        let landing = 2.0 * (reachable - before.velocity) / dt - before.acceleration;
        if self.can_follow(seen) && self.can_land(landing, seen, dt) {
            self.step_to(landing, dt);
            // Exactly, so that arrival can be found by comparison; the step above has rounded.
            self.slave.velocity = reachable;
            if was_there {
                // A deviation e from `seen` lands at −e: without fading it would change its sign for ever.
                self.slave.acceleration = seen + FADING * (landing - seen);
            }
        } else {
            let at = self.acceleration_of(reachable, stated_acceleration, dt);
            self.step_to(self.towards(reachable, at, dt), dt);
            // By `bounds` only rounding is beyond the limit here, or a start that already was.
            self.slave.velocity = self.slave.velocity.max(-fastest).min(fastest);
        }
        // The target as it is, not the reachable one: a slave at its own limit has not arrived.
        self.target = target;
    }

    /// Runs a cycle of constant jerk that ends with this acceleration.
    fn step_to(&mut self, acceleration: f64, dt: f64) {
        let before = self.slave;
        let change = acceleration - before.acceleration;
        self.slave = Kinematics {
            // p + vT + a·T²/2 + j·T³/6 with j·T = change, and likewise the velocity.
            position: before.position
                + dt * (before.velocity + dt * (before.acceleration / 2.0 + change / 6.0)),
            velocity: before.velocity + dt * (before.acceleration + change / 2.0),
            acceleration,
        };
    }

    /// Returns the limits that are effective in cycles of this length: with a jerk that means "none",
    /// rounding relative to it would accept every acceleration.
    fn binding(&self, dt: f64) -> Limits {
        self.limits.binding_in_cycles(dt)
    }

    /// True if this acceleration at the end of the cycle, which brings the velocity to its target, is
    /// within the limits, and near enough to the target's acceleration for the slave to continue with it.
    fn can_land(&self, landing: f64, at: f64, dt: f64) -> bool {
        let per_cycle = self.binding(dt).jerk() * dt;
        let (lowest, highest) = self.bounds(dt);
        // Above the rounding of accelerations up to 4e6 jT, and far below what positions in u can show.
        let rounding = 1e-9 * per_cycle;
        (landing - self.slave.acceleration).abs() <= per_cycle + rounding
            && (landing - at).abs() <= LANDING * per_cycle + rounding
            && landing >= lowest * per_cycle - rounding
            && landing <= highest * per_cycle + rounding
    }

    /// Returns the acceleration at the end of this cycle on the fastest path to a target.
    fn towards(&self, reachable: f64, at: f64, dt: f64) -> f64 {
        let per_cycle = self.binding(dt).jerk() * dt;
        let unit = per_cycle * dt;
        let b = (self.slave.acceleration - at) / per_cycle;
        // The target one cycle ago: the slave's velocity is that of the last cycle, too.
        let w = (self.slave.velocity - (reachable - at * dt)) / unit + b / 2.0;
        let (lowest, highest) = self.bounds(dt);
        // The bounds first, the jerk last: a start outside the
        // bounds is led back at the jerk limit, not by a jump.
        let wanted = (-optimal(w))
            .max(lowest - at / per_cycle)
            .min(highest - at / per_cycle)
            .max(b - 1.0)
            .min(b + 1.0);
        at + wanted * per_cycle
    }

    /// Returns the acceleration of the target: by its velocities; if they jump, the stated one.
    fn acceleration_of(&self, target: f64, stated: f64, dt: f64) -> f64 {
        let seen = (target - self.target) / dt;
        [seen, stated]
            .into_iter()
            .find(|acceleration| self.can_follow(*acceleration))
            // Both beyond the limits mean a jump of the target, whose acceleration afterwards is unknown.
            .unwrap_or(0.0)
    }

    /// True if a target with this acceleration can be followed.
    fn can_follow(&self, acceleration: f64) -> bool {
        // The smaller one, since the direction of a target can change while it is followed.
        let most = self.limits.acceleration().min(self.limits.deceleration());
        acceleration.abs() <= most
    }

    /// Returns the least and the greatest acceleration at the end of a cycle, per jT.
    fn bounds(&self, dt: f64) -> (f64, f64) {
        let limits = self.binding(dt);
        let per_cycle = limits.jerk() * dt;
        let unit = per_cycle * dt;
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = self.slave;
        let (v, b) = (velocity / unit, acceleration / per_cycle);
        let faster = limits.acceleration() / per_cycle;
        // A deceleration has to be an acceleration limit by the time the direction changes.
        // A cycle takes (|b| + |b'|)/2 ≤ |b| + ½ of the speed,
        // in units of jT²: |b| + 1 is on the safe side.
        let left = (v.abs() - b.abs() - 1.0).max(0.0);
        // Leading b to zero takes b + gained(b) of speed. The
        // difference of both sides has to fit into what is left.
        let in_time = optimal(left + faster + gained(faster));
        let slower = (limits.deceleration() / per_cycle).min(in_time);
        // From any of these the acceleration can be led to zero before the velocity exceeds its limit,
        // even if the target stops accelerating at once.
        let fastest = limits.velocity() / unit;
        let up = optimal(fastest - v - b / 2.0);
        let down = optimal(fastest + v + b / 2.0);
        let (downwards, upwards) = if velocity > 0.0 {
            (slower, faster)
        } else if velocity < 0.0 {
            (faster, slower)
        } else {
            // At rest every push speeds up.
            (faster, faster)
        };
        (-downwards.min(down), upwards.min(up))
    }
}

/// Returns the velocity still gained, in units of jT², while an acceleration b is led to zero.
fn gained(b: f64) -> f64 {
    // After k cycles b − k is left: the sum of b − k for k = 1..n.
    let n = libm::floor(b.abs());
    (n * b.abs() - 0.5 * n * (n + 1.0)).copysign(b)
}

/// Returns the acceleration from which the velocity changes by c until the acceleration is zero: c = b +
/// [`gained`]`(b)`, solved for b.
fn optimal(c: f64) -> f64 {
    let size = c.abs();
    // With n whole cycles after the first, c = (n + 1)b − n(n + 1)/2. The greatest n has n(n + 1)/2 ≤ c.
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
        while !(ramp.slave().velocity == 500.0) {
            ramp.step(500.0, 0.0, DT);
            cycles += 1;
            assert!(cycles < 1_000);
        }
        // A cycle more or less: the ramp decides in whole cycles.
        assert!((149..=151).contains(&cycles), "{cycles}");
        ramp.step(500.0, 0.0, DT);
        assert_eq!((ramp.slave().velocity, ramp.is_there()), (500.0, true));
    }

    #[test]
    fn it_catches_up_with_a_target_that_accelerates() {
        let mut ramp = Ramp::new(&moving(0.0, 0.0), 100.0, limits(5e3, 5e3, 1e5));
        let mut target = 100.0;
        for _ in 0..300 {
            target += 2_000.0 * DT;
            ramp.step(target, 2_000.0, DT);
        }
        assert_eq!(ramp.slave().velocity, target);
    }

    #[test]
    fn what_is_faster_than_the_slave_may_be_is_not_reached() {
        let mut ramp = Ramp::new(&moving(900.0, 0.0), 900.0, limits(5e3, 5e3, 1e5));
        for _ in 0..500 {
            ramp.step(1_500.0, 0.0, DT);
            assert!(
                ramp.slave().velocity <= 1_000.0,
                "{}",
                ramp.slave().velocity
            );
        }
        assert_eq!((ramp.slave().velocity, ramp.is_there()), (1_000.0, false));
    }

    #[test]
    fn a_target_that_stops_to_accelerate_does_not_lead_beyond_the_velocity() {
        // Leading an acceleration to zero takes a²/2j: beyond
        // 1225 u/s² more than the 50 u/s above the target.
        let mut ramp = Ramp::new(&moving(0.0, 0.0), -857.0, limits(7.4e3, 4.1e3, 1.5e4));
        let (mut target, pull) = (-857.0, -310.0);
        for _ in 0..6_000 {
            if target > -950.0 {
                target += pull * DT;
            }
            ramp.step(target, pull, DT);
            assert!(
                ramp.slave().velocity >= -1_000.0 * (1.0 + 1e-12),
                "{}",
                ramp.slave().velocity
            );
        }
        assert_eq!(ramp.slave().velocity, target);
    }

    /// From rest to a velocity, with all limits that a config admits: it arrives in the time given by the
    /// limits, and never passes its target.
    #[test]
    fn it_never_passes_its_target_in_all_decades_of_its_limits() {
        let decades = |exponent: f64| libm::pow(10.0, exponent);
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        let drawn = (
            (-9.0..15.0, -9.0..15.0, -9.0..15.0),
            (-3.6..-2.0, -9.0..0.0),
        );
        let tried = runner.run(&drawn, |((v, a, j), (dt, share))| {
            let (v, a, j, dt) = (decades(v), decades(a), decades(j), decades(dt));
            let limits = Limits::new(v, a, a, j).unwrap();
            let target = v.min(1e6) * decades(share);
            let mut ramp = Ramp::new(&moving(0.0, 0.0), target, limits);
            // v/a + a/j where the acceleration is reached, 2·√(v/j)
            // where not, and a few cycles that are not whole.
            let due = (target / a + 2.0 * libm::sqrt(target / j) + a.min(j) / j) / dt + 4.0;
            let mut before = 0.0;
            for cycle in 0..1_000 {
                ramp.step(target, 0.0, dt);
                let now = ramp.slave().velocity;
                prop_assert!(
                    (before..=target * (1.0 + 1e-9)).contains(&now),
                    "cycle {cycle}: {now} after {before}, {target}"
                );
                prop_assert!((now - before) / dt <= a * (1.0 + 1e-6), "{now} {before}");
                prop_assert!(
                    f64::from(cycle) < due || ramp.is_there(),
                    "{now} of {target}"
                );
                before = now;
            }
            Ok(())
        });
        tried.unwrap();
    }

    proptest! {
        #[test]
        fn differences_keep_the_limits_and_land(
            (velocity, target) in (-900.0..900.0, -900.0..900.0),
            pushed in -1.0..1.0,
            (acceleration, deceleration) in (500.0..8e3, 500.0..8e3),
            exponent in 4.0..6.5,
            drift in -1.0..1.0,
            change in prop::option::of((1_usize..200, -900.0..900.0)),
        ) {
            let jerk = libm::pow(10.0, exponent);
            let limits = limits(acceleration, deceleration, jerk);
            let start = limits.without_overspeed(&moving(velocity, pushed * acceleration.min(deceleration)));
            let mut ramp = Ramp::new(&start, target, limits);
            let most = acceleration.min(deceleration);
            // A target with a tenth of the slave's acceleration, so that the slave can catch up with it.
            let (mut target, pull) = (target, drift * 0.1 * most);
            for cycle in 0..6_000 {
                if let Some((at, to)) = change && cycle == at {
                    target = to;
                }
                let next: f64 = target + pull * DT;
                // The target stops accelerating at once, with time left to reach it.
                if next.abs() < 950.0 && cycle < 3_000 {
                    target = next;
                }
                let (before, was) = (ramp.slave().velocity, ramp.slave().acceleration);
                ramp.step(target, pull, DT);
                let now = (ramp.slave().velocity - before) / DT;
                // In the cycle of the reversal both limits have their part.
                let allowed = if before * ramp.slave().velocity < 0.0 {
                    acceleration.max(deceleration)
                } else if ramp.slave().velocity.abs() > before.abs() {
                    acceleration
                } else {
                    deceleration
                };
                prop_assert!(now.abs() <= allowed * (1.0 + 1e-9) + 1e-6, "{now} {allowed}");
                prop_assert!((now - was).abs() <= jerk * DT * (1.0 + 1e-6) + 1e-6, "{now} {was}");
                prop_assert!(ramp.slave().velocity.abs() <= 1_000.0 * (1.0 + 1e-12));
            }
            prop_assert_eq!(ramp.slave().velocity, target);
        }
    }
}
