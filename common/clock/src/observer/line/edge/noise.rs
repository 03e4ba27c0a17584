//! Scatter of points on the edge.

use super::windows::{KEPT, Windows};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the scatter of points.
    EdgeNoiseTuning {
        /// Greatest deviation, as a multiple of the usual one.
        outlier: f64 = 9.0,
        /// Excess of the scatter of points far apart that is no chance.
        chance: f64 = 2.0,
        /// Least scatter of even the sharpest edge, s².
        // 40 ns, a clock is read within that.
        least: f64 = 1.6e-15,
        /// Relative excess of the assumed scatter, to be divided by the number of second differences.
        few: f64 = 8.0,
    }
}

/// Windows between the points that are compared.
const LAGS: [usize; 3] = [1, 3, 7];
/// The part of the second differences that is not larger: those of points on the edge.
const PART: f64 = 0.4;
/// Quantile `PART` of the squares of a normal variable.
const SQUARE_AT_PART: f64 = 0.275;

/// The scatter of the points, s².
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    near: f64,
    variance: f64,
}

impl Noise {
    pub(super) const fn new() -> Self {
        Self {
            near: 1e-12,
            variance: 1e-12,
        }
    }

    /// The variance of a point, as it counts for the line: more, if consecutive points are correlated.
    pub(super) const fn variance(&self) -> f64 {
        self.variance
    }

    /// The variance of a point beside its neighbours.
    pub(super) const fn near(&self) -> f64 {
        self.near
    }

    /// Measures the scatter of the points kept.
    pub(super) fn measure(&mut self, windows: &Windows, drift_walk: f64) {
        let mut squares = [0.0; KEPT];
        let mut n = 0;
        // Second differences: neither an offset nor a drift of the line is in them.
        for end in 2..windows.len() {
            if let Some(square) = windows.second_difference(end, 1, drift_walk) {
                squares[n] = square;
                n += 1;
            }
        }
        // Fewer say nothing of a quantile.
        if n < 3 {
            return;
        }
        let place = ((n as f64 * PART) as usize).min(n - 1);
        // A quantile, as a mean is misled where a third of the points are late, even if it is clipped.
        let square = *squares[..n].select_nth_unstable_by(place, f64::total_cmp).1;
        let near = (square / SQUARE_AT_PART).max(TUNING.least) * (1.0 + TUNING.few / n as f64);
        let mut factor = 1.0_f64;
        // Points that are independent scatter over three and seven windows as over one.
        for lag in &LAGS[1..] {
            let (mut sum, mut count) = (0.0, 0.0);
            for end in 2 * lag..windows.len() {
                if windows.are_on_the_edge(end, *lag)
                    && let Some(square) = windows.second_difference(end, *lag, drift_walk)
                {
                    sum += square.min(TUNING.outlier * TUNING.outlier * near);
                    count += 1.0;
                }
            }
            // With some differences as usual as the near ones: a single one over seven windows is chance.
            let far = (sum + TUNING.few * near) / (count + TUNING.few);
            if far > TUNING.chance * near {
                // Points that are correlated over `lag` windows count as one, so that each has some `lag` times its variance.
                factor = factor.max(0.5 * far / near * *lag as f64);
            }
        }
        self.near = near;
        self.variance = near * factor;
    }
}
