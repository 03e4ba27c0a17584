//! Mean and spread of a stream of numbers.

/// Welford's method: exact for days of samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    pub(super) count: u64,
    pub(super) mean: f64,
    squares: f64,
    low: f64,
    high: f64,
}

impl Default for Moments {
    fn default() -> Self {
        Self {
            count: 0,
            mean: 0.0,
            squares: 0.0,
            // Without values the extremes are infinite, and figures are taken only where something was counted.
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        }
    }
}

impl Moments {
    pub(super) fn push(&mut self, x: f64) {
        self.count += 1;
        let off = x - self.mean;
        self.mean += off / self.count as f64;
        // The distance from the old mean times that from the new one (Welford 1962). A sum of squares less the square of the sum
        // would cancel most digits of a small spread around a large mean, such as microseconds around a lag of seconds.
        self.squares += off * (x - self.mean);
        self.low = self.low.min(x);
        self.high = self.high.max(x);
    }

    pub(super) fn deviation(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    pub(super) fn root_mean_square(&self) -> f64 {
        // E(x²) = variance + mean².
        (self.squares / self.count as f64 + self.mean * self.mean).sqrt()
    }

    pub(super) fn largest_magnitude(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    pub(super) fn largest_deviation(&self) -> f64 {
        self.largest_distance_from(self.mean)
    }

    pub(super) fn largest_distance_from(&self, centre: f64) -> f64 {
        (self.high - centre).max(centre - self.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_agree_with_the_textbook() {
        let mut moments = Moments::default();
        for x in [1.0, 2.0, 3.0, 6.0] {
            moments.push(x);
        }
        assert_eq!(moments.mean, 3.0);
        // Around the mean 3: (4 + 1 + 0 + 9) / 4. Around zero: (1 + 4 + 9 + 36) / 4.
        assert_eq!(moments.deviation(), 3.5_f64.sqrt());
        assert!((moments.root_mean_square() - 12.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(moments.largest_magnitude(), 6.0);
        assert_eq!(moments.largest_deviation(), 3.0);
    }
}
