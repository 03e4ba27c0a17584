//! Ten profiles of speed, and a counter that reads them.

use coaxle_curve::profile::Kinematics;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::motion::{Motion, RIPPLE_GROWS};

/// The sampling time, s.
pub const CYCLE: f64 = 1e-3;
/// Time from a sample to its set values, s.
pub const HORIZON: f64 = 2e-3;
/// Standard deviation of the instants of the samples, s.
const TIMING: f64 = 2e-7;
/// Part of the samples that is lost.
const LOSS: f64 = 0.01;
/// Vibration at rest, in increments.
const VIBRATION: f64 = 0.1;
/// Rest before the motion, s.
pub const START: f64 = 0.5;

/// The increments of the table, mm.
pub const INCREMENTS: [f64; 4] = [0.001, 0.01, 0.05, 0.1];
/// The speeds of the table, mm/s.
pub const SPEEDS: [f64; 4] = [5.0, 50.0, 500.0, 2_000.0];
/// Part by which each run's speed is off at most.
const SPREAD: f64 = 0.04;

/// Motion of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Profile {
    /// A constant speed.
    Constant,
    /// A ripple of 0.5 to 13 Hz, 1 to 0.13 % of the speed.
    Ripple,
    /// A ripple of 13 to 20 Hz, down to 0.1 % of the speed.
    FastRipple,
    /// Up and down with 2000 mm/s² and a jerk of 1e4 mm/s³.
    SoftRamp,
    /// Up and down with 2000 mm/s² and a jerk of 1e5 mm/s³.
    HardRamp,
    /// Up, a stop and up again, with 2000 mm/s² and 1e5 mm/s³.
    StopAndGo,
    /// A thousandth of the speed, at least 0.1 mm/s.
    Creep,
    /// Standing at the border of an increment, with vibration.
    Flicker,
    /// Backward from rest, after vibration at rest.
    Backward,
    /// A constant speed with bursts of 5 to 60 lost samples.
    BurstLoss,
}

pub const PROFILES: [Profile; 10] = [
    Profile::Constant,
    Profile::Ripple,
    Profile::FastRipple,
    Profile::SoftRamp,
    Profile::HardRamp,
    Profile::StopAndGo,
    Profile::Creep,
    Profile::Flicker,
    Profile::Backward,
    Profile::BurstLoss,
];

/// A run of one profile.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub profile: Profile,
    pub increment: f64,
    pub speed: f64,
    /// Part by which the speed of a run may be off.
    pub spread: f64,
    /// Standard deviation of the vibration, in increments.
    pub vibration: f64,
    pub seed: u64,
}

/// Events of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub count: Option<i64>,
    /// The axis at the instant of the sample.
    pub sampled: Kinematics,
    /// The axis when the set values are wanted.
    pub wanted: Kinematics,
    /// Time since the start, s.
    pub time: f64,
}

/// A run, cycle by cycle.
pub struct Run {
    motion: Motion,
    increment: f64,
    vibration: f64,
    bursts: bool,
    burst_left: u32,
    cycle: u32,
    random: Random,
    /// Instant from which it runs steadily, s.
    pub settled: f64,
    /// Instant from which it stands, to the end, s.
    pub stopped: Option<f64>,
}

/// Seeded deviates.
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let share: f64 = StandardUniform.sample(&mut self.0);
        low + (high - low) * share
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

impl Case {
    /// Creates the case of the table.
    pub fn new(profile: Profile, increment: f64, speed: f64, seed: u64) -> Self {
        let trembles = matches!(profile, Profile::Flicker | Profile::Backward);
        Self {
            profile,
            increment,
            speed,
            spread: SPREAD,
            vibration: if trembles { VIBRATION } else { 0.0 },
            seed,
        }
    }

