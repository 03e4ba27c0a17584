//! Arrivals that are stamped with a coarse clock.
//!
//! Some machines know the time only to tens of microseconds. An arrival then says that the message
//! came somewhere in a cell, from the stamp on; the likelihood of a location is that of the cell, the
//! jitter's distribution integrated over it.

use crate::instant::{Instant, Local, Span};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the resolution.
    ResolutionTuning {
        /// A finer resolution does not matter, ns.
        // 1/√12 of it is 1.4 µs, beside jitter of some 5 µs at least.
        coarse: u64 = 5_000,
        /// From this number of tenths of a cycle on, a common divisor of all differences may be the sender's pace instead of a resolution.
        // Arrivals without any jitter come exactly a cycle after each other.
        pace_in_tenths: u64 = 9,
    }
}

/// Finds the resolution of arrivals: all differences are multiples of it.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Resolution {
    first: Option<(i64, Instant<Local>)>,
    divisor: u64,
    /// Width from which a divisor may be no cell, ns.
    pace: u64,
    /// True if an arrival was not where the pace would have it, so that a divisor as wide is a cell.
    is_no_pace: bool,
    /// The cell that teeth showed, s: see [`set_polled`](Self::set_polled).
    of_teeth: f64,
}

impl Resolution {
    /// Makes a resolution for a sender of this cycle time.
    pub(in crate::observer) fn new(data_cycle_time: Span) -> Self {
        Self {
            first: None,
            divisor: 0,
            pace: data_cycle_time.as_nanos().unsigned_abs() / 10 * TUNING.pace_in_tenths,
            is_no_pace: false,
            of_teeth: 0.0,
        }
    }

    /// Takes the arrival of a count.
    pub(in crate::observer) fn take(&mut self, count: i64, arrived: Instant<Local>) {
        let (first_count, first) = *self.first.get_or_insert((count, arrived));
        // Once it is fine it stays so.
        if self.divisor == 0 || self.divisor >= TUNING.coarse {
            let passed = (arrived - first).as_nanos();
            // The greatest common divisor of all times since the first arrival: one fine arrival ends it for good.
            self.divisor = divisor(self.divisor, passed.unsigned_abs());
            let paced = (self.divisor as i64).wrapping_mul(count.wrapping_sub(first_count));
            // An arrival that is one divisor off its count left a cycle out, or came twice in one: polling, and no pace.
            let beside = passed.wrapping_sub(paced).unsigned_abs();
            self.is_no_pace |= self.divisor >= self.pace && beside == self.divisor;
        }
    }

    /// Sets the cell of polling: phases were level, then jumped by `cell`, and were level again, as messages are seen a
    /// little late each time.
    pub(in crate::observer) const fn set_polled(&mut self, cell: f64) {
        self.of_teeth = cell;
    }

    /// The width of a cell of a coarse clock, s; 0 where it is so fine that it does not matter.
    pub(in crate::observer) fn cell(&self) -> f64 {
        if (TUNING.coarse..self.pace).contains(&self.divisor) {
            self.divisor as f64 * 1e-9
        } else {
            0.0
        }
    }

    /// Time before it is seen that a message may have come, s, where messages are polled for; else 0. A coarse clock shows
    /// the beginning of a cell, and polling sees a message at its end.
    pub(in crate::observer) fn polled(&self) -> f64 {
        if self.is_no_pace && self.divisor >= self.pace {
            self.divisor as f64 * 1e-9
        } else {
            self.of_teeth
        }
    }
}

fn divisor(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Scores of a cell for the jitter's location and widths: derivatives of its log-likelihood.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct CellScores {
    pub(in crate::observer) location: f64,
    /// The negative second derivative in the location.
    pub(in crate::observer) curvature: f64,
}

/// The jitter: a normal part and an exponential one, s.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Widths {
    pub(in crate::observer) normal: f64,
    pub(in crate::observer) exponential: f64,
}

