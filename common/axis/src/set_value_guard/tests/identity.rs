//! A target that keeps the limits passes with its own bits.

use std::vec::Vec;

use coaxle_clock::Seconds;
use coaxle_curve::profile::{Kinematics, Limits};

use super::super::{GuardState, SetValueGuard};
use super::motion::{Axis, Motion, scaled};
use super::random::Random;

const CYCLES: u32 = 2_000;

/// A motion from standstill to standstill, and the numbers of cycles between its states.
struct Path {
    axis: Axis,
    start: Kinematics,
    states: Vec<(Kinematics, u32)>,
    min: f64,
    max: f64,
}

impl Path {
    fn of(
        mut axis: Axis,
        random: &mut Random,
        limits: impl Fn(&Limits, &mut Random) -> Limits,
    ) -> Self {
        axis.limits = limits(&axis.limits, random);
        let start = Kinematics::at_rest(axis.origin);
        Self {
            axis,
            start,
            states: Vec::new(),
            min: start.position,
            max: start.position,
        }
    }

    /// Extends it along its limits, each multiplied by a share.
    fn along(mut self, share: f64, skips: bool, random: &mut Random) -> Self {
        let mut motion = Motion::starting_at(self.start, scaled(&self.axis.limits, share));
        for cycle in 0.. {
            if cycle == CYCLES {
                motion.cruise(0.0);
            }
            if cycle >= CYCLES && motion.here.velocity == 0.0 {
                break;
            }
            let skipped = skips && random.percent(5);
            let elapsed = if skipped { 2 + random.below(9) } else { 1 };
            for _ in 0..elapsed {
                let here = motion.next(random, self.axis.cycle_time);
                self.min = self.min.min(here.position);
                self.max = self.max.max(here.position);
            }
            self.states.push((motion.here, elapsed));
        }
        self
    }

    fn assert_passes(&self, min: f64, max: f64, seed: u64) {
        let cycle_time = Seconds(self.axis.cycle_time);
        let mut guard =
            SetValueGuard::new(&self.axis.limits, min, max, cycle_time, &self.start).unwrap();
        for (cycle, (target, elapsed)) in self.states.iter().enumerate() {
            let guarded = guard.update(target, *elapsed);
            // Bits and not values: 0 and -0 are equal, but not the same target.
            let bits = |k: &Kinematics| [k.position, k.velocity, k.acceleration].map(f64::to_bits);
            assert!(
                guarded.state == GuardState::Tracking && bits(&guarded.set) == bits(target),
                "seed {seed}, cycle {cycle}, {:?}: {guarded:?}, expected {target:?}",
                self.axis
            );
        }
    }
}

/// Full limits; in a third of the axes, the deceleration is less than the acceleration.
fn full(limits: &Limits, random: &mut Random) -> Limits {
    let (v, a, j) = (limits.velocity(), limits.acceleration(), limits.jerk());
    let share = if random.percent(33) {
        random.between(0.3, 1.0)
    } else {
        1.0
    };
    Limits::new(v, a, share * a, j).unwrap()
}

/// Motions at full limits, with the software limits at their reversal points.
fn full_limit_motions_pass(seeds: core::ops::Range<u64>) {
    for seed in seeds {
        let random = &mut Random::seeded(seed);
        let path = Path::of(Axis::by_chance(random), random, full).along(1.0, false, random);
        path.assert_passes(path.min, path.max, seed);
    }
}

#[test]
fn motions_along_all_limits_pass_and_touch_the_walls() {
    full_limit_motions_pass(0..1_000);
}

#[test]
#[ignore = "many seconds"]
fn ten_thousand_motions_along_all_limits_pass() {
    full_limit_motions_pass(0..10_000);
}

#[test]
fn motions_with_a_reserve_pass_where_cycles_were_skipped() {
    for seed in 0..200 {
        let random = &mut Random::seeded(seed);
        // Changes within a gap are small.
        let slow = |limits: &Limits, _: &mut Random| {
            let jerk = limits.jerk() / 100.0;
            Limits::new(
                limits.velocity(),
                limits.acceleration() / 10.0,
                limits.acceleration() / 10.0,
                jerk,
            )
            .unwrap()
        };
        let path = Path::of(Axis::usual(random), random, slow).along(1.0 / 1.2, true, random);
        path.assert_passes(f64::NEG_INFINITY, f64::INFINITY, seed);
    }
}

#[test]
fn zeros_keep_their_sign() {
    let limits = Limits::new(1.0, 1.0, 1.0, 1.0).unwrap();
    let start = Kinematics::at_rest(0.0);
    let mut guard = SetValueGuard::new(&limits, 0.0, 1.0, Seconds(0.001), &start).unwrap();
    let target = Kinematics {
        position: -0.0,
        velocity: -0.0,
        acceleration: -0.0,
    };
    let set = guard.update(&target, 1).set;
    for value in [set.position, set.velocity, set.acceleration] {
        assert!(value == 0.0 && value.is_sign_negative());
    }
}
