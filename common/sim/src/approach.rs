//! Check that an axis that was left behind moves towards its target, and not away from it.

use coaxle_curve::profile::Limits;

/// Greatest second difference of an even target, as a share of the axis's acceleration.
const EVEN: f64 = 0.05;
/// Least acceleration away from the target that counts, as a share of its acceleration limit.
const AWAY: f64 = 0.05;
/// Cycles allowed in addition to those of the jerk: the axis waits a cycle after each target that
/// it could not follow, and derives the target's motion from three positions.
const CYCLES: f64 = 6.0;

/// Monitors an axis on its way to an evenly moving target.
///
/// The distance may grow while the axis has to brake first, but it has to brake: once the jerk
/// could have reversed the largest acceleration, in `2·a/j`, the growth of the distance must not
/// accelerate.
#[derive(Clone, Copy, Debug)]
pub struct ApproachCheck {
    acceleration: f64,
    /// Greatest number of successive cycles with acceleration away from the target.
    most: u32,
    cycle_time: f64,
    /// The last distances and target positions, newest first, and the number of known ones.
    last: [[f64; 2]; 2],
    known: u8,
    /// Successive cycles with acceleration away from the target.
    away: u32,
}

/// An axis that moves away from its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divergence {
    /// Distance from the target, u.
    pub distance: f64,
    /// Distance in the cycle before, u.
    pub before: f64,
}

impl ApproachCheck {
    /// Creates the check of an axis with these limits, in a node of this cycle time, s.
    #[must_use]
    pub fn new(limits: &Limits, cycle_time: f64) -> Self {
        // The larger one: the check does not know whether the axis has to speed up or to brake.
        let acceleration = limits.acceleration().max(limits.deceleration());
        // From the largest acceleration away to the largest towards it at full jerk: 2·a/j.
        let turns = 2.0 * acceleration / (limits.jerk() * cycle_time);
        Self {
            acceleration,
            most: (turns + CYCLES).ceil() as u32,
            cycle_time,
            last: [[0.0; 2]; 2],
            known: 0,
            away: 0,
        }
    }

    /// Restarts the check: the axis is prevented from approaching, or has no target.
    pub const fn restart(&mut self) {
        self.known = 0;
        self.away = 0;
    }

    /// Takes the next set position and its distance from the target, a cycle after the last.
    pub fn push(&mut self, position: f64, distance: f64) -> Option<Divergence> {
        // Distance is the axis minus the target, so that the target's position follows from both.
        let now = [distance, position - distance];
        let [last, first] = self.last;
        let second = |n: usize| {
            let time = self.cycle_time * self.cycle_time;
            (now[n] - 2.0 * last[n] + first[n]) / time
        };
        // An acceleration of the distance in the direction of the distance itself leads away.
        let [away, target] = [second(0) * distance.signum(), second(1)];
        // Without a change of sign: an axis that overshoots has reached its target.
        let grows = distance.abs() > last[0].abs() && distance * last[0] > 0.0;
        let is_away = self.known >= 2
            && grows
            && away > AWAY * self.acceleration
            // A target that accelerates leaves by itself, which is no fault of the axis.
            && target.abs() < EVEN * self.acceleration;
        self.away = if is_away { self.away + 1 } else { 0 };
        self.last = [now, last];
        self.known = (self.known + 1).min(2);
        (self.away > self.most).then_some(Divergence {
            distance: distance.abs(),
            before: last[0].abs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 1e-3;

    fn check(jerk: f64) -> ApproachCheck {
        ApproachCheck::new(&Limits::new(1_500.0, 5_000.0, 5_000.0, jerk).unwrap(), T)
    }

    /// Cycle in which a motion away from a target at rest is found, by its acceleration in each cycle.
    fn found(
        check: &mut ApproachCheck,
        from: f64,
        acceleration: impl Fn(u32) -> f64,
    ) -> Option<u32> {
        let (mut position, mut velocity) = (from, 0.0);
        (0..1_000).find(|cycle| {
            velocity += acceleration(*cycle) * T;
            position += velocity * T;
            check.push(position, position).is_some()
        })
    }

    #[test]
    fn an_axis_that_runs_the_wrong_way_is_found() {
        let away = found(&mut check(1e13), 3.0, |_| 5_000.0);
        assert_eq!(away, Some(9));
        let away = found(&mut check(1e13), -3.0, |_| -5_000.0);
        assert_eq!(away, Some(9));
        // After the hundred cycles that the jerk needs to reverse the acceleration.
        let away = found(&mut check(1e5), 3.0, |_| 5_000.0);
        assert_eq!(away, Some(108));
    }

    #[test]
    fn one_that_brakes_first_may_get_farther_away() {
        let mut check = check(1e5);
        let (mut position, mut velocity, mut acceleration) = (1.0, 400.0, 4_000.0);
        for _ in 0..200 {
            acceleration = f64::max(acceleration - 1e5 * T, -5_000.0);
            velocity += acceleration * T;
            position += velocity * T;
            assert_eq!(check.push(position, position), None);
        }
        assert!(position > 30.0 && velocity < 0.0);
    }

    #[test]
    fn a_target_that_accelerates_may_leave_it_behind() {
        let mut check = check(1e13);
        for cycle in 0..1_000 {
            let target = 0.5 * 5_000.0 * (f64::from(cycle) * T).powi(2);
            assert_eq!(check.push(0.0, -target), None);
        }
    }

    #[test]
    fn what_forbids_it_begins_anew() {
        let mut check = check(1e13);
        let (mut position, mut velocity) = (3.0, 0.0);
        for _ in 0..1_000 {
            velocity += 5.0;
            position += velocity * T;
            check.restart();
            assert_eq!(check.push(position, position), None);
        }
    }
}
