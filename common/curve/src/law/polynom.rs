//! The polynomial laws between points (POLYNOM1 to 7, and those with `M` and `V` ends).
//!
//! The laws are Hermite interpolations: the lowest polynomial with the given derivatives at both ends,
//! over the share z = 0..1 of the segment, so derivatives are with respect to z.

use super::motion::Motion;
use super::polynomial::Polynomial;

/// Makes a straight line.
pub(super) fn line(start: f64, end: f64) -> Polynomial<6> {
    Polynomial([start, end - start, 0.0, 0.0, 0.0, 0.0])
}

/// Makes the polynomial of degree 3: position and velocity at both ends.
pub(super) fn cubic(start: &Motion, end: &Motion) -> Polynomial<6> {
    let c1 = start.velocity;
    // Positions are subtracted first: far from zero, their difference is exact where a sum would round.
    let rise = (end.position - start.position) - c1;
    let speed_up = end.velocity - c1;
    let (c2, c3) = (3.0 * rise - speed_up, speed_up - 2.0 * rise);
    Polynomial([start.position, c1, c2, c3, 0.0, 0.0])
}

/// Makes the polynomial of degree 5: position, velocity and acceleration at both ends.
#[inline]
pub fn quintic(start: &Motion, end: &Motion) -> Polynomial<6> {
    let (c1, c2) = (start.velocity, start.acceleration / 2.0);
    // Remainder at the end after the terms above.
    let d = (end.position - start.position) - c1 - c2;
    let e = end.velocity - c1 - 2.0 * c2;
    let f = end.acceleration - 2.0 * c2;
    Polynomial([
        start.position,
        c1,
        c2,
        // Three equations for c3 to c5 at z = 1: their sum d, Σk·c = e and Σk(k − 1)·c = f.
        10.0 * d - 4.0 * e + 0.5 * f,
        -15.0 * d + 7.0 * e - f,
        6.0 * d - 3.0 * e + 0.5 * f,
    ])
}

/// Makes the polynomial of degree 7: position, velocity, acceleration and jerk at both ends.
pub(super) fn septic(start: &Motion, end: &Motion) -> Polynomial<8> {
    let (c1, c2, c3) = (start.velocity, start.acceleration / 2.0, start.jerk / 6.0);
    // Remainder at the end after the terms above.
    let d = (end.position - start.position) - c1 - c2 - c3;
    let e = end.velocity - c1 - 2.0 * c2 - 3.0 * c3;
    let f = end.acceleration - 2.0 * c2 - 6.0 * c3;
    let g = end.jerk - 6.0 * c3;
    Polynomial([
        start.position,
        c1,
        c2,
        c3,
        // Likewise four equations for c4 to c7. For rest to
        // rest they are the 35, −84, 70, −20 of the textbook.
        35.0 * d - 15.0 * e + 2.5 * f - g / 6.0,
        -84.0 * d + 39.0 * e - 7.0 * f + 0.5 * g,
        70.0 * d - 34.0 * e + 6.5 * f - 0.5 * g,
        -20.0 * d + 10.0 * e - 2.0 * f + g / 6.0,
    ])
}
