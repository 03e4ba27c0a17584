//! Polynomials: values, derivatives, roots and ranges.

use super::motion::MinMax;
use super::roots::{Roots, Smooth, roots_between_extremes};

/// A polynomial with `N` coefficients (degree `N` − 1 at most), lowest power first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial<const N: usize>(pub [f64; N]);

impl<const N: usize> Polynomial<N> {
    /// Returns the value and first three derivatives, by one nested pass.
    #[inline]
    pub fn derivatives(&self, x: f64) -> [f64; 4] {
        let [mut value, mut first, mut half_second, mut sixth_third] = [0.0; 4];
        // Horner's scheme, with derivatives: the k-th row collects the k-th derivative divided by k!.
        for &coefficient in self.0.iter().rev() {
            sixth_third = sixth_third * x + half_second;
            half_second = half_second * x + first;
            first = first * x + value;
            value = value * x + coefficient;
        }
        [value, first, 2.0 * half_second, 6.0 * sixth_third]
    }

    /// Returns the derivative; its highest coefficient is zero.
    #[must_use]
    pub fn derivative(&self) -> Self {
        let mut derivative = [0.0; N];
        for k in 1..N {
            derivative[k - 1] = self.0[k] * k as f64;
        }
        Self(derivative)
    }

    /// Returns the product with another polynomial, of `P` coefficients, which must be enough for all its
    /// powers.
    #[must_use]
    pub fn product<const O: usize, const P: usize>(&self, other: &Polynomial<O>) -> Polynomial<P> {
        let mut product = [0.0; P];
        for (i, one) in self.0.iter().enumerate() {
            for (place, another) in product.iter_mut().skip(i).zip(&other.0) {
                *place += one * another;
            }
        }
        Polynomial(product)
    }

    /// Returns the real roots from `lo` to `hi`, both included, ascending, to the last bits. A polynomial
    /// that is zero everywhere has the root `lo`.
    #[must_use]
    pub fn roots_in(&self, lo: f64, hi: f64) -> Roots {
        // The recursion below loses one degree per step and ends here.
        if self.degree() == 0 {
            let mut roots = Roots::none();
            if self.0[0] == 0.0 {
                roots.push(lo);
            }
            return roots;
        }
        // Between two extremes there is at most one root, so none is missed, unlike by samples.
        let extremes = self.derivative().roots_in(lo, hi);
        roots_between_extremes(self, &extremes, lo, hi)
    }

    /// Returns the extremes from `lo` to `hi` of the value and of the first three derivatives.
    #[must_use]
    pub fn ranges_in(&self, lo: f64, hi: f64) -> [MinMax; 4] {
        let first = self.derivative();
        let second = first.derivative();
        let third = second.derivative();
        // The roots of a derivative are needed for the roots of the one before.
        let snap = third.derivative().roots_in(lo, hi);
        let jerk = roots_between_extremes(&third, &snap, lo, hi);
        let acceleration = roots_between_extremes(&second, &jerk, lo, hi);
        let velocity = roots_between_extremes(&first, &acceleration, lo, hi);
        [
            self.range_with_extremes(&velocity, lo, hi),
            first.range_with_extremes(&acceleration, lo, hi),
            second.range_with_extremes(&jerk, lo, hi),
            third.range_with_extremes(&snap, lo, hi),
        ]
    }

    fn range_with_extremes(&self, extremes: &[f64], lo: f64, hi: f64) -> MinMax {
        // Both ends count: an extreme need not be a root of the derivative.
        let range = MinMax::at(lo, self.value(lo));
        let candidates = extremes.iter().chain(core::iter::once(&hi));
        candidates.fold(range, |range, &x| {
            range.joined(MinMax::at(x, self.value(x)))
        })
    }

    /// Returns the value at `x`.
    #[must_use]
    pub fn value(&self, x: f64) -> f64 {
        self.derivatives(x)[0]
    }

    fn degree(&self) -> usize {
        // Exact zeros only. A tiny leading coefficient costs a step of the recursion, but no root.
        self.0.iter().rposition(|&c| c != 0.0).unwrap_or(0)
    }
}

impl<const N: usize> Smooth for Polynomial<N> {
    fn at(&self, x: f64) -> (f64, f64) {
        let [value, slope, ..] = self.derivatives(x);
        (value, slope)
    }

    fn rounding(&self, x: f64) -> f64 {
        let x = x.abs();
        // Horner's scheme errs by some ε times the sum of all
        // magnitudes, which cancellation does not reduce.
        let magnitude = self.0.iter().rev().fold(0.0, |sum, c| sum * x + c.abs());
        4.0 * f64::EPSILON * magnitude
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns the product of (x − root).
    fn with_roots(roots: &[f64]) -> Polynomial<8> {
        let mut product = [0.0; 8];
        product[0] = 1.0;
        for root in roots {
            for k in (0..8).rev() {
                let lower = if k > 0 { product[k - 1] } else { 0.0 };
                product[k] = lower - root * product[k];
            }
        }
        Polynomial(product)
    }

    #[test]
    fn roots_are_found_at_the_ends_and_where_they_only_touch() {
        let touching = with_roots(&[0.0, 0.5, 0.5, 1.0]);
        assert_eq!(touching.roots_in(0.0, 1.0).as_ref(), [0.0, 0.5, 1.0]);
        assert_eq!(touching.roots_in(0.1, 0.9).as_ref(), [0.5]);
        assert!(touching.roots_in(1.5, 3.0).is_empty());
        let triple = with_roots(&[0.25, 0.25, 0.25]);
        assert_eq!(triple.roots_in(-10.0, 10.0).as_ref(), [0.25]);
    }

    #[test]
    fn constants_have_no_root_or_the_first() {
        assert!(Polynomial([2.0, 0.0]).roots_in(0.0, 1.0).is_empty());
        assert_eq!(Polynomial([0.0; 4]).roots_in(0.5, 1.0).as_ref(), [0.5]);
    }

    #[test]
    fn roots_are_precise_on_every_scale() {
        for scale in [1e-200, 1e-9, 1.0, 1e12] {
            let cubic = Polynomial([-2e-30 * scale, 0.0, 0.0, scale]);
            // At 1.26e-10: an absolute tolerance of the root would give it few digits.
            let root = cubic.roots_in(0.0, 1.0)[0];
            let expected = libm::cbrt(2e-30);
            assert!((root - expected).abs() <= 1e-15 * expected);
        }
    }

    proptest! {
        #[test]
        fn a_product_has_the_roots_of_its_factors(
            mut roots in prop::collection::vec(-1.0..1.0, 1..7),
        ) {
            roots.sort_by(f64::total_cmp);
            // Nearer roots merge into one: the coefficients are
            // rounded, and the error grows by each close neighbour.
            prop_assume!(roots.windows(2).all(|pair| pair[1] - pair[0] > 0.05));
            let found = with_roots(&roots).roots_in(-1.0, 1.0);
            prop_assert_eq!(found.len(), roots.len());
            for (found, root) in found.iter().zip(&roots) {
                // Close neighbours cost digits: the coefficients are rounded.
                prop_assert!((found - root).abs() < 1e-8);
            }
        }

        #[test]
        fn derivatives_are_those_of_the_powers(
            coefficients in prop::array::uniform8(-3.0..3.0),
            x in -2.0..2.0,
        ) {
            let polynomial = Polynomial(coefficients);
            let mut derivative = polynomial;
            for value in polynomial.derivatives(x) {
                prop_assert!((value - derivative.derivatives(x)[0]).abs() <= 1e-9);
                derivative = derivative.derivative();
            }
        }
    }
}
