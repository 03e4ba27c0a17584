//! Laws by their textbook definition: an acceleration in pieces, integrated numerically.
//!
//! Nothing here shares a formula with the laws: positions and velocities come from Gauss-Legendre
//! quadrature, amplitudes from a system of equations.

use std::sync::LazyLock;
use std::vec::Vec;

use core::f64::consts::{FRAC_PI_2, PI};

/// amplitude·sin(omega·z + phase) up to `until`; constant with omega = 0.
#[derive(Clone, Copy)]
pub(super) struct Sine {
    pub(super) until: f64,
    pub(super) amplitude: f64,
    pub(super) omega: f64,
    pub(super) phase: f64,
}

pub(super) const fn sine(until: f64, amplitude: f64, omega: f64, phase: f64) -> Sine {
    Sine {
        until,
        amplitude,
        omega,
        phase,
    }
}

pub(super) const fn flat(until: f64, amplitude: f64) -> Sine {
    // A sine that stays at its peak.
    sine(until, amplitude, 0.0, FRAC_PI_2)
}

/// A motion from position 0 at z = 0, by its start velocity and its acceleration.
#[derive(Clone)]
pub(super) struct Reference {
    pub(super) velocity: f64,
    pub(super) pieces: Vec<Sine>,
}

impl Reference {
    /// Makes a law from rest, its amplitudes scaled to a stroke of 1.
    pub(super) fn of_shape(pieces: &[Sine]) -> Self {
        let shape = Self::from_rest(pieces);
        let stroke = shape.at(1.0)[0];
        shape.scaled(1.0 / stroke)
    }

    fn from_rest(pieces: &[Sine]) -> Self {
        Self {
            velocity: 0.0,
            pieces: pieces.to_vec(),
        }
    }

    fn scaled(mut self, factor: f64) -> Self {
        self.velocity *= factor;
        for piece in &mut self.pieces {
            piece.amplitude *= factor;
        }
        self
    }

    /// Returns the position, velocity, acceleration and jerk.
    pub(super) fn at(&self, z: f64) -> [f64; 4] {
        let [position, velocity] = self.integrals(z);
        let piece = self.piece_at(z);
        let angle = piece.omega * z + piece.phase;
        [
            self.velocity * z + position,
            self.velocity + velocity,
            piece.amplitude * angle.sin(),
            piece.amplitude * piece.omega * angle.cos(),
        ]
    }

    /// Begins and ends of the pieces.
    pub(super) fn joints(&self) -> Vec<f64> {
        core::iter::once(0.0)
            .chain(self.pieces.iter().map(|piece| piece.until))
            .collect()
    }

    fn piece_at(&self, z: f64) -> Sine {
        let inside = self.pieces.iter().find(|piece| z < piece.until);
        *inside.or(self.pieces.last()).unwrap()
    }

    /// Returns ∫(z − x)·a(x) dx and ∫a(x) dx from 0 to z.
    fn integrals(&self, z: f64) -> [f64; 2] {
        let mut from = 0.0;
        let mut sums = [0.0; 2];
        for piece in &self.pieces {
            let to = piece.until.min(z);
            let a = |x: f64| piece.amplitude * (piece.omega * x + piece.phase).sin();
            // Cauchy's formula for repeated integration: one integral instead of two nested ones.
            sums[0] += quadrature(from, to, |x| (z - x) * a(x));
            sums[1] += quadrature(from, to, a);
            from = to;
        }
        sums
    }
}

pub(super) fn sinuslinie() -> Reference {
    Reference::of_shape(&[sine(1.0, 1.0, PI, FRAC_PI_2)])
}

pub(super) fn bestehorn() -> Reference {
    Reference::of_shape(&[sine(1.0, 1.0, 2.0 * PI, 0.0)])
}

pub(super) fn modified_sine() -> Reference {
    Reference::of_shape(&[
        sine(0.125, 1.0, 4.0 * PI, 0.0),
        sine(0.875, 1.0, 4.0 * PI / 3.0, PI / 3.0),
        sine(1.0, 1.0, 4.0 * PI, 0.0),
    ])
}

pub(super) fn trapezoid() -> Reference {
    Reference::of_shape(&[
        sine(0.125, 1.0, 4.0 * PI, 0.0),
        flat(0.375, 1.0),
        sine(0.625, -1.0, 4.0 * PI, 0.0),
        flat(0.875, -1.0),
        sine(1.0, 1.0, 4.0 * PI, 0.0),
    ])
}

