//! A Kalman filter of two states: how late count·T arrives, and by how much that grows.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of a filter.
    FilterTuning {
        /// Standard deviations at which innovations are clamped.
        // A normal one is beyond once in two million.
        clamp: f64 = 5.0,
    }
}

/// A straight line through the phase, with what is known about it. Seconds; drift in s/s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    pub(crate) offset: f64,
    pub(crate) drift: f64,
    pub(crate) offset_variance: f64,
    pub(crate) covariance: f64,
    pub(crate) drift_variance: f64,
}

/// The innovation of one measurement.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Innovation {
    pub(in crate::observer) value: f64,
    pub(in crate::observer) variance: f64,
}

impl Estimate {
    /// Moves on by `dt` seconds, during which the drift wanders with a variance of
    /// `drift_walk` per second.
    pub(in crate::observer) fn predict(&mut self, dt: f64, drift_walk: f64) {
        self.offset += self.drift * dt;
        // White noise on the drift integrates to q·dt³/3, q·dt²/2 and q·dt in the three variances.
        self.offset_variance += dt
            * (2.0 * self.covariance + dt * (self.drift_variance + drift_walk * dt * (1.0 / 3.0)));
        self.covariance += dt * (self.drift_variance + 0.5 * drift_walk * dt);
        self.drift_variance += drift_walk * dt;
    }

    /// Takes a measurement of the offset. The innovation returned is clamped.
    pub(in crate::observer) fn correct(&mut self, measured: f64, variance: f64) -> Innovation {
        let total = self.offset_variance + variance;
        let bound = TUNING.clamp * libm::sqrt(total);
        // Clamped, so that a single spike moves the line by a few standard deviations and not by its height.
        let value = (measured - self.offset).clamp(-bound, bound);
        let inverse = 1.0 / total;
        let gain = self.offset_variance * inverse;
        let drift_gain = self.covariance * inverse;
        self.offset += gain * value;
        self.drift += drift_gain * value;
        self.drift_variance -= drift_gain * self.covariance;
        // In this form both stay positive whatever the rounding.
        self.offset_variance = gain * variance;
        self.covariance = drift_gain * variance;
        // Keeps the determinant positive by more than the rounding of the three terms.
        let floor = 1.000_001 * self.covariance * self.covariance / self.offset_variance;
        self.drift_variance = self.drift_variance.max(floor);
        Innovation {
            value,
            variance: total,
        }
    }

    /// The offset's variance after another `dt` seconds.
    pub(crate) fn offset_variance_after(&self, dt: f64, drift_walk: f64) -> f64 {
        let mut later = *self;
        later.predict(dt, drift_walk);
        later.offset_variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clean_line_is_found_exactly() {
        let mut line = Estimate {
            offset: 0.0,
            drift: 0.0,
            offset_variance: 1e-6,
            covariance: 0.0,
            drift_variance: 1e-8,
        };
        for k in 1..=1000 {
            line.predict(0.01, 1e-18);
            let _ = line.correct(3e-4 + 5e-5 * 0.01 * f64::from(k), 1e-14);
        }
        assert!((line.drift - 5e-5).abs() < 1e-9, "{}", line.drift);
        assert!((line.offset - 8e-4).abs() < 1e-9, "{}", line.offset);
        assert!(line.offset_variance > 0.0 && line.drift_variance > 0.0);
    }
}
