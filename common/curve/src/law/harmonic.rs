//! The harmonic combinations: half a sine of acceleration, then a quarter sine that brakes into the turn.
//! See VDI 2143.
//!
//! With z = 0..1, the half sine A over the share λ, the quarter sine −B over μ = 1 − λ, a start velocity
//! v and a stroke h, the conditions of zero velocity at the end and of the stroke are Aλ = Bμ − πv/2 and
//! Bμ(πλ + 4μ) = π²(h − vλ/2).

use core::f64::consts::{FRAC_PI_2, PI};

use super::arc::{Arc, ArcAcceleration, Chain, chained};
use super::motion::Motion;
use super::polynomial::Polynomial;

/// Inner turning point of a harmonic combination (HARMONIC_KOMBI), at which its acceleration changes its
/// sign. Other laws have none and ignore it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Turn {
    /// Place with a continuous jerk.
    #[default]
    Default,
    /// Share of the half sine in the segment, between 0 and 1. The half sine lies at the end without the
    /// turn.
    At(f64),
    /// Place at which the slave has this acceleration at the turn, in slave units per squared master
    /// unit.
    Acceleration(f64),
}

/// Half a sine (in two quarters) and a quarter sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Combination([Arc; 3]);

impl Combination {
    /// Starts from a position and velocity, with the half sine over the share `half_sine` (below 1).
    pub(super) fn new(start: &Motion, stroke: f64, half_sine: f64) -> Self {
        let (lambda, mu) = (half_sine, 1.0 - half_sine);
        let velocity = start.velocity;
        // Bμ by the second condition, then B, and A by the first one.
        let braking = PI * PI * (stroke - 0.5 * velocity * lambda) / (PI * lambda + 4.0 * mu);
        let b = braking / mu;
        // A share of 0 leaves the quarter sine alone, which has no half sine to divide by.
        let a = if lambda > 0.0 {
            (braking - FRAC_PI_2 * velocity) / lambda
        } else {
            0.0
        };
        let law = [
            ArcAcceleration::quarter(0.5 * lambda, a, 0.0),
            ArcAcceleration::quarter(0.5 * lambda, 0.0, a),
            ArcAcceleration::quarter(mu, -b, 0.0),
        ];
        Self(chained(&law, start.position, velocity))
    }

    /// Returns the value and derivatives at the share `z` of the segment, with respect to z.
    #[inline]
    pub(super) fn at(&self, z: f64) -> Motion {
        self.0[self.index_at(z)].at(z)
    }
}

impl Chain for Combination {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn arc(&self, index: usize) -> Arc {
        self.0[index]
    }

    #[inline]
    fn index_at(&self, z: f64) -> usize {
        self.0.iter().rposition(|arc| arc.begin <= z).unwrap_or(0)
    }
}

/// Finds the share λ with continuous jerk: A/λ = B/2μ. From rest it is 2 − √2. None exists where
/// 1/2 < h/v < 2/π.
pub(super) fn share_with_continuous_jerk(velocity: f64, stroke: f64) -> Option<f64> {
    // v(λq + λ³/2 + 4μ³/π) = hq with q = 2μ² − λ², by powers of λ.
    let (v, h) = (velocity, stroke);
    Polynomial([
        v * 4.0 / PI - 2.0 * h,
        v * (2.0 - 12.0 / PI) + 4.0 * h,
        v * (12.0 / PI - 4.0) - h,
        v * (1.5 - 4.0 / PI),
    ])
    .roots_in(0.0, 1.0)
    .iter()
    .copied()
    // At 1 the quarter sine would have no length to brake in.
    .find(|&share| share < 1.0)
}

/// Finds the share λ for which the acceleration at the turn is −B.
pub(super) fn share_with_acceleration(velocity: f64, stroke: f64, at_turn: f64) -> Option<f64> {
    // Any sign: a negative stroke turns with a positive acceleration.
    let b = -at_turn;
    // b((4 − π)μ² + πμ) = π²(h − v(1 − μ)/2)
    Polynomial([
        -PI * PI * (stroke - 0.5 * velocity),
        PI * b - 0.5 * PI * PI * velocity,
        (4.0 - PI) * b,
    ])
    .roots_in(0.0, 1.0)
    .iter()
    .map(|mu| 1.0 - mu)
    // Both parts need a length; at either end one of the conditions cannot be kept.
    .find(|&share| 0.0 < share && share < 1.0)
}
