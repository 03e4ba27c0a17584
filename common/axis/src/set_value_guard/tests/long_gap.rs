//! Gaps of more cycles than are simulated one by one.

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};

use super::super::approach::stopping;
use super::super::{MOST_CYCLES, SetValueGuard};
use super::random::Random;
use super::watch::Watch;

/// An axis somewhere within its limits, in motion.
fn in_motion(random: &mut Random) -> (Limits, f64, Kinematics) {
    let cycle_time = random.decades(2.5e-4, 1e-2);
    let velocity = random.decades(10.0, 3_000.0);
    let acceleration = velocity / random.decades(0.05, 5.0);
    let jerk = acceleration / random.decades(0.01, 5.0);
    let limits = Limits::new(velocity, acceleration, acceleration, jerk).unwrap();
    let here = Kinematics {
        position: random.between(-100.0, 100.0),
        velocity: velocity * random.between(-0.7, 0.7),
        // Its release gains a²/2j.
        acceleration: (acceleration * random.between(-1.0, 1.0)).clamp(
            -libm::sqrt(0.5 * jerk * velocity),
            libm::sqrt(0.5 * jerk * velocity),
        ),
    };
    (limits, cycle_time, here)
}

fn guard(limits: &Limits, walls: [f64; 2], cycle_time: f64, here: &Kinematics) -> SetValueGuard {
    let [min, max] = walls;
    SetValueGuard::new(limits, min, max, Seconds(cycle_time), here).unwrap()
}

const NO_WALLS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// As `brake_for` does it in a few steps.
fn braked_one_by_one(guard: &mut SetValueGuard, cycles: u32) {
    for _ in 0..cycles {
        guard.advance(stopping(&guard.envelope, &guard.history.set));
    }
}

#[test]
fn a_stop_in_a_few_steps_is_that_of_single_cycles() {
    for seed in 0..300 {
        let random = &mut Random::seeded(seed);
        let (limits, cycle_time, here) = in_motion(random);
        let mut quick = guard(&limits, NO_WALLS, cycle_time, &here);
        let mut slow = quick;
        let mut total = 0;
        for _ in 0..4 {
            let cycles = random.decades(1.0, 10_000.0) as u32;
            total += cycles;
            quick.brake_for(cycles);
            braked_one_by_one(&mut slow, cycles);
            let (one, other) = (quick.history.set, slow.history.set);
            let way = (here.position - other.position).abs() + 100.0;
            let apart = (one.position - other.position).abs() / way;
            assert!(apart < 1e-7, "seed {seed}, {total}: {one:?} {other:?}");
            let apart = (one.velocity - other.velocity).abs() / limits.velocity();
            assert!(apart < 1e-6, "seed {seed}, {total}: {one:?} {other:?}");
        }
    }
}

/// Wide schedule 608381: the axis stood still for 892 of 5 892 skipped cycles, at 432 u/s.
#[test]
fn an_axis_keeps_its_limits_over_any_gap() {
    let limits = Limits::new(2_131.116, 465.113, 4_027.0, 597.537).unwrap();
    let here = Kinematics {
        position: -374.1,
        velocity: 432.46,
        acceleration: 1_424.9,
    };
    let target = Kinematics::at_rest(1_490.0);
    for skipped in [5_001, 5_892, 8_000, 20_000, 4_000_000] {
        let mut guard = guard(&limits, NO_WALLS, 2.5e-4, &here);
        let mut watch = Watch::at_rest(0.0, &limits, 2.5e-4);
        watch.start(&here);
        for elapsed in [1, 1, skipped, 1, 1, 1, skipped, 1, 1, 1] {
            let guarded = guard.update(&target, elapsed);
            let used = watch.see(guarded.set.position, elapsed);
            assert!(used.most() <= 1.0, "{skipped}: {used:?}");
        }
    }
}

#[test]
fn limits_and_walls_are_kept_over_gaps_of_any_length() {
    for seed in 0..200 {
        let random = &mut Random::seeded(seed);
        let (limits, cycle_time, here) = in_motion(random);
        let start = Kinematics::at_rest(here.position);
        let room = limits.velocity() * random.decades(0.01, 10.0);
        let walls = match random.percent(50) {
            true => [here.position - room, here.position + room],
            false => NO_WALLS,
        };
        let mut guard = guard(&limits, walls, cycle_time, &start);
        let mut watch = Watch::at_rest(start.position, &limits, cycle_time);
        for step in 0..60 {
            let elapsed = match random.percent(20) {
                true => random.decades(1.0, 1e5) as u32,
                false => 1,
            };
            let target = match random.percent(5) {
                true => Kinematics::at_rest(f64::NAN),
                false => Kinematics {
                    position: here.position + room * random.between(-1.0, 1.0),
                    ..here
                },
            };
            let set = guard.update(&target, elapsed).set;
            let used = watch.see(set.position, elapsed);
            assert!(
                used.most() <= 1.0,
                "seed {seed}, step {step}, {elapsed}: {used:?}"
            );
            let rounding = 1e-12 * (limits.velocity() + set.position.abs());
            assert!(
                (walls[0] - rounding..=walls[1] + rounding).contains(&set.position),
                "seed {seed}, step {step}, {elapsed}: {set:?} {walls:?}"
            );
        }
    }
    assert_eq!(MOST_CYCLES, 5_000, "the gaps above are longer");
}
