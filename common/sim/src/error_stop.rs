//! Check that an axis in error stop comes to rest within the distance of its limits.

use coaxle_curve::profile::{Kinematics, Limits};

/// Delay of an error stop, cycles: its first set values come a cycle after the cause.
const LATE: f64 = 2.0;
/// Allowed excess over the shortest stop, relative: a stop is calculated in whole cycles.
const LONGER: f64 = 0.01;

/// Monitors the error stops of one axis.
#[derive(Clone, Copy, Debug)]
pub struct ErrorStopCheck {
    limits: Limits,
    cycle_time: f64,
    /// Set values of the cycle before the stop.
    before: Option<Kinematics>,
    /// The current stop.
    stop: Option<Stop>,
}

/// Start of the stop, and the greatest distance from there, u.
#[derive(Clone, Copy, Debug)]
struct Stop {
    from: f64,
    most: f64,
}

/// A stop that takes too far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceExceeded {
    /// Distance from the start, u.
    pub way: f64,
    /// Greatest allowed distance, u.
    pub most: f64,
}

impl ErrorStopCheck {
    /// Creates the check for an axis of these limits, in a node of this cycle time, s.
    #[must_use]
    pub const fn new(limits: Limits, cycle_time: f64) -> Self {
        Self {
            limits,
            cycle_time,
            before: None,
            stop: None,
        }
    }

    /// Restarts the check: the axis is not in error stop, with these set values, or its position was preset.
    pub const fn restart(&mut self, set: Option<Kinematics>) {
        self.before = set;
        self.stop = None;
    }

    /// Takes the next set values in error stop, with the axis's distances from its target in the
    /// cycle before and now: while the axis catches up, the target stops, and the axis has to reach
    /// it.
    pub fn push(&mut self, set: &Kinematics, distances: [f64; 2]) -> Option<DistanceExceeded> {
        let [_, behind] = distances.map(f64::abs);
        let stop = match self.stop {
            Some(stop) => stop,
            None => Stop {
                from: set.position,
                // An axis that catches up covers its distance to the target as well.
                most: self
                    .longest_way_of_target(set, distances)
                    .max(self.longest_way_from_before(set))
                    + behind,
            },
        };
        self.stop = Some(stop);
        let way = (set.position - stop.from).abs();
        // Rest of the distance now: the target itself may have gone on by as much.
        let most = stop.most + behind;
        (way > most).then_some(DistanceExceeded { way, most })
    }

    /// Longest stop of the target. The direction of its velocity relative to the axis is unknown,
    /// so both are tried.
    fn longest_way_of_target(&self, set: &Kinematics, [before, now]: [f64; 2]) -> f64 {
        let faster = (now - before).abs() / self.cycle_time;
        let ways = [-faster, faster].map(|by| {
            let velocity = set.velocity + by;
            self.longest_way(&Kinematics { velocity, ..*set })
        });
        ways[0].max(ways[1])
    }

    /// Distance to rest of a stop that is planned from the set values of the cycle before. Those of an axis that catches up change by its
    /// whole acceleration from cycle to cycle, and the first ones of its stop, at `v − a·T`, give no bound: wide schedule 300282 stops from
    /// 251 u/s at 30 106 u/s² within v²/2d = 1.044 u, a cycle after which it is at 94 u/s.
    fn longest_way_from_before(&self, set: &Kinematics) -> f64 {
        self.before.map_or(0.0, |before| {
            let gone = (set.position - before.position) * before.velocity.signum();
            self.longest_way(&before) - gone
        })
    }

    /// Distance to rest with the full deceleration and jerk, after the acceleration is removed,
    /// which may reverse the axis.
    fn longest_way(&self, set: &Kinematics) -> f64 {
        let jerk = self.limits.jerk();
        let acceleration = set.acceleration.abs();
        // The direction of the acceleration counts as forward, which halves the cases.
        let speed = set.velocity * set.acceleration.signum();
        let until_even = acceleration / jerk;
        // Speed once the acceleration is 0: the jerk removes it in a/j, over which its mean is a/2.
        let even = speed + 0.5 * acceleration * until_even;
        let (way, fastest) = if even < 0.0 {
            // The axis brakes already, and not too hard.
            (self.way_from_even(-speed), -speed)
        } else {
            // v·t + a·t²/2 - j·t³/6 with t = a/j: the last two terms are a³/(3·j²).
            let first = speed * until_even + acceleration.powi(3) / (3.0 * jerk * jerk);
            let on = first.max(0.0) + self.way_from_even(even);
            // An axis that moves against its acceleration first goes on backwards, and only one of both ways counts.
            let back = (-speed).max(0.0);
            (on.max(back * until_even), even.max(back))
        };
        let late = LATE * self.cycle_time * fastest;
        // Positions carry a relative rounding of 2e-16 per operation; sums of them stay far below this.
        let rounding = 1e-9 * (1.0 + set.position.abs());
        way * (1.0 + LONGER) + late + rounding
    }

