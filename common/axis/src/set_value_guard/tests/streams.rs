//! Limits of the guard's output, for any target.

use std::format;

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use super::super::{DistancePolicy, GuardState, SetValueGuard};
use super::motion::{Axis, Motion, scaled};
use super::random::Random;
use super::trouble::{TROUBLES, Troubled};
use super::watch::Watch;

const CYCLES: u32 = 3_000;

/// A random axis, with its guard and its target.
struct Stream {
    axis: Axis,
    min: f64,
    max: f64,
    guard: SetValueGuard,
    watch: Watch,
    stated: Kinematics,
    /// Number of cycles skipped before the last one, and before the one before.
    skipped: [u32; 2],
    target: Troubled,
    random: Random,
    name: std::string::String,
}

impl Stream {
    fn by_chance(seed: u64, walls: bool) -> Self {
        let mut random = Random::seeded(seed);
        let mut axis = Axis::by_chance(&mut random);
        if walls {
            // Farther out rounding hides more of the distance to them.
            axis.origin = axis.origin.min(1e4);
        }
        let trouble = TROUBLES[(seed % TROUBLES.len() as u64) as usize];
        let start = Kinematics::at_rest(axis.origin);
        let (min, max) = if walls {
            let room = axis.ramp() * axis.limits.velocity();
            (
                axis.origin - room * random.decades(1e-2, 10.0),
                axis.origin + room * random.decades(1e-2, 10.0),
            )
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        let cycle_time = Seconds(axis.cycle_time);
        let mut guard = SetValueGuard::new(&axis.limits, min, max, cycle_time, &start).unwrap();
        if random.percent(20) {
            guard.set_distance_policy(DistancePolicy::VeloSync);
        }
        let motion = Motion::starting_at(start, scaled(&axis.limits, 1.0 / 1.2));
        Self {
            axis,
            min,
            max,
            guard,
            watch: Watch::at_rest(axis.origin, &axis.limits, axis.cycle_time),
            stated: start,
            skipped: [0; 2],
            target: Troubled::new(trouble, &axis, motion, &mut random),
            random,
            name: format!("seed {seed}, {trouble:?}, {axis:?}"),
        }
    }

    fn cycle(&mut self) -> GuardState {
        let (target, elapsed) = self.target.next(&mut self.random);
        let guarded = self.guard.update(&target, elapsed);
        let used = self.watch.see(guarded.set.position, elapsed);
        assert!(used.most() <= 1.0, "{}: {used:?} {guarded:?}", self.name);
        self.assert_stated(&guarded.set, elapsed);
        self.assert_before_walls(guarded.set.position);
        guarded.state
    }

    /// Asserts that stated values match the positions, and keep the limits themselves: values after
    /// skipped cycles may use all that the limits admit within those.
    fn assert_stated(&mut self, set: &Kinematics, elapsed: u32) {
        let (limits, t) = (&self.axis.limits, self.axis.cycle_time);
        let digits = 4.0 * f64::EPSILON * set.position.abs().max(limits.velocity());
        let [last, one_before] = self.skipped;
        self.skipped = [elapsed - 1, last];
        let changed = [elapsed + last, elapsed + last + one_before];
        let times = changed.map(|cycles| t * f64::from(cycles) * (1.0 + 1e-9));
        let most = limits.acceleration().max(limits.deceleration());
        let before = core::mem::replace(&mut self.stated, *set);
        let change = (set.velocity - before.velocity).abs();
        assert!(
            change <= most * times[0] + 2.0 * digits / t,
            "{}: {before:?} {set:?}",
            self.name
        );
        let change = (set.acceleration - before.acceleration).abs();
        let rounding = 4.0 * digits / (t * t);
        assert!(
            change <= limits.jerk() * times[1] + rounding,
            "{}: {before:?} {set:?}",
            self.name
        );
        if let Some(seen) = self.watch.state_now() {
            // The possible deviation of a motion from its differences, and the part cut off, also
            // after skipped cycles; and three percent for the pace of the clock in which it was
            // stated.
            let jerk = limits.jerk().min(2.0 * most / t) * (1.0 + 1e-6);
            let off = (set.velocity - seen.velocity).abs();
            assert!(
                off <= 3.0 * jerk * t * t + 0.03 * seen.velocity.abs() + 8.0 * digits / t,
                "{}: {off} {seen:?} {set:?}",
                self.name
            );
            let off = (set.acceleration - seen.acceleration).abs();
            assert!(
                off <= 3.0 * jerk * t + 0.06 * seen.acceleration.abs() + 16.0 * digits / (t * t),
                "{}: {off} {seen:?} {set:?}",
                self.name
            );
        }
    }

    fn assert_before_walls(&self, position: f64) {
        // 128ε·max(|p|, vmax·1 s) is the promise for software limits.
        let rounding = 128.0 * f64::EPSILON * position.abs().max(self.axis.limits.velocity());
        let beyond = (position - self.max).max(self.min - position);
        assert!(beyond <= rounding, "{}: {beyond}", self.name);
    }

    /// Asserts that the axis follows the target within a limited time after it keeps the limits again.
    fn assert_rejoins(&mut self) {
        self.target.calm_down(&mut self.random);
        let _ = self.cycle();
        let set = self.watch.position();
        let distance = (self.target.next(&mut self.random).0.position - set).abs();
        let velocity = self.axis.limits.velocity();
        let time = distance / (0.5 * velocity) + 5.0 * self.axis.ramp();
        let cycles = 100 + (time / self.axis.cycle_time) as u32;
        let mut landed = 0;
        for _ in 0..cycles {
            let tracking = self.cycle() == GuardState::Tracking;
            landed = if tracking { landed + 1 } else { 0 };
            // Once three targets in a row have passed, it has landed.
            if landed == 3 {
                let stays = (0..100).all(|_| self.cycle() == GuardState::Tracking);
                assert!(stays, "{}: leaves it again", self.name);
                return;
            }
        }
        panic!("{}: not within {cycles} cycles", self.name);
    }
}

fn streams_keep_the_limits(seeds: core::ops::Range<u64>) {
    for seed in seeds {
        let mut stream = Stream::by_chance(seed, false);
        for _ in 0..CYCLES {
            let _ = stream.cycle();
        }
        stream.assert_rejoins();
    }
}

fn streams_keep_the_walls(seeds: core::ops::Range<u64>) {
    for seed in seeds {
        let mut stream = Stream::by_chance(seed, true);
        for _ in 0..CYCLES {
            let _ = stream.cycle();
        }
    }
}

#[test]
fn every_stream_keeps_the_limits_and_rejoins() {
    streams_keep_the_limits(0..1_300);
}

#[test]
fn every_stream_keeps_the_software_limits_too() {
    streams_keep_the_walls(0..650);
}

#[test]
#[ignore = "minutes"]
fn ten_thousand_streams_keep_the_limits_and_rejoin() {
    streams_keep_the_limits(0..10_010);
}

#[test]
#[ignore = "minutes"]
fn ten_thousand_streams_keep_the_software_limits_too() {
    streams_keep_the_walls(0..10_010);
}
