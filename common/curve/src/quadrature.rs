//! Integrals to full precision.

/// Half of the nodes and weights of Gauss and Legendre's rule of ten points on [-1, 1], which is
/// exact up to degree 19 (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (0.148_874_338_981_631_21, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_36),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Greatest number of bisections: an interval has no more bits.
const MOST_HALVINGS: u32 = 52;

/// Returns the integral of a continuous function that is nowhere below 0. Where it is not smooth (at a
/// bend of a law, or a change of sign under a magnitude) the interval around it is bisected until it no
/// longer counts.
pub fn integral(start: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
    // Without negative values the total can only grow, so a
    // tolerance relative to it does not get lost by cancellation.
    let whole = gauss(start, end, &f);
    refined(start, end, whole, whole, MOST_HALVINGS, &f)
}

/// Returns the integral of a polynomial up to degree 19.
pub fn integral_of_polynomial(start: f64, end: f64, f: impl Fn(f64) -> f64) -> f64 {
    gauss(start, end, &f)
}

fn refined(
    start: f64,
    end: f64,
    estimate: f64,
    total: f64,
    halvings: u32,
    f: &impl Fn(f64) -> f64,
) -> f64 {
    let middle = start + (end - start) / 2.0;
    let (left, right) = (gauss(start, middle, f), gauss(middle, end, f));
    let better = left + right;
    // Relative to the whole, not to this interval: around a bend the parts soon count for nothing.
    let settled = (better - estimate).abs() <= 4.0 * f64::EPSILON * total.max(better);
    // An overflow is not resolved by ever finer intervals either.
    if settled || !better.is_finite() || halvings == 0 {
        return better;
    }
    refined(start, middle, left, total, halvings - 1, f)
        + refined(middle, end, right, total, halvings - 1, f)
}

fn gauss(start: f64, end: f64, f: &impl Fn(f64) -> f64) -> f64 {
    // Half of the difference, since the sum of both ends could overflow.
    let (middle, half) = (start + (end - start) / 2.0, (end - start) / 2.0);
    let pairs = GAUSS
        .iter()
        // Nodes lie symmetrically, so half of them suffices for the table.
        .map(|&(node, weight)| weight * (f(middle - half * node) + f(middle + half * node)));
    half * pairs.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_integral_that_overflows_ends_at_once() {
        assert!(integral(0.0, 1.0, |_| f64::INFINITY).is_infinite());
        assert!(integral(0.0, 1.0, |_| f64::NAN).is_nan());
    }

    fn assert_close(received: f64, expected: f64) {
        assert!(
            // 45 ε, for the rounding of ten products and of the power itself.
            (received - expected).abs() <= 1e-14 * expected.abs(),
            "received {received}, expected {expected}"
        );
    }

    #[test]
    fn powers_are_exact() {
        // Ten nodes integrate degree 2·10 − 1 exactly.
        for degree in 0..20 {
            let power = |x| libm::pow(x, f64::from(degree));
            let n = f64::from(degree) + 1.0;
            assert_close(integral(0.0, 2.0, power), libm::pow(2.0, n) / n);
            assert_close(
                integral_of_polynomial(0.0, 2.0, power),
                libm::pow(2.0, n) / n,
            );
        }
    }

    #[test]
    fn bends_are_found() {
        // 1/3 is no binary fraction, so no bisection meets the bend exactly.
        // |x - 1/3| from 0 to 1: two triangles.
        assert_close(
            integral(0.0, 1.0, |x| (x - 1.0 / 3.0).abs()),
            (1.0 / 9.0 + 4.0 / 9.0) / 2.0,
        );
        assert_close(
            integral(0.0, core::f64::consts::TAU, |x| libm::sin(x).abs()),
            4.0,
        );
    }

    #[test]
    fn nothing_is_nothing() {
        assert_eq!(integral(-1.0, 1.0, |_| 0.0), 0.0);
    }
}