    /// Distance to rest from a constant speed.
    fn way_from_even(&self, speed: f64) -> f64 {
        let (jerk, deceleration) = (self.limits.jerk(), self.limits.deceleration());
        // The ramps of the jerk alone take the speed d²/j. Above it the deceleration d is held in between.
        if speed * jerk >= deceleration * deceleration {
            0.5 * speed * (speed / deceleration + deceleration / jerk)
        } else {
            // Two ramps of √(v/j) each, at v/2 on average.
            speed * (speed / jerk).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: f64 = 1e-3;

    fn check() -> ErrorStopCheck {
        ErrorStopCheck::new(
            Limits::new(500.0, 1_000.0, 2_000.0, 50_000.0).unwrap(),
            CYCLE,
        )
    }

    /// Simulates the shortest stop from a velocity, in steps far shorter than a cycle, with a share
    /// of the deceleration.
    fn stopped(check: &mut ErrorStopCheck, velocity: f64, share: f64) -> Option<DistanceExceeded> {
        let (mut set, step) = (Kinematics::at_rest(1_000.0), 1e-6);
        set.velocity = velocity;
        let (most, jerk) = (2_000.0 * share, 50_000.0 * share);
        let mut worst = None;
        for _ in 0..3_000_000 {
            worst = check.push(&set, [0.0; 2]).or(worst);
            // Down while the rest takes more than removing the deceleration.
            let back = set.acceleration * set.acceleration / (2.0 * jerk);
            let slope = if set.velocity > back { -jerk } else { jerk };
            set.acceleration = (set.acceleration + slope * step).clamp(-most, 0.0);
            set.velocity = (set.velocity + set.acceleration * step).max(0.0);
            set.position += set.velocity * step;
            if set.velocity == 0.0 {
                break;
            }
        }
        worst
    }

    #[test]
    fn the_shortest_stop_passes_and_a_weaker_one_does_not() {
        for velocity in [3.0, 60.0, 480.0] {
            assert_eq!(stopped(&mut check(), velocity, 1.0), None, "{velocity}");
            let weak = stopped(&mut check(), velocity, 0.4).expect("too far");
            assert!(weak.way > weak.most);
        }
    }

    #[test]
    fn an_acceleration_has_to_go_first() {
        let mut check = check();
        let mut set = Kinematics::at_rest(0.0);
        set.velocity = 100.0;
        let without = check.longest_way(&set);
        set.acceleration = 1_000.0;
        assert!(check.longest_way(&set) > without + 2.0);
        set.acceleration = -1_000.0;
        assert!((check.longest_way(&set) - without).abs() < 1e-9);
        assert_eq!(check.push(&set, [0.0; 2]), None);
        set.position = 50.0;
        assert!(check.push(&set, [0.0; 2]).is_some());
        check.restart(None);
        assert_eq!(check.push(&set, [0.0; 2]), None);
    }

    /// Wide schedule 300282: planned from 251 u/s, and at 94 u/s in its first cycle, on top of a target that is ahead.
    #[test]
    fn a_stop_is_planned_from_the_cycle_before() {
        let limits = Limits::new(36_839.646, 156_285.177, 30_105.8, 31_659_297_395.253).unwrap();
        let set = |position, velocity, acceleration| Kinematics {
            position,
            velocity,
            acceleration,
        };
        let first = set(195.535_634, 94.476, -150_596.113);
        let distances = [-0.263_333_469, -0.192_376_639];
        let is_beyond = |before, rest| {
            let mut check = ErrorStopCheck::new(limits, CYCLE);
            check.restart(before);
            assert_eq!(check.push(&first, distances), None);
            check.push(&Kinematics::at_rest(rest), [0.0; 2]).is_some()
        };
        let before = Some(set(195.491_755, 250.761_177, 156_285.177));
        assert!(is_beyond(None, 196.540_665));
        assert!(!is_beyond(before, 196.540_665));
        // v²/2d, two cycles and the way that it was behind.
        assert!(is_beyond(
            before,
            195.491_755 + 1.01 * 1.044_5 + 2.0 * 0.251 + 0.2
        ));
    }

    #[test]
    fn an_axis_that_catches_up_goes_where_its_target_stops() {
        let set = |position| Kinematics::at_rest(position);
        for (distances, way) in [([0.0, 0.0], 1e-4), ([0.5, 0.5], 0.5), ([0.2, 0.25], 1.0)] {
            let mut check = check();
            assert_eq!(check.push(&set(0.0), distances), None);
            assert_eq!(
                check.push(&set(0.9 * way), [0.0; 2]).is_some(),
                distances[1] == 0.0
            );
            assert!(check.push(&set(20.0), [0.0; 2]).is_some());
        }
    }

    #[test]
    fn an_acceleration_may_turn_it_round() {
        let check = check();
        for forward in [1.0, -1.0] {
            let mut set = Kinematics::at_rest(0.0);
            (set.velocity, set.acceleration) = (forward, -forward * 1_000.0);
            // 20 ms to zero acceleration, at 9 u/s backwards, and down from there at the full jerk.
            let until_even = -0.02 + 1_000.0_f64.powi(3) / (3.0 * 50_000.0_f64.powi(2));
            let shortest = until_even + 9.0 * (9.0_f64 / 50_000.0).sqrt();
            let longest = check.longest_way(&set);
            assert!(longest >= shortest, "{longest} {shortest}");
            assert!(longest <= 1.01 * shortest + LATE * CYCLE * 9.0 + 1e-6);
        }
    }
}
