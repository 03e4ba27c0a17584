//! A piece of the slave's path: a polynomial in the master's position, or in time.

use coaxle_curve::law::polynom::quintic;
use coaxle_curve::law::polynomial::Polynomial;
use coaxle_curve::law::{MinMax, Motion, MotionLaw};

/// Path of the slave from its position at `begin`, as a polynomial of `x`, which runs from 0 to 1 while
/// the master (or the time) runs from `begin` over the signed `length`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathPiece {
    pub(super) begin: f64,
    pub(super) length: f64,
    pub(super) position: f64,
    /// Counted from `position`: far from zero a position has few digits left for differences.
    pub(super) displacement: Polynomial<6>,
}

impl PathPiece {
    /// Makes P1: a constant slope.
    pub(super) fn line(begin: f64, length: f64, position: f64, slope: f64) -> Self {
        Self::new(
            begin,
            length,
            position,
            [0.0, slope * length, 0.0, 0.0, 0.0, 0.0],
        )
    }

    /// Makes P5 where it degenerates to a ramp: the slope goes from one value to another along
    /// 3x² − 2x³, without curvature at either end.
    pub(super) fn ramp(begin: f64, length: f64, position: f64, from: f64, to: f64) -> Self {
        let rise = (to - from) * length;
        Self::new(
            begin,
            length,
            position,
            [0.0, from * length, 0.0, rise, -rise / 2.0, 0.0],
        )
    }

    /// Makes P5 as a ramp with a start curvature: the slope is the cubic that meets slope and curvature
    /// at both ends.
    pub(super) fn curved_ramp(
        begin: f64,
        length: f64,
        position: f64,
        (from, curvature): (f64, f64),
        to: f64,
    ) -> Self {
        let bend = curvature * length * length;
        let rise = (to - from) * length;
        // The integral of the Hermite cubic: slope `from`
        // with derivative `bend`, to slope `to` without one.
        let displacement = [
            0.0,
            from * length,
            bend / 2.0,
            rise - 2.0 / 3.0 * bend,
            bend / 4.0 - rise / 2.0,
            0.0,
        ];
        Self::new(begin, length, position, displacement)
    }

    /// Makes P5, from slope and curvature over `distance` to the slope `to` without curvature.
    pub(super) fn quintic(
        begin: f64,
        length: f64,
        (position, from, curvature): (f64, f64, f64),
        (distance, to): (f64, f64),
    ) -> Self {
        // Derivatives over the share of the length.
        let start = Motion {
            velocity: from * length,
            acceleration: curvature * length * length,
            ..Motion::default()
        };
        let end = Motion {
            position: distance,
            velocity: to * length,
            ..Motion::default()
        };
        // From 0, not from the position: far away a displacement would lose its digits.
        Self::new(begin, length, position, quintic(&start, &end).0)
    }

    /// Makes a piece of constant jerk, over time.
    pub(super) fn phase(
        begin: f64,
        length: f64,
        position: f64,
        (velocity, acceleration, jerk): (f64, f64, f64),
    ) -> Self {
        let displacement = [
            0.0,
            velocity * length,
            acceleration / 2.0 * length * length,
            jerk / 6.0 * length * length * length,
            0.0,
            0.0,
        ];
        Self::new(begin, length, position, displacement)
    }

    /// Returns this course over another range of the master (or the time).
    pub(super) const fn over_range(self, begin: f64, length: f64) -> Self {
        Self {
            begin,
            length,
            ..self
        }
    }

    fn new(begin: f64, length: f64, position: f64, displacement: [f64; 6]) -> Self {
        Self {
            begin,
            length,
            position,
            displacement: Polynomial(displacement),
        }
    }

    /// Returns the position of the slave at its begin.
    pub(super) const fn position(&self) -> f64 {
        self.position
    }

    /// Returns the end of the piece.
    pub(super) fn end(&self) -> f64 {
        self.begin + self.length
    }

    /// True if the master has passed its end.
    pub(super) fn is_passed_by(&self, master: f64) -> bool {
        // The sign of the length is the direction of the master.
        (master - self.end()) * self.length > 0.0
    }

    /// Returns the displacement of the slave from begin to end.
    pub(super) fn distance(&self) -> f64 {
        self.displacement.0.iter().sum()
    }

    /// True if all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        let numbers = [self.begin, self.length, self.position];
        numbers
            .iter()
            .chain(&self.displacement.0)
            .all(|n| n.is_finite())
    }

    /// Returns the slave's position and its derivatives with respect to the master (or time). The
    /// polynomial continues beyond its ends.
    pub(super) fn at(&self, master: f64) -> Motion {
        let x = (master - self.begin) / self.length;
        let [displacement, first, second, third] = self.displacement.derivatives(x);
        let inverse = 1.0 / self.length;
        Motion {
            position: self.position + displacement,
            velocity: first * inverse,
            acceleration: second * inverse * inverse,
            jerk: third * inverse * inverse * inverse,
        }
    }

    /// Returns the total path length of the slave, forwards and backwards.
    pub(super) fn path(&self) -> f64 {
        let velocity = self.displacement.derivative();
        let turns = velocity.roots_in(0.0, 1.0);
        let mut from = 0.0;
        let mut path = 0.0;
        for &to in turns.iter().chain(core::iter::once(&1.0)) {
            // Between two turns the slave moves one way, so the difference is the distance.
            path += (self.displacement.derivatives(to)[0] - self.displacement.derivatives(from)[0])
                .abs();
            from = to;
        }
        path
    }

    /// Returns the integral over time of the squared acceleration.
    pub(super) fn squared_acceleration(&self, master_velocity: f64) -> f64 {
        let acceleration = self.displacement.derivative().derivative();
        let terms = &acceleration.0[..4];
        let mut integral = 0.0;
        for (i, a) in terms.iter().enumerate() {
            for (j, b) in terms.iter().enumerate() {
                // ∫ xⁱ·xʲ dx from 0 to 1 is 1/(i + j + 1).
                integral += a * b / (i + j + 1) as f64;
            }
        }
        // The square has the rate to the fourth, dt = dx/rate takes one away.
        integral * cube(master_velocity / self.length)
    }

    /// Returns the minimum and maximum product of velocity and acceleration.
    pub(super) fn dynamic_moment(&self, master_velocity: f64) -> MinMax {
        let velocity = self.displacement.derivative();
        let acceleration = velocity.derivative();
        let mut product = Polynomial([0.0; 8]);
        // Degrees 4 and 3, so 7 at most: eight coefficients.
        for (i, v) in velocity.0[..5].iter().enumerate() {
            for (j, a) in acceleration.0[..4].iter().enumerate() {
                product.0[i + j] += v * a;
            }
        }
        let turns = product.derivative().roots_in(0.0, 1.0);
        self.range(&product, &turns, cube(master_velocity / self.length))
    }

    /// Returns the motion law of the piece, as a segment of a cam.
    pub(super) fn law(&self) -> MotionLaw {
        if self.is_line() {
            MotionLaw::Polynom1
        } else {
            // Every piece has degree 5 at most, and is given by its motion at both ends.
            MotionLaw::Polynom5Mm
        }
    }

    pub(super) fn is_line(&self) -> bool {
        self.displacement.0[2..].iter().all(|&c| c == 0.0)
    }
}

fn cube(x: f64) -> f64 {
    x * x * x
}
