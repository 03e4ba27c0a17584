//! Whether an axis that was left behind goes to its target, and not away from it.

use coaxle_curve::profile::Limits;

/// A target whose second difference is less than this share of the axis's acceleration goes on as it does.
const EVEN: f64 = 0.05;
/// The axis accelerates away from the target if it does so with more than this share of its acceleration.
const AWAY: f64 = 0.05;
/// Beside what the jerk asks for: the axis waits a cycle after each target that it could not follow, and knows how a target moves
/// by three positions of it.
const CYCLES: f64 = 6.0;

/// Watches an axis on its way to a target that goes on evenly.
///
/// It may get farther from it while it has to brake first, but it has to brake: once the jerk could have turned the largest
/// acceleration round, in `2·a/j`, the distance never grows faster and faster.
#[derive(Clone, Copy, Debug)]
pub struct ApproachCheck {
    acceleration: f64,
    /// Cycles in a row in which it may accelerate away.
    most: u32,
    cycle_time: f64,
    /// The last distances, and positions of the target, newest first, and how many of them are known.
    last: [[f64; 2]; 2],
    known: u8,
    /// Cycles in a row in which it accelerated away.
    away: u32,
}

/// An axis that goes away from its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoesAway {
    /// How far it is from it, u.
    pub distance: f64,
    /// How far it was in the cycle before, u.
    pub before: f64,
}

impl ApproachCheck {
    /// The check of an axis with these limits, in a node of this cycle time, s.
    #[must_use]
    pub fn new(limits: &Limits, cycle_time: f64) -> Self {
        let acceleration = limits.acceleration().max(limits.deceleration());
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

    /// Something forbids that it comes closer, or there is nothing to go to.
    pub const fn restart(&mut self) {
        self.known = 0;
        self.away = 0;
    }

    /// The next set position and how far it is from its target, a cycle after the last.
    pub fn push(&mut self, position: f64, distance: f64) -> Option<GoesAway> {
        let now = [distance, position - distance];
        let [last, first] = self.last;
        let second = |n: usize| {
            let time = self.cycle_time * self.cycle_time;
            (now[n] - 2.0 * last[n] + first[n]) / time
        };
        let [away, target] = [second(0) * distance.signum(), second(1)];
        let grows = distance.abs() > last[0].abs() && distance * last[0] > 0.0;
        let is_away = self.known >= 2
            && grows
            && away > AWAY * self.acceleration
            && target.abs() < EVEN * self.acceleration;
        self.away = if is_away { self.away + 1 } else { 0 };
        self.last = [now, last];
        self.known = (self.known + 1).min(2);
        (self.away > self.most).then_some(GoesAway {
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

    /// In which cycle it is found to go away from a target that stands, by its acceleration in each.
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
        // Of a hundred cycles that the jerk needs to turn the acceleration round.
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
