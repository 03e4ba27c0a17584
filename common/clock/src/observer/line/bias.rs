//! Bias of a line, as the mean of its last innovations shows it.

/// Mean of the last measurements' deviations from their predictions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bias {
    /// The number of measurements that it is a mean over.
    memory: f64,
    /// s
    mean: f64,
    /// The variance of that by chance, s².
    by_chance: f64,
}

impl Bias {
    pub(super) const fn over(memory: f64) -> Self {
        Self {
            memory,
            mean: 0.0,
            by_chance: 0.0,
        }
    }

    /// Takes an innovation with the variance it should have. Its `weight` is at most 1.
    pub(super) fn take(&mut self, innovation: f64, variance: f64, weight: f64) {
        // A mean that forgets, as the bias of a minute ago says nothing of the drift now.
        let part = weight.min(1.0) / self.memory;
        self.mean += part * (innovation - self.mean);
        // The variance of such a mean of independent values is part/(2 − part) of one of them, some part/2.
        self.by_chance += part * (0.5 * part * variance - self.by_chance);
    }

    /// Forgets the bias after the line moved to where the measurements are.
    pub(super) const fn forget(&mut self) {
        // The variance by chance stays: it depends on the noise, which is what it was.
        self.mean = 0.0;
    }

    /// Square of the bias, as far as `sigmas` standard deviations do not explain it, s².
    pub(super) fn variance_beyond(&self, sigmas: f64) -> f64 {
        // Below zero there is no bias at all that chance does not explain.
        (self.mean * self.mean - sigmas * sigmas * self.by_chance).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::tests::delays::Random;

    #[test]
    fn chance_is_no_bias_and_an_offset_is_one() {
        for (off, is_bias) in [(0.0, false), (2e-6, true)] {
            let mut random = Random::of_seed(5);
            let mut bias = Bias::over(96.0);
            for _ in 0..5_000 {
                bias.take(off + 3e-6 * random.normal(), 9e-12, 1.0);
                assert!(is_bias || bias.variance_beyond(4.0) == 0.0);
            }
            assert_eq!(bias.variance_beyond(3.0) > 1e-12, is_bias);
            bias.forget();
            assert_eq!(bias.variance_beyond(0.0), 0.0);
        }
    }
}
