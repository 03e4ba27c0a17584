//! Every limit that a config admits, in every combination: 1e-9 to 1e15 each, and cycles from 0.25
//! to 10 ms.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits, to_position};

use super::super::{GuardState, SetValueGuard};
use super::random::Random;
use super::watch::Watch;

/// Range of limits in a config, see [`is_limit`](crate::guard::is_limit).
const LEAST: f64 = 1e-9;
const MOST: f64 = 1e15;

/// Longer motions are begun, not finished.
const CYCLES: u32 = 2_000;

/// Rounding of positions of this size under limits, u.
fn rounding(size: f64, limits: &Limits) -> f64 {
    // The promise for software limits, where a velocity limit that means "none" counts as 1e6 u/s.
    128.0 * f64::EPSILON * size.max(limits.velocity().min(1e6))
}

fn limits_by_chance(random: &mut Random) -> Limits {
    let [velocity, acceleration, jerk] = [(); 3].map(|()| random.decades(LEAST, MOST));
    Limits::new(velocity, acceleration, acceleration, jerk).unwrap()
}

/// True if a step keeps all limits as far as visible when it comes: such a step passes unchanged.
fn is_within_a_cycle(step: f64, limits: &Limits, cycle_time: f64) -> bool {
    let rate = 1.0 / cycle_time;
    let velocity = step.abs() * rate;
    velocity <= limits.velocity()
        && velocity * rate <= limits.acceleration()
        && velocity * rate * rate <= limits.jerk()
}

/// A motion from rest to rest.
struct Way {
    limits: Limits,
    cycle_time: f64,
    to: f64,
    /// Software limits on both sides, u.
    walls: f64,
}

impl Way {
    /// Asserts that it moves straight to its goal, and arrives at about the time of the fastest motion.
    fn assert_goes_straight(&self) {
        let start = Kinematics::at_rest(0.0);
        let (limits, cycle_time) = (&self.limits, Seconds(self.cycle_time));
        let mut guard =
            SetValueGuard::new(limits, -self.walls, self.walls, cycle_time, &start).unwrap();
        let mut watch = Watch::at_rest(0.0, limits, self.cycle_time);
        let goal = self.to.min(self.walls).max(-self.walls);
        let due = to_position(&start, goal, limits).duration().0 / self.cycle_time;
        // 2 % over the time-optimal bound, and a few whole cycles for its beginning and end.
        let due = 1.02 * due + 12.0;
        let name = std::format!("to {} with {:?}, T {}", self.to, limits, self.cycle_time);
        let slack = rounding(self.to.abs(), limits);
        let mut left = goal.abs();
        for cycle in 1..=CYCLES {
            let guarded = guard.update(&Kinematics::at_rest(self.to), 1);
            let set = guarded.set.position;
            let used = watch.see(set, 1);
            assert!(used.most() <= 1.0, "{name}: cycle {cycle}: {used:?}");
            let left_now = (goal - set).abs();
            assert!(
                left_now <= left + slack && (goal - set) * goal >= -slack * goal.abs(),
                "{name}: cycle {cycle}: {set} is not on the way, {left} were left"
            );
            left = left_now;
            if f64::from(cycle) >= due {
                assert!(left <= slack, "{name}: cycle {cycle}: {left} are left");
                let is_there = self.to == goal;
                assert!(
                    !is_there || guarded.state == GuardState::Tracking,
                    "{name}: {guarded:?}"
                );
            }
        }
    }
}

/// An axis whose jerk limit means "none".
#[test]
fn a_jerk_limit_that_means_none_leads_straight_to_the_target() {
    for jerk in [1e6, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15] {
        for to in [100.0, -0.01] {
            Way {
                limits: Limits::new(1_500.0, 5_000.0, 5_000.0, jerk).unwrap(),
                cycle_time: 0.001,
                to,
                walls: f64::INFINITY,
            }
            .assert_goes_straight();
        }
    }
}

/// LinuxCNC 2316: rate limits that mean "none" leave the position limit in force.
#[test]
fn limits_that_mean_none_do_not_switch_the_software_limits_off() {
    for cycle_time in [0.00025, 0.001, 0.01] {
        for walls in [50.0, f64::INFINITY] {
            Way {
                limits: Limits::new(1e4, 1e15, 1e15, 1e15).unwrap(),
                cycle_time,
                to: 100.0,
                walls,
            }
            .assert_goes_straight();
        }
    }
}

#[test]
fn it_goes_straight_in_all_decades_of_its_limits() {
    let random = &mut Random::seeded(34);
    for _ in 0..3_000 {
        let limits = limits_by_chance(random);
        let side = if random.percent(50) { 1.0 } else { -1.0 };
        let cycle_time = random.decades(0.25e-3, 10e-3);
        let to = side * random.decades(1e-6, 1e6);
        if is_within_a_cycle(to, &limits, cycle_time) {
            continue;
        }
        let walls = if random.percent(30) {
            to.abs() * random.between(0.2, 1.0)
        } else {
            f64::INFINITY
        };
        Way {
            limits,
            cycle_time,
            to,
            walls,
        }
        .assert_goes_straight();
    }
}

/// Two motions, of axis and target, as fast as the axis may be or slower.
#[test]
fn it_lands_on_a_moving_target_in_all_decades_of_its_limits() {
    let random = &mut Random::seeded(35);
    let mut landings = 0;
    for _ in 0..3_000 {
        let limits = limits_by_chance(random);
        let cycle_time = random.decades(0.25e-3, 10e-3);
        // Limits that mean "none" are not used as speeds.
        let fastest = limits.velocity().min(1e5);
        let [from, to] = [(); 2].map(|()| random.between(-0.8, 0.8) * fastest);
        let start = Kinematics {
            position: 0.0,
            velocity: from,
            acceleration: 0.0,
        };
        let ahead = random.between(-1.0, 1.0) * fastest * random.decades(1e-4, 1.0);
        let target = |cycle: u32| Kinematics {
            position: ahead + to * cycle_time * f64::from(cycle),
            velocity: to,
            acceleration: 0.0,
        };
        let none = f64::INFINITY;
        let mut guard =
            SetValueGuard::new(&limits, -none, none, Seconds(cycle_time), &start).unwrap();
        let mut watch = Watch::at_rest(0.0, &limits, cycle_time);
        watch.start(&start);
        let name = std::format!("from {from} to {to}, ahead {ahead}, {limits:?}, T {cycle_time}");
        let mut tracking = 0;
        for cycle in 1..=CYCLES {
            let guarded = guard.update(&target(cycle), 1);
            let used = watch.see(guarded.set.position, 1);
            assert!(used.most() <= 1.0, "{name}: cycle {cycle}: {used:?}");
            let is_tracking = guarded.state == GuardState::Tracking;
            tracking = if is_tracking { tracking + 1 } else { 0 };
        }
        // Upper bound of a ramp: 2v/a and 2a/j at full acceleration, 4√(v/j) where the jerk alone limits it.
        let ramp = 2.0 * limits.velocity() / limits.acceleration()
            + 2.0 * limits.acceleration().min(1e18 * limits.jerk()) / limits.jerk()
            + 4.0 * libm::sqrt(limits.velocity() / limits.jerk());
        let due = (2.0 * ramp + 10.0 * (ahead.abs() + fastest * ramp) / (0.2 * limits.velocity()))
            / cycle_time
            + 20.0;
        if due < f64::from(CYCLES) - 100.0 {
            landings += 1;
            assert!(tracking >= 100, "{name}: not landed, due in {due} cycles");
        }
    }
    // Most of these combinations need more than the cycles simulated here.
    assert!(landings > 250, "{landings}");
}
