//! Functions that `libm` computes bit by bit or with care for extremes, for the numbers of this crate: a few instructions
//! in every message and cycle instead of some thirty.

/// The whole number nearest to `x`, halves away from zero; saturates, and NaN becomes 0.
pub(crate) fn rounded(x: f64) -> i64 {
    // `as` saturates and makes 0 of NaN, as the language defines.
    let whole = x as i64;
    let part = x - whole as f64;
    whole.saturating_add(i64::from(part >= 0.5) - i64::from(part <= -0.5))
}

/// The largest whole number that is not above `x`; saturates, and NaN becomes 0.
pub(crate) fn floored(x: f64) -> i64 {
    let whole = x as i64;
    whole.saturating_sub(i64::from(x < whole as f64))
}

/// The standard deviation of a sum of parts with these: √(a² + b²). Neither is so large or so small that its square
/// could not be represented.
pub(crate) fn together(a: f64, b: f64) -> f64 {
    libm::sqrt(a * a + b * b)
}

/// Logarithms of a number that changes little from one to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearLogarithm {
    of: f64,
    inverse: f64,
    logarithm: f64,
}

/// The series of ln(1 + x) up to the fifth power is exact to the last place of 1 within this.
// Next term of the series: x⁶/6, 1.1·10⁻¹⁷ at this bound, below half a unit in the last place of 1.
const NEAR: f64 = 2e-3;

impl NearLogarithm {
    pub(crate) const ONE: Self = Self {
        of: 1.0,
        inverse: 1.0,
        logarithm: 0.0,
    };

    /// The natural logarithm of `x`, which is above 0.
    pub(crate) fn of(&mut self, x: f64) -> f64 {
        let part = (x - self.of) * self.inverse;
        if part.abs() < NEAR {
            let series = 1.0 - part * (0.5 - part * (1.0 / 3.0 - part * (0.25 - 0.2 * part)));
            // About the same point for as long as possible: from step to step the rounding errors would add up.
            return self.logarithm + part * series;
        }
        *self = Self {
            of: x,
            inverse: 1.0 / x,
            logarithm: libm::log(x),
        };
        self.logarithm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn extremes_are_as_of_libm() {
        let extremes = [
            0.0,
            -0.0,
            0.5,
            -0.5,
            1.5,
            0.499_999_999_999_999_94,
            -0.499_999_999_999_999_94,
            4_503_599_627_370_495.5,
            9_007_199_254_740_993.0,
            9.3e18,
            -9.3e18,
            1e300,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        for x in extremes {
            assert_eq!(rounded(x), libm::round(x) as i64, "{x}");
            assert_eq!(floored(x), libm::floor(x) as i64, "{x}");
        }
    }

    proptest! {
        #[test]
        fn whole_numbers_are_those_of_libm(x in -1e6..1e6_f64, far in -1e18..1e18_f64) {
            for x in [x, far] {
                prop_assert_eq!(rounded(x), libm::round(x) as i64);
                prop_assert_eq!(floored(x), libm::floor(x) as i64);
            }
        }

        #[test]
        fn parts_together_are_a_hypotenuse(a in -1e-3..1e-3_f64, b in 1e-9..1e3_f64) {
            prop_assert!((together(a, b) / libm::hypot(a, b) - 1.0).abs() < 4.0 * f64::EPSILON);
        }

        #[test]
        fn a_number_that_wanders_has_its_logarithm(
            first in 1e-12..1e12_f64,
            steps in prop::collection::vec(-1e-3..1e-3_f64, 1..200),
        ) {
            let mut near = NearLogarithm::ONE;
            let mut x = first;
            for step in steps {
                x *= 1.0 + step;
                let exact = libm::log(x);
                prop_assert!((near.of(x) - exact).abs() <= f64::EPSILON * exact.abs().max(2.0));
            }
        }
    }
}