    pub fn run(&self) -> Run {
        let mut random = Random(Xoshiro256PlusPlus::seed_from_u64(self.seed));
        let start = random.between(-50.0, 50.0) * self.increment;
        let speed = self.speed * random.between(1.0 - self.spread, 1.0 + self.spread);
        let q = self.increment;
        // Vibration flickers between two counts only if the axis stands on the border between them.
        let at_border = (start / q).round() * q;
        let start = if self.profile == Profile::Flicker {
            at_border
        } else {
            start
        };
        let rest = Motion::at_rest(start).hold(START);
        let (motion, settled) = self.motion(rest, speed, &mut random);
        let stops = matches!(self.profile, Profile::StopAndGo | Profile::Flicker);
        let stopped = stops.then_some(if self.profile == Profile::Flicker {
            0.0
        } else {
            motion.end()
        });
        // Errors at rest are judged from 0.3 s after the stop on, which leaves half a second.
        let motion = if stops { motion.hold(0.8) } else { motion };
        Run {
            motion,
            increment: q,
            vibration: self.vibration * q,
            bursts: self.profile == Profile::BurstLoss,
            burst_left: 0,
            cycle: 0,
            random,
            settled,
            stopped,
        }
    }

    /// The motion, and the instant at which it has settled.
    fn motion(&self, rest: Motion, speed: f64, random: &mut Random) -> (Motion, f64) {
        const SOFT: f64 = 1e4;
        const HARD: f64 = 1e5;
        const STEEP: f64 = 2_000.0;
        let soft = |motion: Motion, speed: f64| motion.to(speed, STEEP, SOFT);
        let hard = |motion: Motion, speed: f64| motion.to(speed, STEEP, HARD);
        match self.profile {
            Profile::Constant | Profile::BurstLoss => {
                let up = soft(rest, speed);
                let settled = up.end() + 0.3;
                (up.hold(3.0), settled)
            }
            Profile::Ripple => swinging(soft(rest, speed), speed, random.between(0.5, 13.0)),
            Profile::FastRipple => swinging(soft(rest, speed), speed, random.between(13.0, 20.0)),
            Profile::SoftRamp => {
                let low = speed * random.between(0.2, 0.6);
                let up = soft(soft(rest, speed).hold(0.4), low).hold(0.4);
                (soft(up, speed).hold(0.4), START)
            }
            Profile::HardRamp => {
                let low = speed * random.between(0.2, 0.6);
                let up = hard(hard(rest, speed).hold(0.4), low).hold(0.4);
                (hard(up, speed).hold(0.4), START)
            }
            Profile::StopAndGo => {
                let there = hard(hard(rest, speed).hold(0.3), 0.0).hold(0.5);
                (hard(hard(there, speed).hold(0.3), 0.0), START)
            }
            Profile::Creep => {
                let slow = (1e-3 * speed).max(0.1);
                (soft(rest, slow).hold(4.0), START)
            }
            Profile::Flicker => (rest.hold(2.0), START),
            Profile::Backward => (hard(rest, -speed).hold(1.0), START),
        }
    }
}

/// 1 % of the speed at 0.5 Hz, and less at higher frequencies: 0.1 % at 20 Hz.
fn swinging(motion: Motion, speed: f64, frequency: f64) -> (Motion, f64) {
    // A power law through both points: 40 times the frequency has a tenth of the share.
    let share = 1e-2 * (frequency / 0.5).powf(0.1_f64.ln() / 40.0_f64.ln());
    let settled = motion.end() + RIPPLE_GROWS + 0.3;
    (motion.swing(share * speed, frequency).hold(4.0), settled)
}

impl Iterator for Run {
    type Item = Scene;

    fn next(&mut self) -> Option<Scene> {
        let time = f64::from(self.cycle) * CYCLE;
        // The set values belong to an instant later by the horizon, at which the true motion must still be known.
        if time > self.motion.end() - HORIZON {
            return None;
        }
        self.cycle += 1;
        // A reading is taken at a jittering instant, but reported with its nominal one.
        let sampled = self.motion.at(time + TIMING * self.random.normal());
        let seen = sampled.position + self.vibration * self.random.normal();
        let count = (seen / self.increment).floor() as i64;
        Some(Scene {
            count: (!self.is_lost()).then_some(count),
            sampled,
            wanted: self.motion.at(time + HORIZON),
            time,
        })
    }
}

impl Run {
    fn is_lost(&mut self) -> bool {
        // At 0.003 a burst begins every third of a second on average, about ten in a run.
        if self.bursts && self.burst_left == 0 && self.random.between(0.0, 1.0) < 0.003 {
            self.burst_left = self.random.between(5.0, 61.0) as u32;
        }
        let in_burst = self.burst_left > 0;
        self.burst_left = self.burst_left.saturating_sub(1);
        in_burst || self.random.between(0.0, 1.0) < LOSS
    }
}
