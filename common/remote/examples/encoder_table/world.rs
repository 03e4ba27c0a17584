//! Ten profiles of speed, and a counter that sees them.

use coaxle_curve::profile::Kinematics;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::motion::{Motion, RIPPLE_GROWS};

/// The sampling time, s.
pub const CYCLE: f64 = 1e-3;
/// Set values are wanted for so long after a sample, s.
pub const HORIZON: f64 = 2e-3;
/// The instants of the samples scatter by this, s.
const TIMING: f64 = 2e-7;
/// So many of the samples are lost.
const LOSS: f64 = 0.01;
/// What it trembles at rest, in increments.
const VIBRATION: f64 = 0.1;
/// It rests before it moves, s.
pub const START: f64 = 0.5;

/// The increments of the table, mm.
pub const INCREMENTS: [f64; 4] = [0.001, 0.01, 0.05, 0.1];
/// Its speeds, mm/s.
pub const SPEEDS: [f64; 4] = [5.0, 50.0, 500.0, 2_000.0];
/// Each run takes one that is off by up to this part.
const SPREAD: f64 = 0.04;

/// What an axis does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Profile {
    /// A constant speed.
    Constant,
    /// A ripple of 0.5 to 13 Hz, 1 to 0.13 % of the speed.
    Ripple,
    /// The same with 13 to 20 Hz and down to 0.1 %.
    FastRipple,
    /// Up and down with 2000 mm/s² and a jerk of 1e4 mm/s³.
    SoftRamp,
    /// The same with 1e5 mm/s³.
    HardRamp,
    /// Up, a stop and up again, with 2000 mm/s² and 1e5 mm/s³.
    StopAndGo,
    /// A thousandth of the speed, at least 0.1 mm/s.
    Creep,
    /// Standing at the border of an increment, with vibration.
    Flicker,
    /// Backward from rest, after vibration at rest.
    Backward,
    /// A constant speed of which bursts of 5 to 60 samples are lost.
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

/// One run of one profile.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub profile: Profile,
    pub increment: f64,
    pub speed: f64,
    /// How far the speed of a run may be off, as a part.
    pub spread: f64,
    /// Standard deviation of what it trembles, in increments.
    pub vibration: f64,
    pub seed: u64,
}

/// What happens in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub count: Option<i64>,
    /// The axis at the instant of the sample.
    pub sampled: Kinematics,
    /// The axis when the set values are wanted.
    pub wanted: Kinematics,
    /// Since the start, s.
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
    /// From here on it runs steadily, s.
    pub settled: f64,
    /// Since when it stands, to the end, s.
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
    /// The case as the table has it.
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

    /// The motion, and when it has settled.
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

/// 1 % of the speed at 0.5 Hz, and less the faster it swings: 0.1 % at 20 Hz.
fn swinging(motion: Motion, speed: f64, frequency: f64) -> (Motion, f64) {
    let share = 1e-2 * (frequency / 0.5).powf(0.1_f64.ln() / 40.0_f64.ln());
    let settled = motion.end() + RIPPLE_GROWS + 0.3;
    (motion.swing(share * speed, frequency).hold(4.0), settled)
}

impl Iterator for Run {
    type Item = Scene;

    fn next(&mut self) -> Option<Scene> {
        let time = f64::from(self.cycle) * CYCLE;
        if time > self.motion.end() - HORIZON {
            return None;
        }
        self.cycle += 1;
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
        if self.bursts && self.burst_left == 0 && self.random.between(0.0, 1.0) < 0.003 {
            self.burst_left = self.random.between(5.0, 61.0) as u32;
        }
        let in_burst = self.burst_left > 0;
        self.burst_left = self.burst_left.saturating_sub(1);
        in_burst || self.random.between(0.0, 1.0) < LOSS
    }
}
