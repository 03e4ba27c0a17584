//! Draws of a schedule.

use coaxle_node::faults::Random;

/// Random draws.
pub(super) trait Draw {
    fn between(&mut self, low: f64, high: f64) -> f64;
    fn below(&mut self, count: u64) -> u64;
    fn whole(&mut self, low: u64, high: u64) -> u64;
    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T;
    /// Draws from each decade equally often.
    fn decades(&mut self, low: f64, high: f64) -> f64;
}

impl Draw for Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    fn below(&mut self, count: u64) -> u64 {
        // Below the count, as `uniform` is below 1. The bias of some 2⁻⁵³ does not matter here.
        (self.uniform() * count as f64) as u64
    }

    fn whole(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }

    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        let chosen = self.below(all.len() as u64);
        &all[chosen as usize]
    }

    fn decades(&mut self, low: f64, high: f64) -> f64 {
        // Even in the logarithm: an even draw from 1 to 1e8 would be above 1e7 nine times in ten.
        low * (high / low).powf(self.uniform())
    }
}
