//! Correlation of the delay, which makes many messages worth fewer independent ones.
//!
//! On a busy machine the delays of consecutive messages are correlated: queues build up and drain, cores fall asleep
//! and are woken. The mean of a thousand messages is then hardly surer than that of fifty, and a filter that believes
//! otherwise follows the delay instead of the clock. Quartzes, on the other hand, run straight for seconds. So three
//! means of consecutive messages should lie on a line, and the miss of the middle one shows what a mean is worth: a
//! second difference, as in the Allan variance (D. W. Allan, Proc. IEEE 54, 1966).

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the worth of means.
    CorrelatedDelayTuning {
        /// Misses that the mean square is over.
        memory: f64 = 16.0,
        /// Before there are any the messages are taken to be independent, with the weight of this number of misses.
        prior: f64 = 4.0,
        /// A single miss counts at most as this many times the usual one, plus `outlier_by`.
        // A step of the drift or of the delay is no correlation.
        outlier: f64 = 4.0,
        /// See `outlier`.
        outlier_by: f64 = 8.0,
        /// Multiple that independent messages reach by chance.
        // 300 seeds of a unit test stay below.
        chance: f64 = 6.0,
        /// Calm is believed with this time constant, s.
        forgotten_after: f64 = 30.0,
        /// Greatest factor on the length of runs.
        // 200 messages that are too late in a row.
        greatest_patience: f64 = 4.0,
    }
}

/// Watches the measurements of the line for correlated delays.
#[derive(Clone, Debug)]
pub(in crate::observer) struct CorrelatedDelay {
    /// s, since the first measurement.
    now: f64,
    scales: [Scale; SCALES.len()],
    factor: f64,
}

/// Measurements per mean: 64, 256 and 1024 messages.
const SCALES: [u16; 3] = [8, 32, 128];

/// Means of one length.
#[derive(Clone, Copy, Debug, Default)]
struct Scale {
    sum: Mean,
    summed: u16,
    /// The last two means, and the number that is known.
    means: [Mean; 2],
    known: u8,
    /// Mean square of the misses, as a multiple of the one of independent messages, and the number of misses.
    miss: f64,
    misses: f64,
}

/// The mean of some measurements, or while it grows their sum: s, s, s².
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    time: f64,
    value: f64,
    variance: f64,
}

impl CorrelatedDelay {
    pub(in crate::observer) fn new() -> Self {
        let scale = Scale {
            miss: 1.0,
            misses: TUNING.prior,
            ..Scale::default()
        };
        Self {
            now: 0.0,
            scales: [scale; SCALES.len()],
            factor: 1.0,
        }
    }

    /// The variance of the mean of many messages, as a multiple of the one of independent messages: 1 and above.
    pub(in crate::observer) const fn factor(&self) -> f64 {
        self.factor
    }

    /// Factor by which runs of like messages have to be longer than among independent ones to mean something: 1 and
    /// above.
    pub(in crate::observer) fn patience(&self) -> f64 {
        (0.5 * libm::sqrt(self.factor)).clamp(1.0, TUNING.greatest_patience)
    }

    /// Takes a measurement, `dt` seconds after the one before, with its variance.
    pub(in crate::observer) fn take(&mut self, dt: f64, value: f64, variance: f64) {
        self.now += dt;
        let measurement = Mean {
            time: self.now,
            value,
            variance,
        };
        // The worst of the scales: flicker is as large on all of them, a short correlation only on the first.
        let mut largest = TUNING.chance;
        for (scale, length) in self.scales.iter_mut().zip(SCALES) {
            scale.take(&measurement, length);
            largest = largest.max(scale.miss);
        }
        // Continuous at the bound: 1 up to what chance explains, and the multiple itself far beyond.
        let seen = libm::sqrt(1.0 + largest * largest - TUNING.chance * TUNING.chance);
        let forgotten = self.factor - (self.factor - seen) * (dt / TUNING.forgotten_after).min(1.0);
        // Rises at once and falls slowly: the filters must not be sure while it is still being noticed.
        self.factor = seen.max(forgotten);
    }

