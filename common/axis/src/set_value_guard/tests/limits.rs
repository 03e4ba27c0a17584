//! Limits that change while the axis moves.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};

use super::super::{GuardState, SetValueGuard};
use super::motion::{Axis, Motion, scaled};
use super::random::Random;
use super::watch::{Used, Watch};

/// Quantities that were over a lowered limit, and are not any more.
#[derive(Default)]
pub(super) struct Settled {
    acceleration: bool,
    velocity: bool,
}

impl Settled {
    /// True if all expectations of this cycle are met.
    pub(super) fn see(&mut self, used: Used, watch: &Watch) -> bool {
        let holds = used.jerk <= 1.0
            && !(self.acceleration && used.acceleration > 1.0)
            && !(self.velocity && used.velocity > 1.0);
        self.acceleration |= used.acceleration <= 1.0;
        self.velocity |= self.acceleration && watch.can_keep_velocity();
        holds
    }
}

/// Longest time until all quantities are within lowered limits, s.
fn settling_time(before: &Limits, after: &Limits) -> f64 {
    // Acceleration to 0, then the speed gained meanwhile down at the lowered limits.
    let release = before.acceleration() / after.jerk();
    let gained = before.velocity() + before.acceleration() * release;
    2.0 * release + gained / after.acceleration() + 4.0 * after.acceleration() / after.jerk()
}

fn lowered_limits_are_kept(seed: u64) {
    let random = &mut Random::seeded(seed);
    let axis = Axis::by_chance(random);
    let t = axis.cycle_time;
    let none = (f64::NEG_INFINITY, f64::INFINITY);
    let start = Kinematics::at_rest(axis.origin);
    let mut guard = SetValueGuard::new(&axis.limits, none.0, none.1, Seconds(t), &start).unwrap();
    let mut watch = Watch::at_rest(axis.origin, &axis.limits, t);
    let mut motion = Motion::starting_at(start, axis.limits);
    for _ in 0..100 + random.below(300) {
        let _ = watch.see(guard.update(&motion.next(random, t), 1).set.position, 1);
    }
    if random.percent(50) {
        // While it catches up.
        let size = axis.limits.velocity() * axis.ramp();
        motion.jump(size * random.between(-1.0, 1.0), random.between(-0.5, 0.5));
        for _ in 0..1 + random.below(100) {
            let _ = watch.see(guard.update(&motion.next(random, t), 1).set.position, 1);
        }
    }

    let lowered = scaled(&axis.limits, random.between(0.1, 1.0));
    guard.set_limits(&lowered);
    watch.set_limits(&lowered);
    let mut motion = Motion::starting_at(motion.here, lowered);
    motion.cruise(random.between(-0.5, 0.5));
    let mut settled = Settled::default();
    let time = settling_time(&axis.limits, &lowered);
    for cycle in 0..(time / t) as u32 + 10 {
        let used = watch.see(guard.update(&motion.next(random, t), 1).set.position, 1);
        let kept = settled.see(used, &watch);
        assert!(
            kept,
            "seed {seed}, cycle {cycle}, {axis:?}, {lowered:?}: {used:?}"
        );
    }
    assert!(settled.velocity, "seed {seed}, {axis:?}, {lowered:?}");

    let distance = (motion.here.position - watch.position()).abs();
    let time = distance / (0.4 * lowered.velocity()) + 10.0 * axis.ramp();
    let rejoins = (0..(time / t) as u32 + 100)
        .any(|_| guard.update(&motion.next(random, t), 1).state == GuardState::Tracking);
    assert!(rejoins, "seed {seed}, {axis:?}, {lowered:?}");
}

#[test]
fn lowered_limits_are_kept_as_soon_as_the_jerk_allows() {
    (0..300).for_each(lowered_limits_are_kept);
}

#[test]
#[ignore = "many seconds"]
fn ten_thousand_lowered_limits_are_kept() {
    (0..10_000).for_each(lowered_limits_are_kept);
}

#[test]
fn raised_limits_are_used() {
    let limits = Limits::new(10.0, 100.0, 100.0, 1_000.0).unwrap();
    let start = Kinematics::at_rest(0.0);
    let none = (f64::NEG_INFINITY, f64::INFINITY);
    let mut guard = SetValueGuard::new(&limits, none.0, none.1, Seconds(0.001), &start).unwrap();
    let target = Kinematics::at_rest(1e3);
    let velocity_after_a_second = |guard: &mut SetValueGuard| {
        let all = (0..1_000).map(|_| guard.update(&target, 1).set.velocity);
        all.last().unwrap()
    };
    assert!((velocity_after_a_second(&mut guard) - 10.0).abs() < 1e-9);
    guard.set_limits(&scaled(&limits, 3.0));
    assert!((velocity_after_a_second(&mut guard) - 30.0).abs() < 1e-9);
}

#[test]
fn software_limits_that_come_closer_are_passed_no_farther_than_by_the_hardest_stop() {
    let limits = Limits::new(10.0, 100.0, 100.0, 10_000.0).unwrap();
    let mut target = Kinematics {
        position: 0.0,
        velocity: 10.0,
        acceleration: 0.0,
    };
    let mut guard = SetValueGuard::new(&limits, -1e3, 1e3, Seconds(0.001), &target).unwrap();
    let mut farthest: f64 = 0.0;
    let mut last = 0.0;
    for cycle in 1..3_000 {
        target.position = 0.01 * f64::from(cycle);
        if cycle == 100 {
            guard.set_software_limits(-1e3, 1.2);
        }
        last = guard.update(&target, 1).set.position;
        farthest = farthest.max(last);
    }
    // From 1 at 10 u/s: 0.5 u of braking, 0.05 u while it sets in.
    assert!((1.52..1.55).contains(&farthest), "{farthest}");
    assert!((last - 1.2).abs() < 0.4, "{last}");
}
