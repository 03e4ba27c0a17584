//! Targets that violate the limits.

use coaxle_curve::profile::Kinematics;

use super::motion::{Axis, Motion};
use super::random::Random;

/// Trouble of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Trouble {
    /// Sudden stop and return to its course.
    Stop,
    /// Return on its own path.
    Reverse,
    /// Extrapolation for a while.
    Outage,
    /// Change to another motion.
    HandOver,
    /// Single wrong positions,
    Spikes,
    /// far off.
    FarSpikes,
    /// Lasting jump.
    Step,
    /// Positions of a coarse encoder.
    Quantised,
    Noise,
    /// Back and forth at the highest velocity.
    Hammer,
    NotANumber,
    /// False stated velocity and acceleration, while its positions jump.
    Liar,
    /// Skipped cycles, with other trouble.
    Skipped,
}

pub(super) const TROUBLES: [Trouble; 13] = [
    Trouble::Stop,
    Trouble::Reverse,
    Trouble::Outage,
    Trouble::HandOver,
    Trouble::Spikes,
    Trouble::FarSpikes,
    Trouble::Step,
    Trouble::Quantised,
    Trouble::Noise,
    Trouble::Hammer,
    Trouble::NotANumber,
    Trouble::Liar,
    Trouble::Skipped,
];

/// A motion within limits, until its trouble begins.
pub(super) struct Troubled {
    trouble: Trouble,
    motion: Motion,
    axis: Axis,
    cycle: u32,
    begin: u32,
    end: u32,
    /// Size of the jumps, u.
    size: f64,
    shift: f64,
    frozen: Kinematics,
}

impl Troubled {
    pub(super) fn new(trouble: Trouble, axis: &Axis, motion: Motion, random: &mut Random) -> Self {
        let begin = 300 + random.below(1_000);
        Self {
            trouble,
            axis: *axis,
            cycle: 0,
            begin,
            end: begin + 1 + random.below(300),
            size: axis.limits.velocity() * axis.cycle_time * random.decades(1e-2, 1e3),
            shift: 0.0,
            frozen: motion.here,
            motion,
        }
    }

    /// The next target, and the number of cycles since the last.
    pub(super) fn next(&mut self, random: &mut Random) -> (Kinematics, u32) {
        let skips = self.trouble == Trouble::Skipped && random.percent(10);
        let elapsed = if skips { 2 + random.below(9) } else { 1 };
        let mut target = self.motion.here;
        for _ in 0..elapsed {
            self.cycle += 1;
            target = self.motion.next(random, self.axis.cycle_time);
            if self.cycle == self.begin {
                self.frozen = target;
                target = self.begins(target, random);
            }
        }
        if (self.begin..self.end).contains(&self.cycle) {
            target = self.during(target, random);
        }
        target.position += self.shift;
        (target, elapsed)
    }

    /// Ends the trouble, and continues at half its velocity or less.
    pub(super) fn calm_down(&mut self, random: &mut Random) {
        self.trouble = Trouble::Stop;
        self.end = self.begin;
        self.motion.cruise(random.between(-0.5, 0.5));
    }

    fn begins(&mut self, target: Kinematics, random: &mut Random) -> Kinematics {
        match self.trouble {
            Trouble::Step => self.shift = self.size,
            Trouble::HandOver | Trouble::Skipped => {
                self.motion.jump(self.size, random.between(-1.0, 1.0));
                return self.motion.here;
            }
            _ => {}
        }
        target
    }

    fn during(&mut self, target: Kinematics, random: &mut Random) -> Kinematics {
        let since = f64::from(self.cycle - self.begin) * self.axis.cycle_time;
        let Self { frozen, size, .. } = *self;
        let shifted = |by: f64| Kinematics {
            position: target.position + by,
            ..target
        };
        let going = |velocity: f64| Kinematics {
            position: frozen.position + velocity * since,
            velocity,
            acceleration: 0.0,
        };
        let by_chance = random.between(-1.0, 1.0);
        match self.trouble {
            Trouble::Stop => Kinematics::at_rest(frozen.position),
            Trouble::Reverse => going(-frozen.velocity),
            Trouble::Outage => going(frozen.velocity),
            Trouble::Spikes if random.percent(5) => shifted(size * by_chance),
            // The largest position that a frame may carry.
            Trouble::FarSpikes if random.percent(5) => shifted(1e15 * by_chance),
            Trouble::Quantised => Kinematics {
                position: libm::round(target.position / size * 100.0) * size / 100.0,
                ..target
            },
            Trouble::Noise => shifted(1e-2 * size * by_chance),
            Trouble::Hammer => {
                let sign = if (self.cycle / 20).is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                };
                going(sign * self.axis.limits.velocity())
            }
            Trouble::NotANumber => {
                let nothing = [f64::NAN, f64::INFINITY][random.below(2) as usize];
                shifted(nothing)
            }
            Trouble::Liar => Kinematics {
                position: target.position + size * by_chance,
                velocity: 100.0 * by_chance * self.axis.limits.velocity(),
                acceleration: by_chance * self.axis.limits.acceleration(),
            },
            _ => target,
        }
    }
}
