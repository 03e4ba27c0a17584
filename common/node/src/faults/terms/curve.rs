//! A term that is a function of time, and its integral.

use core::f64::consts::TAU;

use super::table::Table;
use crate::config::{ConfigError, Term, Wrong};

/// A function of time.
#[derive(Clone, Debug)]
pub(super) enum Curve {
    Constant(f64),
    Sine(f64, Turns),
    Triangle(f64, Turns),
    Pulse {
        height: f64,
        duty: f64,
        turns: Turns,
    },
    Step {
        at: f64,
        by: f64,
        over: f64,
    },
    Table(Table),
}

/// Time in periods of a periodic function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turns {
    period: f64,
    phase: f64,
}

impl Turns {
    /// Whole periods and the share of the current one.
    fn at(self, at: f64) -> (f64, f64) {
        // Turns and not an angle: the fraction is taken before the sine, which keeps its digits after years.
        let turns = at / self.period + self.phase;
        // `floor`, so that the share is positive before zero as well.
        let whole = turns.floor();
        (whole, turns - whole)
    }
}

impl Curve {
    /// Creates the curve of a term; noise is represented by a constant zero.
    pub(super) fn open<V>(term: &Term<V>) -> Result<Self, ConfigError>
    where
        V: Copy + Into<f64> + TryFrom<f64, Error = Wrong>,
    {
        Ok(match term {
            Term::Constant(value) => Self::Constant((*value).into()),
            Term::Sine(wave) => Self::Sine(
                wave.amplitude.into(),
                Turns {
                    period: wave.period_s.get(),
                    phase: wave.phase.get(),
                },
            ),
            Term::Triangle(wave) => Self::Triangle(
                wave.amplitude.into(),
                Turns {
                    period: wave.period_s.get(),
                    phase: wave.phase.get(),
                },
            ),
            Term::Pulse {
                height,
                period_s,
                duty,
                phase,
            } => Self::Pulse {
                height: (*height).into(),
                duty: duty.get(),
                turns: Turns {
                    period: period_s.get(),
                    phase: phase.get(),
                },
            },
            Term::Step { at_s, by, over_s } => Self::Step {
                at: at_s.get(),
                by: (*by).into(),
                over: over_s.get(),
            },
            Term::File { path, between } => Self::Table(Table::read::<V>(path, *between)?),
            // Noise is no function of time: `open` keeps it apart.
            Term::Uniform { .. } | Term::Exponential(_) | Term::Normal(_) => Self::Constant(0.0),
        })
    }

    /// Value at `at` s.
    pub(super) fn at(&self, at: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Sine(amplitude, turns) => amplitude * libm::sin(TAU * turns.at(at).1),
            Self::Triangle(amplitude, turns) => {
                let share = turns.at(at).1;
                let unit = match share {
                    up if up < 0.25 => 4.0 * up,
                    down if down < 0.75 => 2.0 - 4.0 * down,
                    up => 4.0 * up - 4.0,
                };
                amplitude * unit
            }
            Self::Pulse {
                height,
                duty,
                turns,
            } => {
                let is_high = turns.at(at).1 < *duty;
                // Excluded at its end: with a duty of 0 the pulse is never high.
                if is_high { *height } else { 0.0 }
            }
            Self::Step {
                at: begin,
                by,
                over,
            } => {
                let passed = at - begin;
                match passed {
                    before if before < 0.0 => 0.0,
                    // Also where `over` is 0: a step at once.
                    under_way if under_way < *over => by * under_way / over,
                    _ => *by,
                }
            }
            Self::Table(table) => table.at(at),
        }
    }

    /// Mean over a time.
    pub(super) fn mean(&self, from: f64, to: f64) -> f64 {
        if let Self::Constant(value) = self {
            return *value;
        }
        if to <= from {
            return self.at(from);
        }
        // The mean from the integral: exact, however many edges lie between.
        (self.integral(to) - self.integral(from)) / (to - from)
    }

    /// Integral up to `at` s, except for a constant of integration.
    fn integral(&self, at: f64) -> f64 {
        match self {
            Self::Constant(value) => value * at,
            Self::Sine(amplitude, turns) => {
                let share = turns.at(at).1;
                // ∫ sin(2πt/T) dt = −T/2π · cos(2πt/T).
                -amplitude * turns.period / TAU * libm::cos(TAU * share)
            }
            Self::Triangle(amplitude, turns) => {
                let share = turns.at(at).1;
                let unit = match share {
                    up if up < 0.25 => 2.0 * up * up,
                    // Each part continues the one before: 0.125 at a quarter and at three quarters.
                    down if down < 0.75 => 2.0 * down * (1.0 - down) - 0.25,
                    up => 2.0 * (1.0 - up) * (1.0 - up),
                };
                amplitude * turns.period * unit
            }
            Self::Pulse {
                height,
                duty,
                turns,
            } => {
                let (whole, share) = turns.at(at);
                // Whole pulses, and the part of the present one.
                height * turns.period * (whole * duty + share.min(*duty))
            }
            Self::Step {
                at: begin,
                by,
                over,
            } => {
                let passed = (at - begin).max(0.0);
                if passed < *over {
                    // A parabola during the ramp, a line behind it: half of the ramp's time is lost.
                    0.5 * by * passed * passed / over
                } else {
                    by * (passed - 0.5 * over)
                }
            }
            Self::Table(table) => table.integral(at),
        }
    }
}
