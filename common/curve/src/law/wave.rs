//! Sines and cosines of an angle and of its double.

use super::polynomial::Polynomial;
use super::roots::Roots;

/// A wave of the angle u: sines and cosines of u and of 2u, by their amplitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct AccelerationWave {
    pub(super) sin: f64,
    pub(super) cos: f64,
    pub(super) sin2: f64,
    pub(super) cos2: f64,
}

impl AccelerationWave {
    pub(super) const NONE: Self = Self::new(0.0, 0.0);

    pub(super) const fn new(sin: f64, cos: f64) -> Self {
        Self {
            sin,
            cos,
            sin2: 0.0,
            cos2: 0.0,
        }
    }

    pub(super) const fn scaled(&self, factor: f64) -> Self {
        Self {
            sin: factor * self.sin,
            cos: factor * self.cos,
            sin2: factor * self.sin2,
            cos2: factor * self.cos2,
        }
    }

    pub(super) const fn plus(&self, other: &Self) -> Self {
        Self {
            sin: self.sin + other.sin,
            cos: self.cos + other.cos,
            sin2: self.sin2 + other.sin2,
            cos2: self.cos2 + other.cos2,
        }
    }

    /// Returns the derivative with respect to x where u = `omega`·x.
    pub(super) const fn derivative(&self, omega: f64) -> Self {
        Self {
            sin: -omega * self.cos,
            cos: omega * self.sin,
            sin2: -2.0 * omega * self.cos2,
            cos2: 2.0 * omega * self.sin2,
        }
    }

    /// Returns the antiderivative without a constant term.
    pub(super) const fn integral(&self, omega: f64) -> Self {
        Self {
            sin: self.cos / omega,
            cos: -self.sin / omega,
            sin2: self.cos2 / (2.0 * omega),
            cos2: -self.sin2 / (2.0 * omega),
        }
    }

    pub(super) const fn value(&self, sin: f64, cos: f64) -> f64 {
        // Double angles cost no second call of sine and cosine. The product keeps its digits near 45°.
        let (sin2, cos2) = (2.0 * sin * cos, (cos - sin) * (cos + sin));
        self.sin * sin + self.cos * cos + self.sin2 * sin2 + self.cos2 * cos2
    }

    pub(super) fn magnitude(&self) -> f64 {
        self.sin.abs() + self.cos.abs() + self.sin2.abs() + self.cos2.abs()
    }

    /// Returns the angles from 0 to `last` (half a turn at most, exclusively) at which `constant` plus
    /// the wave is zero. With t = tan(u/2) that is a polynomial of degree 4.
    pub(super) fn zeros(&self, constant: f64, last: f64) -> Roots {
        let Self {
            sin,
            cos,
            sin2,
            cos2,
        } = *self;
        Polynomial([
            // sin u = 2t/(1 + t²) and cos u = (1 − t²)/(1 + t²), multiplied by (1 + t²)².
            constant + cos + cos2,
            2.0 * sin + 4.0 * sin2,
            2.0 * constant - 6.0 * cos2,
            2.0 * sin - 4.0 * sin2,
            constant - cos + cos2,
        ])
        .roots_in(0.0, libm::tan(last / 2.0))
        // The tangent grows with u, so places keep their order. Rounding may lead beyond the end.
        .map(|t| (2.0 * libm::atan(t)).min(last))
    }
}