/// Makes the rising half of the trapezoid over the whole length.
pub(super) fn pulse() -> Reference {
    Reference::of_shape(&[
        sine(0.25, 1.0, 2.0 * PI, 0.0),
        flat(0.75, 1.0),
        sine(1.0, -1.0, 2.0 * PI, 0.0),
    ])
}

/// Makes the trapezoid that ends turning, its ramp found by bisection for a velocity of zero there.
pub(super) fn trapezoid_to_turn() -> Reference {
    let shape = |b: f64| {
        let omega = FRAC_PI_2 / b;
        [
            sine(b, 1.0, omega, 0.0),
            flat(3.0 * b, 1.0),
            sine(5.0 * b, 1.0, omega, FRAC_PI_2 - 3.0 * b * omega),
            flat(1.0, -1.0),
        ]
    };
    let last_velocity = |b: f64| Reference::from_rest(&shape(b)).at(1.0)[1];
    // Five ramps of b fit for b < 0.2.
    Reference::of_shape(&shape(bisected(0.05, 0.19, last_velocity)))
}

/// Makes half a sine and a quarter sine, the amplitudes such that the stroke is 1 and the velocity at
/// the end zero.
pub(super) fn harmonic_combination(velocity: f64, lambda: f64) -> Reference {
    let mu = 1.0 - lambda;
    let with = |velocity: f64, a: f64, b: f64| Reference {
        velocity,
        pieces: [
            sine(lambda, a, PI / lambda, 0.0),
            sine(1.0, -b, FRAC_PI_2 / mu, -FRAC_PI_2 * lambda / mu),
        ]
        .to_vec(),
    };
    let [half, quarter] = [with(0.0, 1.0, 0.0).at(1.0), with(0.0, 0.0, 1.0).at(1.0)];
    let (position, speed) = (1.0 - velocity, -velocity);
    // Stroke and end velocity are linear in both amplitudes: two equations, by Cramer's rule.
    let determinant = half[0] * quarter[1] - half[1] * quarter[0];
    let a = (position * quarter[1] - speed * quarter[0]) / determinant;
    let b = (half[0] * speed - half[1] * position) / determinant;
    with(velocity, a, b)
}

/// Makes the harmonic combination with continuous jerk, its joint found by bisection.
pub(super) fn smooth_harmonic_combination(velocity: f64, range: [f64; 2]) -> Reference {
    let jump = |lambda: f64| {
        let pieces = harmonic_combination(velocity, lambda).pieces;
        let before = -pieces[0].amplitude * pieces[0].omega;
        // The half sine arrives at its zero with slope −Aω, the quarter sine leaves it with its own.
        before - pieces[1].amplitude * pieces[1].omega
    };
    harmonic_combination(velocity, bisected(range[0], range[1], jump))
}

fn bisected(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let at_low = f(low).signum();
    assert_ne!(at_low, f(high).signum());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle).signum() == at_low {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

// Exact up to degree 47. The terms of a sine over half a period are far below rounding there.
const NODES: usize = 24;

static RULE: LazyLock<[(f64, f64); NODES]> =
    LazyLock::new(|| core::array::from_fn(|index| legendre_node(NODES, index)));

/// Integrates by Gauss-Legendre quadrature: exact to rounding for half a period of a sine.
pub(super) fn quadrature(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let term = |&(node, weight): &(f64, f64)| weight * half * f(middle + half * node);
    RULE.iter().map(term).sum()
}

/// Returns a root of the Legendre polynomial of a degree, and its weight, by Newton's method.
fn legendre_node(degree: usize, index: usize) -> (f64, f64) {
    let n = degree as f64;
    // The usual first guess, near enough for Newton's method to stay at this root.
    let mut x = (PI * (index as f64 + 0.75) / (n + 0.5)).cos();
    let mut slope = 0.0;
    for _ in 0..8 {
        let (mut before, mut value) = (1.0, x);
        for k in 2..=degree {
            let k = k as f64;
            (before, value) = (
                value,
                ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k,
            );
        }
        slope = n * (x * value - before) / (x * x - 1.0);
        x -= value / slope;
    }
    // Abramowitz and Stegun, 25.4.29.
    (x, 2.0 / ((1.0 - x * x) * slope * slope))
}