/// Normal widths on the early side beyond which only the normal part counts, …
const EARLY: f64 = -7.0;
/// … and on the late side beyond which only the tail of the exponential one does, counted from where the normal one has moved its density to.
// The density of the sum is that of the tail times Φ(z − σ/τ), and Φ(6) is 1 to 1e-9. Farther out the difference of two values of the distribution
// near 1, each rounded to 1e-16, loses its digits: at σ = 3 τ six of them are left here, and at 35 τ and any ratio the scores were off by half.
const TAIL: f64 = 6.0;
/// Relative change of the widths for numerical derivatives.
const STEP: f64 = 1e-3;

impl Widths {
    /// Density and distribution at a residual.
    fn at(&self, residual: f64) -> (f64, f64) {
        let ratio = self.normal / self.exponential;
        let z = residual / self.normal;
        if z < EARLY {
            // Nothing, and not infinity times nothing.
            return (0.0, 0.0);
        }
        let tail = 0.5 * ratio * ratio - residual / self.exponential;
        let tail = libm::exp(tail) * below(z - ratio);
        (tail / self.exponential, below(z) - tail)
    }

    /// Scores of a cell of this width that begins `residual` after the location.
    pub(in crate::observer) fn cell(&self, residual: f64, width: f64) -> CellScores {
        let end = residual + width;
        // Both values of the distribution underflow there. A normal tail has this slope and curvature.
        if end < EARLY * self.normal {
            let certainty = 1.0 / (self.normal * self.normal);
            return CellScores {
                location: end * certainty,
                curvature: certainty,
            };
        }
        let ((from, below_from), (to, below_to)) = (self.at(residual), self.at(end));
        let within = below_to - below_from;
        let is_in_tail = residual / self.normal - self.normal / self.exponential > TAIL;
        if is_in_tail || within < 1e-200 {
            return CellScores {
                location: 1.0 / self.exponential,
                curvature: 0.0,
            };
        }
        let location = (from - to) / within;
        let slope = |residual: f64, density: f64| {
            let z = residual / self.normal;
            let normal = libm::exp(-0.5 * z * z) * 0.398_942_280_401_432_7 / self.normal;
            (normal - density) / self.exponential
        };
        let bend = (slope(end, to) - slope(residual, from)) / within;
        CellScores {
            location,
            // Rounding of two large numbers may leave a little less than nothing.
            curvature: (location * location - bend).max(0.0),
        }
    }

    /// Derivatives of a cell's log-likelihood in the logarithms of the normal and the exponential width.
    pub(in crate::observer) fn cell_widths(&self, residual: f64, width: f64) -> (f64, f64) {
        let likelihood = |normal: f64, exponential: f64| {
            let widths = Self {
                normal: self.normal * normal,
                exponential: self.exponential * exponential,
            };
            let within = widths.at(residual + width).1 - widths.at(residual).1;
            libm::log(within.max(1e-200))
        };
        // Numerical, as the derivatives in the widths have a dozen terms. A relative step of 1e-3 leaves six digits.
        let slope = |more: f64, less: f64| (more - less) / (2.0 * STEP);
        (
            slope(likelihood(1.0 + STEP, 1.0), likelihood(1.0 - STEP, 1.0)),
            slope(likelihood(1.0, 1.0 + STEP), likelihood(1.0, 1.0 - STEP)),
        )
    }
}

