//! The polynomial laws of degree 8 to 11 from rest to rest.
//!
//! Coefficients of up to 6615 cancel at the far end, which would cost four digits there. So each law is
//! written twice, from either end, and evaluated from the nearer one. The lowest power of each is at
//! least the fourth, which is factored out: few terms, and full relative precision at the ends.

use super::motion::{MinMax, Motion};
use super::polynomial::Polynomial;
use super::roots::{LessTarget, Roots, Smooth, roots_between_extremes};

/// A law from 0 to 1 as z⁴·`start`(z) and as 1 − w⁴·`end`(w), w = 1 − z.
#[derive(Debug, PartialEq)]
pub(super) struct HighDegree {
    start: Polynomial<8>,
    end: Polynomial<8>,
}

impl HighDegree {
    const fn symmetric(coefficients: [f64; 8]) -> Self {
        Self {
            start: Polynomial(coefficients),
            end: Polynomial(coefficients),
        }
    }
}

/// v, a and j vanish at the start; v, a, j and the snap at the end.
pub(super) static POLYNOM8: HighDegree = HighDegree {
    start: Polynomial([70.0, -224.0, 280.0, -160.0, 35.0, 0.0, 0.0, 0.0]),
    end: Polynomial([0.0, 56.0, -140.0, 120.0, -35.0, 0.0, 0.0, 0.0]),
};

/// v, a, j and the snap vanish at both ends.
pub(super) static POLYNOM9: HighDegree =
    HighDegree::symmetric([0.0, 126.0, -420.0, 540.0, -315.0, 70.0, 0.0, 0.0]);

/// The first five derivatives vanish at both ends.
pub(super) static POLYNOM11: HighDegree =
    HighDegree::symmetric([0.0, 0.0, 462.0, -1980.0, 3465.0, -3080.0, 1386.0, -252.0]);

/// Peisekah's law.
pub(super) static PEISEKAH11: HighDegree =
    // Symmetry and the conditions of POLYNOM9 leave one coefficient free
    // at degree 11, chosen for a low acceleration: 7.91 instead of 9.37.
    HighDegree::symmetric([0.0, 336.0, -1890.0, 4740.0, -6615.0, 5320.0, -2310.0, 420.0]);

/// A law of high degree between two positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RestToRest {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) law: &'static HighDegree,
}

impl RestToRest {
    /// Returns the value and derivatives at the share `z` of the segment, with respect to z.
    #[inline]
    pub(super) fn at(&self, z: f64) -> Motion {
        let stroke = self.end - self.start;
        if z <= 0.5 {
            let [position, velocity, acceleration, jerk] = lifted(&self.law.start, z);
            Motion {
                position: self.start + stroke * position,
                velocity: stroke * velocity,
                acceleration: stroke * acceleration,
                jerk: stroke * jerk,
            }
        } else {
            let [position, velocity, acceleration, jerk] = lifted(&self.law.end, 1.0 - z);
            Motion {
                position: self.end - stroke * position,
                velocity: stroke * velocity,
                // Position and z both run backwards, so derivatives of
                // even order change their sign, those of odd order not.
                acceleration: -stroke * acceleration,
                jerk: stroke * jerk,
            }
        }
    }

    /// Returns the extremes of position and derivatives, placed by z.
    pub(super) fn ranges(&self) -> [MinMax; 4] {
        let stroke = self.end - self.start;
        let from_start = expanded(self.start, stroke, &self.law.start).ranges_in(0.0, 0.5);
        let from_end = expanded(self.end, -stroke, &self.law.end).ranges_in(0.0, 0.5);
        core::array::from_fn(|order| {
            // With w = 1 − z, dw/dz is −1: derivatives of odd order change their sign.
            let side = if order % 2 == 0 { 1.0 } else { -1.0 };
            from_start[order].joined(from_end[order].map(side, |w| 1.0 - w))
        })
    }

    /// Returns the shares z at which the slave reaches a position.
    pub(super) fn shares_at(&self, position: f64) -> Roots {
        let less_target = LessTarget {
            curve: *self,
            target: position,
        };
        // The laws never reverse in between.
        roots_between_extremes(&less_target, &[], 0.0, 1.0)
    }
}

impl Smooth for RestToRest {
    fn at(&self, z: f64) -> (f64, f64) {
        let motion = self.at(z);
        (motion.position, motion.velocity)
    }

    fn rounding(&self, z: f64) -> f64 {
        // Rounding counts from the end from which the law is evaluated.
        let anchor = if z <= 0.5 { self.start } else { self.end };
        let offset = self.at(z).position - anchor;
        4.0 * f64::EPSILON * (anchor.abs() + offset.abs())
    }
}

/// Returns the value and three derivatives of x⁴·`rest`(x).
#[inline]
fn lifted(rest: &Polynomial<8>, x: f64) -> [f64; 4] {
    let [r, r1, r2, r3] = rest.derivatives(x);
    let (x2, x3) = (x * x, x * x * x);
    [
        x2 * x2 * r,
        // Product rule; x⁴ and its derivatives 4x³, 12x², 24x are factored out as far as possible.
        x3 * (4.0 * r + x * r1),
        x2 * (12.0 * r + 8.0 * x * r1 + x2 * r2),
        x * (24.0 * r + 36.0 * x * r1 + 12.0 * x2 * r2 + x3 * r3),
    ]
}

/// Returns `offset` + `stroke`·x⁴·`rest`(x).
fn expanded(offset: f64, stroke: f64, rest: &Polynomial<8>) -> Polynomial<12> {
    let mut coefficients = [0.0; 12];
    coefficients[0] = offset;
    for (to, from) in coefficients[4..].iter_mut().zip(rest.0) {
        *to = stroke * from;
    }
    Polynomial(coefficients)
}
