//! A sum of terms over time, for a drift or a delay.

mod curve;
mod table;

use super::random::{Random, seed_of};
use crate::config::{ClockConfig, LinkConfig, Term, Wrong};
use curve::Curve;

/// Terms, ready to be summed. Their noise is drawn from a stream of its own.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    curves: Vec<Curve>,
    noises: Vec<Noise>,
    random: Random,
}

/// Noise drawn at each evaluation.
#[derive(Clone, Copy, Debug)]
enum Noise {
    Uniform { from: f64, to: f64 },
    Exponential(f64),
    Normal(f64),
}

/// Checks the files that the terms of a clock name, as at its start.
///
/// # Errors
/// [`Wrong`] names the term whose file cannot be used.
pub fn check_clock(config: &ClockConfig) -> Result<(), Wrong> {
    Terms::of_clock(config, 0).map(|_| ())
}

/// Checks the files that the terms of a link name, as at its start.
///
/// # Errors
/// [`Wrong`] names the term whose file cannot be used.
pub fn check_link(config: &LinkConfig) -> Result<(), Wrong> {
    Terms::of_link(config, 0).map(|_| ())
}

impl Terms {
    /// The terms of a clock's drift, ppm. Reads their files; `seed` is the clock's.
    pub(super) fn of_clock(config: &ClockConfig, seed: u64) -> Result<Self, Wrong> {
        Self::open(&config.drift_terms_ppm, "drift-terms-ppm", seed)
    }

    /// The terms of a link's delay, µs. Reads their files; `seed` is the link's.
    pub(super) fn of_link(config: &LinkConfig, seed: u64) -> Result<Self, Wrong> {
        Self::open(&config.delay_terms_us, "delay-terms-us", seed)
    }

    fn open<V>(terms: &[Term<V>], list: &str, seed: u64) -> Result<Self, Wrong>
    where
        V: Copy + Into<f64> + TryFrom<f64, Error = Wrong>,
    {
        let mut opened = Self {
            curves: Vec::new(),
            noises: Vec::new(),
            // A stream of its own: terms do not shift the numbers of jitter and losses.
            random: Random::new(seed_of(seed, "terms")),
        };
        for (number, term) in terms.iter().enumerate() {
            match term {
                Term::Uniform { from, to } => opened.noises.push(Noise::Uniform {
                    from: (*from).into(),
                    to: (*to).into(),
                }),
                Term::Exponential(mean) => opened.noises.push(Noise::Exponential((*mean).into())),
                Term::Normal(sigma) => opened.noises.push(Noise::Normal((*sigma).into())),
                term => opened.curves.push(Curve::open(term).map_err(|reason| {
                    Wrong::with_reason(format!("{list}[{number}].file.path"), reason)
                })?),
            }
        }
        Ok(opened)
    }

    /// True if the sum is constant.
    pub(super) fn is_constant(&self) -> bool {
        let constant = |curve: &Curve| matches!(curve, Curve::Constant(_));
        self.noises.is_empty() && self.curves.iter().all(constant)
    }

    /// The sum at `at` s.
    pub(super) fn at(&mut self, at: f64) -> f64 {
        let curves: f64 = self.curves.iter().map(|curve| curve.at(at)).sum();
        curves + self.noise()
    }

    /// The mean of the sum over a time, with one value of its noise.
    pub(super) fn mean(&mut self, from: f64, to: f64) -> f64 {
        let curves = self.curves.iter();
        let curves: f64 = curves.map(|curve| curve.mean(from, to)).sum();
        curves + self.noise()
    }

    fn noise(&mut self) -> f64 {
        let Self { noises, random, .. } = self;
        noises.iter().map(|noise| noise.draw(random)).sum()
    }
}

impl Noise {
    fn draw(self, random: &mut Random) -> f64 {
        match self {
            Self::Uniform { from, to } => from + (to - from) * random.uniform(),
            Self::Exponential(mean) => mean * random.exponential(),
            Self::Normal(sigma) => sigma * random.normal(),
        }
    }
}

#[cfg(test)]
mod tests;