/// The normal distribution.
fn below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resolution_is_what_divides_all_differences() {
        let mut resolution = Resolution::new(Span::from_millis(1));
        for k in [7, 9, 12, 30, 31] {
            resolution.take(k, Instant::from_nanos(123 + 50_000 * k));
        }
        assert_eq!(resolution.cell(), 50e-6);
        resolution.take(40, Instant::from_nanos(123 + 50_000 * 40 + 17));
        assert_eq!(resolution.cell(), 0.0);
        resolution.take(50, Instant::from_nanos(123 + 50_000 * 50));
        assert_eq!(resolution.cell(), 0.0, "once fine, always fine");
    }

    #[test]
    fn the_pace_of_the_sender_is_no_resolution() {
        let cycle = 1_000_030;
        let mut resolution = Resolution::new(Span::from_millis(1));
        for k in [0, 1, 2, 3, 5] {
            resolution.take(k, Instant::from_nanos(123 + cycle * k));
            assert_eq!(resolution.cell(), 0.0);
        }
        // Nor is it if only every other message came as yet.
        let mut resolution = Resolution::new(Span::from_millis(1));
        for (k, cell) in [(0, 0.0), (40, 0.0), (80, 0.0), (101, 50e-6)] {
            resolution.take(k / 20, Instant::from_nanos(50_000 * k));
            assert_eq!(resolution.cell(), cell, "{k}");
        }
    }

    #[test]
    fn a_grid_of_a_whole_cycle_shows_when_a_cycle_is_left_out_or_comes_twice() {
        let millis = |ms| Instant::from_nanos(123 + 1_000_000 * ms);
        for beside in [1, -1] {
            let mut resolution = Resolution::new(Span::from_millis(1));
            for count in [0, 1, 2, 5, 9] {
                resolution.take(count, millis(count));
                assert_eq!(resolution.polled(), 0.0);
            }
            resolution.take(10, millis(10 + beside));
            assert_eq!((resolution.cell(), resolution.polled()), (0.0, 1e-3));
        }
    }

    #[test]
    fn a_cells_scores_are_the_slopes_of_its_likelihood() {
        let widths = Widths {
            normal: 5e-6,
            exponential: 20e-6,
        };
        let cell = 50e-6;
        let likelihood =
            |residual: f64| libm::log(widths.at(residual + cell).1 - widths.at(residual).1);
        for residual in [-60e-6, -40e-6, -10e-6, 0.0, 30e-6, 200e-6] {
            let scores = widths.cell(residual, cell);
            let step = 2e-8;
            let (less, here, more) = (
                likelihood(residual + step),
                likelihood(residual),
                likelihood(residual - step),
            );
            let slope = (more - less) / (2.0 * step);
            let bend = -(more - 2.0 * here + less) / (step * step);
            assert!((scores.location / slope - 1.0).abs() < 1e-3, "{residual}");
            let tolerance = 1e-2 * scores.curvature + 1e5;
            assert!(
                (scores.curvature - bend).abs() < tolerance,
                "{residual}: {bend}"
            );
        }
    }

    #[test]
    fn far_on_the_late_side_the_scores_are_those_of_the_tail() {
        for ratio in [0.02, 0.25, 1.0, 3.0] {
            let widths = Widths {
                normal: 2e-6 * ratio,
                exponential: 2e-6,
            };
            for part in [0.01, 0.3, 3.0] {
                for later in 0..600 {
                    let begin = (5.0 + ratio) * widths.normal;
                    let residual = begin + 0.1 * f64::from(later) * 2e-6;
                    let scores = widths.cell(residual, part * 2e-6);
                    let location = scores.location * 2e-6;
                    let curvature = scores.curvature * 4e-12;
                    // Of an exponential tail, 1/τ and 0.
                    let is_of_tail = (location - 1.0).abs() < 1e-3 && curvature < 1e-2;
                    assert!(is_of_tail, "{ratio} {part} {later}: {location} {curvature}");
                }
            }
        }
    }

    #[test]
    fn far_out_it_stays_finite() {
        for exponential in [1e-6, 50e-9] {
            far_out_of(&Widths {
                normal: 50e-9,
                exponential,
            });
        }
    }

    fn far_out_of(widths: &Widths) {
        for residual in [-1.0, -1e-3, -50.1e-6, -5e-6, 1e-3, 1.0] {
            let scores = widths.cell(residual, 50e-6);
            assert!(scores.location.is_finite() && scores.curvature.is_finite());
            let (normal, exponential) = widths.cell_widths(residual, 50e-6);
            assert!(normal.is_finite() && exponential.is_finite());
        }
    }
}
