//! Seeded random numbers, the same on every machine.

use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::config::JitterConfig;
use coaxle_wire::Channel;

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    /// The stream of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Gaussian, mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Exponential, mean 1.
    pub fn exponential(&mut self) -> f64 {
        Exp1.sample(&mut self.0)
    }

    /// Uniform in 0 (included) to 1 (excluded).
    pub fn uniform(&mut self) -> f64 {
        // 53 bits: all that a float has between 0 and 1.
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// True with this probability.
    pub fn chance(&mut self, share: f64) -> bool {
        // No number is drawn for a share of 0: switching a fault on or off shifts the later numbers of this stream, another
        // share above 0 does not. Drawing always would change the runs of all seeds.
        share > 0.0 && self.uniform() < share
    }

    /// A deviate of a configured jitter, µs.
    pub fn jitter_us(&mut self, jitter: &JitterConfig) -> f64 {
        match jitter {
            JitterConfig::NormalUs(sigma) => sigma.get() * self.normal(),
            JitterConfig::ExponentialUs(mean) => mean.get() * self.exponential(),
            JitterConfig::UniformUs(most) => most.get() * self.uniform(),
        }
    }
}

/// Derives a seed for each part of a run, so that adding a part changes no other's numbers.
#[must_use]
pub fn seed_of(run: u64, part: &str) -> u64 {
    // By name: a part that is added or moved leaves the seeds of the others.
    let name = u64::from(crc32fast::hash(part.as_bytes()));
    // SplitMix64's finaliser spreads the two over all bits.
    let mut mixed = run
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .wrapping_add(name.wrapping_mul(0xD1B5_4A32_D192_ED03));
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

/// Derives the seed of a link's faults on one channel: each has numbers of its own.
#[must_use]
pub fn link_seed(run: u64, part: &str, channel: Channel) -> u64 {
    let seed = seed_of(run, part);
    // A node publishes either its axes or its slaves.
    if channel.carries_axes() {
        seed
    } else {
        seed_of(seed, channel.name())
    }
}

#[cfg(test)]
mod tests;
