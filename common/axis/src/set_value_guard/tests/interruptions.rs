//! Changes of limits, walls and policies, and restarts, at any moment of any stream.

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use super::super::{DistancePolicy, Guarded, SetValueGuard};
use super::limits::Settled;
use super::motion::{Axis, Motion, scaled};
use super::random::Random;
use super::trouble::{TROUBLES, Trouble, Troubled};
use super::watch::Watch;

struct Interrupted {
    axis: Axis,
    guard: SetValueGuard,
    watch: Watch,
    settled: Settled,
    last: Kinematics,
}

/// A random axis to be interrupted, the trouble of its target, and the target.
fn by_chance(seed: u64, random: &mut Random) -> (Interrupted, Trouble, Troubled) {
    let axis = Axis::by_chance(random);
    let start = Kinematics::at_rest(axis.origin);
    // The guard needs some 20 % above the planned limits to catch up.
    let motion = Motion::starting_at(start, scaled(&axis.limits, 1.0 / 1.2));
    // Each kind equally often: the numbers of seeds are multiples of 13.
    let trouble = TROUBLES[(seed % TROUBLES.len() as u64) as usize];
    let target = Troubled::new(trouble, &axis, motion, random);
    (Interrupted::at_rest(axis), trouble, target)
}

impl Interrupted {
    fn at_rest(axis: Axis) -> Self {
        let start = Kinematics::at_rest(axis.origin);
        let t = axis.cycle_time;
        let none = (f64::NEG_INFINITY, f64::INFINITY);
        Self {
            axis,
            guard: SetValueGuard::new(&axis.limits, none.0, none.1, Seconds(t), &start).unwrap(),
            watch: Watch::at_rest(axis.origin, &axis.limits, t),
            settled: Settled::default(),
            last: start,
        }
    }

    fn interrupt(&mut self, trouble: Trouble, random: &mut Random) {
        match random.below(5) {
            // Differences over a gap still contain a part of the old limits.
            0 if trouble != Trouble::Skipped => {
                let limits = scaled(&self.axis.limits, random.decades(0.2, 2.0));
                self.guard.set_limits(&limits);
                self.watch.set_limits(&limits);
                self.settled = Settled::default();
            }
            0 | 1 => {
                let size = self.axis.limits.velocity() * self.axis.ramp();
                let mut wall = || self.last.position + size * random.between(-0.5, 2.0);
                let (min, max) = (-wall(), wall());
                self.guard.set_software_limits(min, max);
            }
            2 => {
                let none = (f64::NEG_INFINITY, f64::INFINITY);
                self.guard.set_software_limits(none.0, none.1);
            }
            3 => self.guard.set_distance_policy(if random.percent(50) {
                DistancePolicy::VeloSync
            } else {
                DistancePolicy::PosSync1
            }),
            _ => {
                let limits = &self.axis.limits;
                let here = Kinematics {
                    position: self.last.position * random.between(-1.0, 1.0),
                    velocity: limits.velocity() * random.between(-1.5, 1.5),
                    acceleration: limits.acceleration() * random.between(-1.5, 1.5),
                };
                self.guard.start(&here);
                self.watch.start(&here);
                self.settled = Settled::default();
            }
        }
    }

    fn see(&mut self, guarded: &Guarded, elapsed: u32) -> bool {
        self.last = guarded.set;
        let used = self.watch.see(guarded.set.position, elapsed);
        self.settled.see(used, &self.watch) && guarded.distance.is_finite()
    }
}

fn limits_are_kept_whatever_happens(seeds: core::ops::Range<u64>) {
    for seed in seeds {
        let random = &mut Random::seeded(seed);
        let (mut interrupted, trouble, mut target) = by_chance(seed, random);
        let axis = interrupted.axis;
        for cycle in 0..2_000 {
            if random.percent(1) {
                interrupted.interrupt(trouble, random);
            }
            let (state, elapsed) = target.next(random);
            let guarded = interrupted.guard.update(&state, elapsed);
            let kept = interrupted.see(&guarded, elapsed);
            assert!(
                kept,
                "seed {seed}, cycle {cycle}, {trouble:?}, {axis:?}: {guarded:?}"
            );
        }
    }
}

#[test]
fn limits_are_kept_through_every_interruption() {
    limits_are_kept_whatever_happens(0..650);
}

/// Set values refused after the guard have not left: the next ones continue from those that have,
/// without any trace.
#[test]
fn a_cycle_that_is_taken_back_leaves_no_trace() {
    for seed in 0..130 {
        let random = &mut Random::seeded(seed);
        let (mut interrupted, trouble, mut target) = by_chance(seed, random);
        let axis = interrupted.axis;
        let mut spared = interrupted.guard;
        for cycle in 0..1_000 {
            if random.percent(10) {
                let before = interrupted.guard.history();
                let refused = Kinematics {
                    position: interrupted.last.position
                        + axis.limits.velocity() * random.between(-1.0, 1.0),
                    velocity: axis.limits.velocity() * random.between(-2.0, 2.0),
                    acceleration: axis.limits.acceleration() * random.between(-2.0, 2.0),
                };
                let _ = interrupted.guard.update(&refused, 1);
                interrupted.guard.go_back(before);
            }
            let (state, elapsed) = target.next(random);
            let guarded = interrupted.guard.update(&state, elapsed);
            assert_eq!(
                guarded,
                spared.update(&state, elapsed),
                "seed {seed}, cycle {cycle}"
            );
            assert!(
                interrupted.see(&guarded, elapsed),
                "seed {seed}, cycle {cycle}, {trouble:?}, {axis:?}: {guarded:?}"
            );
        }
    }
}

#[test]
#[ignore = "many seconds"]
fn ten_thousand_interrupted_streams_keep_the_limits() {
    limits_are_kept_whatever_happens(0..10_010);
}