    /// Restarts after a jump of the line: earlier measurements do not lie on it.
    pub(in crate::observer) fn jumped(&mut self) {
        for scale in &mut self.scales {
            scale.summed = 0;
            scale.known = 0;
        }
    }
}

impl Scale {
    fn take(&mut self, measurement: &Mean, length: u16) {
        if self.summed == 0 {
            self.sum = Mean::default();
        }
        self.sum.time += measurement.time;
        self.sum.value += measurement.value;
        self.sum.variance += measurement.variance;
        self.summed += 1;
        if self.summed < length {
            return;
        }
        self.summed = 0;
        let n = f64::from(length);
        let mean = Mean {
            time: self.sum.time / n,
            value: self.sum.value / n,
            variance: self.sum.variance / (n * n),
        };
        if self.known == 2 {
            self.note(&mean);
        }
        self.known = (self.known + 1).min(2);
        self.means = [self.means[1], mean];
    }

    fn note(&mut self, last: &Mean) {
        let [first, middle] = &self.means;
        // Messages are lost, so the middle one need not be half-way.
        let part = (middle.time - first.time) / (last.time - first.time);
        let miss = middle.value - first.value - part * (last.value - first.value);
        let variance = middle.variance
            + (1.0 - part) * (1.0 - part) * first.variance
            + part * part * last.variance;
        let sample = (miss * miss / variance).min(TUNING.outlier * self.miss + TUNING.outlier_by);
        self.misses = (self.misses + 1.0).min(TUNING.memory);
        self.miss += (sample - self.miss) / self.misses;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    const DT: f64 = 0.008;
    const WIDTH: f64 = 7e-6;

    /// Twenty seconds of measurements of a line with 100 ppm, `extra` added at each time.
    fn factor(seed: u64, mut extra: impl FnMut(f64, f64) -> f64) -> f64 {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let mut correlated = CorrelatedDelay::new();
        let mut time = 0.0;
        for k in 0..2_500 {
            // Some measurements are missing.
            let dt = if k % 7 == 3 { 3.0 * DT } else { DT };
            time += dt;
            let value = 1e-4 * time + WIDTH * normal() + extra(time, normal());
            correlated.take(dt, value, WIDTH * WIDTH);
        }
        correlated.factor()
    }

    #[test]
    fn independent_messages_are_not_correlated() {
        for seed in 0..300 {
            assert!(factor(seed, |_, _| 0.0) < 1.0 + 1e-9, "{seed}");
        }
    }

    #[test]
    fn neither_do_steps_of_the_drift() {
        let step = |time: f64, _: f64| 5e-6 * (time - 10.0).max(0.0);
        for seed in 0..50 {
            assert!(factor(seed, step) < 1.0 + 1e-9, "{seed}");
        }
    }

    #[test]
    fn correlated_delays_are_worth_what_their_spectrum_says() {
        // First-order: the variance of a long mean of it is 2·σ²·τ over the time.
        let (sigma, tau) = (10e-6, 0.1);
        let expected = 1.0 + 2.0 * sigma * sigma * tau / (WIDTH * WIDTH * DT);
        let mut factors: [f64; 60] = core::array::from_fn(|seed| {
            let mut delay = 0.0;
            factor(seed as u64, |_, normal| {
                let keep = libm::exp(-DT / tau);
                delay = keep * delay + sigma * libm::sqrt(1.0 - keep * keep) * normal;
                delay
            })
        });
        factors.sort_unstable_by(f64::total_cmp);
        let median = factors[30];
        let part = median / expected;
        assert!((0.5..2.0).contains(&part), "{median} for {expected}");
        assert!(factors[3] > 0.25 * expected, "{factors:?}");
    }
}
