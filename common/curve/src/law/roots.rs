//! Roots of a curve.

use core::ops::Deref;

/// Eleven roots of the highest polynomial; the joints and extremes of the longest chain of arcs.
const CAPACITY: usize = 16;

/// A few places in ascending order, stored inline. Dereferences to a slice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roots {
    places: [f64; CAPACITY],
    len: usize,
}

impl Roots {
    /// Makes an empty list.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            places: [0.0; CAPACITY],
            len: 0,
        }
    }

    /// Appends a place, unless it equals the last one up to rounding.
    pub fn push(&mut self, place: f64) {
        let known = self
            .last()
            // Two formulas may give one place with different
            // rounding, such as a joint of arcs from either side.
            .is_some_and(|last| (place - last).abs() <= 4.0 * f64::EPSILON * place.abs());
        if !known && self.len < CAPACITY {
            self.places[self.len] = place;
            self.len += 1;
        }
    }

    /// Returns the places in the opposite order.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.places[..self.len].reverse();
        self
    }

    /// Maps every place by `f`, which must be monotone.
    #[must_use]
    pub fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for place in &mut self.places[..self.len] {
            *place = f(*place);
        }
        self
    }
}

impl Deref for Roots {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.places[..self.len]
    }
}

/// A smooth curve whose roots are searched for.
pub trait Smooth {
    /// Returns the value and slope at `x`.
    fn at(&self, x: f64) -> (f64, f64);

    /// Returns the greatest rounding error of the value at `x`.
    fn rounding(&self, x: f64) -> f64;
}

/// A curve less a target value, so that its roots are where the curve reaches it.
pub struct LessTarget<C> {
    /// The curve.
    pub curve: C,
    /// The value.
    pub target: f64,
}

impl<C: Smooth> Smooth for LessTarget<C> {
    fn at(&self, x: f64) -> (f64, f64) {
        let (value, slope) = self.curve.at(x);
        (value - self.target, slope)
    }

    fn rounding(&self, x: f64) -> f64 {
        // Both are rounded before they are subtracted.
        self.curve.rounding(x) + f64::EPSILON * self.target.abs()
    }
}

/// Returns the roots of `curve` between `lo` and `hi`, both included, given its `extremes`: all roots of its
/// slope there.
///
/// Between two extremes the curve is monotone, so the roots follow from the signs at them. An extreme at
/// which the curve is zero up to rounding is a root.
pub fn roots_between_extremes(curve: &impl Smooth, extremes: &[f64], lo: f64, hi: f64) -> Roots {
    let mut roots = Roots::none();
    let mut left = CurveSample::of(curve, lo);
    if left.is_root() {
        roots.push(lo);
    }
    for &extreme in extremes.iter().chain(core::iter::once(&hi)) {
        // Extremes outside, or at the end just looked at, bound no interval.
        if extreme <= left.x {
            continue;
        }
        let right = CurveSample::of(curve, extreme);
        if right.is_root() {
            // If both ends of a monotone interval are zero, it is zero throughout: its begin counts as
            // the root.
            if !left.is_root() {
                roots.push(right.x);
            }
        } else if left.sign * right.sign < 0.0 {
            roots.push(refine(curve, left, right));
        }
        left = right;
    }
    roots
}

/// A place and the sign of the curve there.
#[derive(Clone, Copy)]
struct CurveSample {
    x: f64,
    value: f64,
    sign: f64,
}

impl CurveSample {
    fn of(curve: &impl Smooth, x: f64) -> Self {
        let value = curve.at(x).0;
        // A touching root is hit by rounding only: its sign would be that of the rounding.
        let sign = if value.abs() <= curve.rounding(x) {
            0.0
        } else {
            value.signum()
        };
        Self { x, value, sign }
    }

    fn is_root(&self) -> bool {
        self.sign == 0.0
    }
}

/// Narrows a change of sign down to the last bit: Newton's steps, and a bisection whenever they leave the
/// bracket or are slower than that.
fn refine(curve: &impl Smooth, left: CurveSample, right: CurveSample) -> f64 {
    let rising = right.value > 0.0;
    let (mut low, mut high) = (left.x, right.x);
    // The secant: between two extremes the first Newton step may lead anywhere.
    let mut x = low - (high - low) * (left.value / (right.value - left.value));
    let mut last_step = high - low;
    // Bisection alone would take some thousand steps at most, from any bracket.
    for _ in 0..2_000 {
        let (value, slope) = curve.at(x);
        if value == 0.0 {
            return x;
        }
        if (value > 0.0) == rising {
            high = x;
        } else {
            low = x;
        }
        let newton = x - value / slope;
        // At a multiple root Newton's steps only shrink by a constant factor; bisection halves.
        let slow = (newton - x).abs() > 0.5 * last_step;
        // NaN, from a slope of 0, fails the comparisons and leads to bisection.
        let next = if slow || !(newton > low && newton < high) {
            low + (high - low) / 2.0
        } else {
            newton
        };
        last_step = (next - x).abs();
        if last_step <= f64::EPSILON * x.abs() || next <= low || next >= high {
            return next;
        }
        x = next;
    }
    x
}
