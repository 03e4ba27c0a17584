//! The line that most points support, with the fewest below it.

use super::noise::Noise;
use super::windows::{KEPT, Windows};
use super::{Line, TUNING as EDGE};
use crate::observer::LARGEST_DRIFT;
use crate::observer::line::Estimate;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the search for a line.
    ConsensusTuning {
        /// Greatest cost of a point above the line, in variances.
        // Delays may last, so a point above says little.
        above: f64 = 9.0,
        /// Greatest cost of a point below it, as nothing comes early.
        // Three of them outweigh all the others, 32 times 9.
        below: f64 = 100.0,
        /// Factor on the scatter for comparisons.
        wider: f64 = 1.5,
        /// Margin by which a line must be better to replace the present one …
        margin: f64 = 20.0,
        /// … and the part of that which is enough where the present one has no newer point.
        unsupported_part: f64 = 0.25,
        /// Greatest cost of a drift that is not the one known.
        drift_cost: f64 = 40.0,
        /// Factor on the standard deviation of the drift.
        // Points on the edge are not independent (AR(1) delays with stamps: 10.2 → 5.9 µs rms).
        drift_doubt: f64 = 3.0,
        /// Distance, in widths, within which points are on the line.
        on: f64 = 3.0,
        /// Error of the drift that is always possible, s/s.
        drift_tolerance: f64 = 1e-7,
    }
}

/// Lowest points of either half that make candidates.
const TRIED: usize = 3;

/// A line to compare with the present one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// Height above the present line at its time, s.
    offset: f64,
    /// Less the present line's, s/s. None: the line is only moved.
    drift: Option<f64>,
}

/// The points as seen from the present line: times since its own, and by how much they lie above it.
struct Seen {
    times: [f64; KEPT],
    above: [f64; KEPT],
    len: usize,
    inverse_width: f64,
}

impl Seen {
    fn from(windows: &Windows, line: &Line, noise: &Noise) -> Self {
        let mut seen = Self {
            times: [0.0; KEPT],
            above: [0.0; KEPT],
            len: windows.len(),
            // The scatter of near points: with that over seven windows the edge of slow, wide correlated delays becomes a mean.
            inverse_width: 1.0 / (TUNING.wider * libm::sqrt(noise.near())),
        };
        for (n, point) in windows.points().enumerate() {
            seen.times[n] = point.time - line.at;
            seen.above[n] = point.phase - line.offset_at(point.time);
        }
        seen
    }

    fn distance(&self, n: usize, offset: f64, drift: f64) -> f64 {
        (self.above[n] - offset - drift * self.times[n]) * self.inverse_width
    }

    fn cost(&self, offset: f64, drift: f64) -> f64 {
        (0..self.len)
            .map(|n| {
                let distance = self.distance(n, offset, drift);
                let square = distance * distance;
                // Truncated squares: points that are far off a line do not draw it towards them, and cost no more than others.
                square.min(if distance > 0.0 {
                    TUNING.above
                } else {
                    TUNING.below
                })
            })
            .sum()
    }

    /// Number of points that are on a line.
    fn support(&self, range: core::ops::Range<usize>, offset: f64, drift: f64) -> usize {
        range
            .filter(|n| libm::fabs(self.distance(*n, offset, drift)) < TUNING.on)
            .count()
    }

    /// The lowest points among some.
    fn lowest(&self, range: core::ops::Range<usize>) -> [usize; TRIED] {
        let mut lowest = [range.start; TRIED];
        let mut heights = [f64::INFINITY; TRIED];
        for n in range {
            let mut this = (n, self.above[n]);
            for (place, height) in lowest.iter_mut().zip(&mut heights) {
                if this.1 < *height {
                    core::mem::swap(&mut this.0, place);
                    core::mem::swap(&mut this.1, height);
                }
            }
        }
        lowest
    }
}

/// Finds a line that is clearly better than the present one, if there is one.
pub(super) fn better(windows: &Windows, line: &Line, noise: &Noise) -> Option<Candidate> {
    let seen = Seen::from(windows, line, noise);
    // A line with no newer point on it has little weight.
    let supported = seen.support(seen.len / 2..seen.len, 0.0, 0.0) >= 2;
    let margin = if supported {
        TUNING.margin
    } else {
        TUNING.unsupported_part * TUNING.margin
    };
    // In these coordinates the present line is level at 0.
    let mut least = seen.cost(0.0, 0.0) - margin;
    if least < 0.0 {
        return None;
    }
    let mut best = None;
    let mut consider = |cost: f64, candidate: Candidate| {
        if cost < least {
            least = cost;
            best = Some(candidate);
        }
    };
    // First lines that are only higher or lower: the drift is known, and a level of the path left.
    for n in seen.len - EDGE.enough..seen.len {
        let offset = seen.above[n];
        let candidate = Candidate {
            offset,
            drift: None,
        };
        consider(seen.cost(offset, 0.0), candidate);
    }
    let known = TUNING.drift_doubt * TUNING.drift_doubt * line.estimate.drift_variance;
    let certainty = 1.0 / (known + TUNING.drift_tolerance * TUNING.drift_tolerance);
    let half = seen.len / 2;
    // Then lines through two low points, nine of them: the drift itself may be wrong from the start.
    for early in seen.lowest(0..half) {
        for late in seen.lowest(half..seen.len) {
            let passed = seen.times[late] - seen.times[early];
            let drift = (seen.above[late] - seen.above[early]) / passed;
            if passed <= 0.0 || libm::fabs(line.estimate.drift + drift) > LARGEST_DRIFT {
                continue;
            }
            let offset = seen.above[early] - drift * seen.times[early];
            // Bounded, or a drift that was known wrongly could never be given up.
            let unlikely = (drift * drift * certainty).min(TUNING.drift_cost);
            let candidate = Candidate {
                offset,
                drift: Some(drift),
            };
            consider(seen.cost(offset, drift) + unlikely, candidate);
        }
    }
    best
}

/// Fits the line through the points that support a candidate.
pub(super) fn fitted(
    windows: &Windows,
    line: &Line,
    candidate: &Candidate,
    noise: &Noise,
) -> Estimate {
    let variance = noise.variance();
    let moved = Estimate {
        offset: line.estimate.offset + candidate.offset,
        offset_variance: variance,
        covariance: 0.0,
        ..line.estimate
    };
    let Some(drift) = candidate.drift else {
        return moved;
    };
    let seen = Seen::from(windows, line, noise);
    let (mut n, mut t, mut y, mut tt, mut ty) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for i in 0..seen.len {
        if libm::fabs(seen.distance(i, candidate.offset, drift)) < TUNING.on {
            let (time, above) = (seen.times[i], seen.above[i]);
            n += 1.0;
            t += time;
            y += above;
            tt += time * time;
            ty += time * above;
        }
    }
    // Least squares over the points that are on the line, about the time of the present one.
    let determinant = n * tt - t * t;
    if n < TRIED as f64 || determinant <= 0.0 {
        return moved;
    }
    let drift = (n * ty - t * y) / determinant;
    Estimate {
        offset: line.estimate.offset + (y - drift * t) / n,
        drift: line.estimate.drift + drift,
        // Covariance of the fit: the inverse of the normal equations, times the variance of a point.
        offset_variance: variance * tt / determinant,
        covariance: -variance * t / determinant,
        drift_variance: variance * n / determinant,
    }
}
