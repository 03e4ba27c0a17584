//! Arcs: pieces of a parabola plus sines, which are chained to the trigonometric laws.

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

use super::motion::{MinMax, Motion};
use super::roots::{LessTarget, Roots, Smooth, roots_between_extremes};
use super::wave::AccelerationWave;

/// Angle of an arc, with its sine and cosine: exact, unlike computed ones.
#[derive(Clone, Copy)]
pub(super) struct Angle {
    radians: f64,
    sin: f64,
    cos: f64,
}

impl Angle {
    /// Zero angle: no wave.
    pub(super) const ZERO: Self = Self::new(0.0, 0.0, 1.0);
    /// 45°.
    pub(super) const EIGHTH: Self = Self::new(FRAC_PI_4, FRAC_1_SQRT_2, FRAC_1_SQRT_2);
    /// 90°.
    pub(super) const QUARTER: Self = Self::new(FRAC_PI_2, 1.0, 0.0);

    const fn new(radians: f64, sin: f64, cos: f64) -> Self {
        Self { radians, sin, cos }
    }
}

/// A piece of an acceleration law: `constant` + `wave`, while its angle turns from 0 by `angle`.
#[derive(Clone, Copy)]
pub(super) struct ArcAcceleration {
    pub(super) length: f64,
    pub(super) angle: Angle,
    pub(super) constant: f64,
    pub(super) wave: AccelerationWave,
}

impl ArcAcceleration {
    /// Makes a quarter turn of a wave.
    pub(super) const fn quarter(length: f64, sin: f64, cos: f64) -> Self {
        Self {
            length,
            angle: Angle::QUARTER,
            constant: 0.0,
            wave: AccelerationWave::new(sin, cos),
        }
    }

    /// Makes a piece of constant acceleration.
    pub(super) const fn constant(length: f64, constant: f64) -> Self {
        Self {
            length,
            angle: Angle::ZERO,
            constant,
            wave: AccelerationWave::NONE,
        }
    }
}

/// A piece of a law: with x = z − `begin` and the angle u = `omega`·x (a quarter turn at most), the
/// position is a parabola of x plus a wave of u.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Arc {
    pub(super) begin: f64,
    pub(super) omega: f64,
    pub(super) powers: [f64; 3],
    pub(super) wave: AccelerationWave,
}

impl Arc {
    /// Returns the value and derivatives at z, with respect to z.
    #[inline]
    pub(super) fn at(&self, z: f64) -> Motion {
        let x = z - self.begin;
        let [p0, p1, p2] = self.powers;
        let parabola = Motion {
            position: p0 + x * (p1 + x * p2),
            velocity: p1 + 2.0 * x * p2,
            acceleration: 2.0 * p2,
            jerk: 0.0,
        };
        // A plain parabola, as in the flat parts of the trapezoid to a turn, needs no sine.
        if self.omega == 0.0 {
            return parabola;
        }
        let (sin, cos) = libm::sincos(self.omega * x);
        let first = self.wave.derivative(self.omega);
        let second = first.derivative(self.omega);
        let third = second.derivative(self.omega);
        Motion {
            position: parabola.position + self.wave.value(sin, cos),
            velocity: parabola.velocity + first.value(sin, cos),
            acceleration: parabola.acceleration + second.value(sin, cos),
            jerk: third.value(sin, cos),
        }
    }

    /// Returns the places from z = `begin` to `end` at which velocity, acceleration, jerk and snap
    /// vanish.
    fn extremes(&self, end: f64) -> [Roots; 4] {
        let second = self.wave.derivative(self.omega).derivative(self.omega);
        let third = second.derivative(self.omega);
        let fourth = third.derivative(self.omega);
        let zeros = |constant: f64, wave: &AccelerationWave| {
            if self.omega == 0.0 {
                return Roots::none();
            }
            let angles = wave.zeros(constant, self.omega * (end - self.begin));
            // Division and sum round, and the place must not lie on the next arc.
            angles.map(|u| (self.begin + u / self.omega).min(end))
        };
        let acceleration = zeros(2.0 * self.powers[2], &second);
        // A line plus a wave has no roots in closed form, unlike a constant plus a wave.
        let velocity = roots_between_extremes(&ArcVelocity(self), &acceleration, self.begin, end);
        [
            velocity,
            acceleration,
            zeros(0.0, &third),
            zeros(0.0, &fourth),
        ]
    }

    /// Returns the extremes of position and derivatives from z = `begin` to `end`.
    fn ranges(&self, end: f64) -> [MinMax; 4] {
        let extremes = self.extremes(end);
        core::array::from_fn(|order| {
            let range = |z: f64| MinMax::at(z, self.derivatives(z)[order]);
            let places = extremes[order].iter().chain(core::iter::once(&end));
            places.fold(range(self.begin), |so_far, &z| so_far.joined(range(z)))
        })
    }

    fn derivatives(&self, z: f64) -> [f64; 4] {
        let motion = self.at(z);
        [
            motion.position,
            motion.velocity,
            motion.acceleration,
            motion.jerk,
        ]
    }
}

/// The velocity of an arc over z.
struct ArcVelocity<'a>(&'a Arc);

impl Smooth for ArcVelocity<'_> {
    fn at(&self, z: f64) -> (f64, f64) {
        let motion = self.0.at(z);
        (motion.velocity, motion.acceleration)
    }

    fn rounding(&self, z: f64) -> f64 {
        let Arc { powers, omega, .. } = self.0;
        let slope = powers[1].abs() + (2.0 * (z - self.0.begin) * powers[2]).abs();
        let wave = self.0.wave.derivative(*omega).magnitude();
        4.0 * f64::EPSILON * (slope + wave)
    }
}

/// Consecutive arcs, from z = 0 to z = 1.
pub(super) trait Chain {
    /// Returns the number of arcs.
    fn len(&self) -> usize;

    /// Returns the arc with an index below [`len`](Self::len).
    fn arc(&self, index: usize) -> Arc;

    /// Returns the index of the arc that z lies on.
    fn index_at(&self, z: f64) -> usize;

    /// Returns the end of an arc.
    fn end_of(&self, index: usize) -> f64 {
        if index + 1 < self.len() {
            self.arc(index + 1).begin
        } else {
            1.0
        }
    }

    /// Returns the extremes of position and derivatives, placed by z.
    fn ranges(&self) -> [MinMax; 4] {
        let first = self.arc(0).ranges(self.end_of(0));
        (1..self.len()).fold(first, |so_far, index| {
            let next = self.arc(index).ranges(self.end_of(index));
            core::array::from_fn(|order| so_far[order].joined(next[order]))
        })
    }

    /// Returns the places z at which the slave reaches a position.
    fn shares_at(&self, position: f64) -> Roots
    where
        Self: Sized,
    {
        let mut extremes = Roots::none();
        for index in 0..self.len() {
            let end = self.end_of(index);
            let [velocity, ..] = self.arc(index).extremes(end);
            velocity.iter().for_each(|&z| extremes.push(z));
            // Joints count as extremes: at each begins another formula.
            extremes.push(end);
        }
        let less_target = LessTarget {
            curve: ArcPosition(self),
            target: position,
        };
        roots_between_extremes(&less_target, &extremes, 0.0, 1.0)
    }
}

/// The position along a chain.
struct ArcPosition<'a, C>(&'a C);

impl<C: Chain> Smooth for ArcPosition<'_, C> {
    fn at(&self, z: f64) -> (f64, f64) {
        let motion = self.0.arc(self.0.index_at(z)).at(z);
        (motion.position, motion.velocity)
    }

    fn rounding(&self, z: f64) -> f64 {
        let arc = self.0.arc(self.0.index_at(z));
        let x = z - arc.begin;
        let [p0, p1, p2] = arc.powers;
        let parabola = p0.abs() + (p1 * x).abs() + (p2 * x * x).abs();
        4.0 * f64::EPSILON * (parabola + arc.wave.magnitude())
    }
}

/// Integrates an acceleration law twice, from `position` and `velocity` at z = 0.
pub(super) const fn chained<const N: usize>(
    law: &[ArcAcceleration; N],
    mut position: f64,
    mut velocity: f64,
) -> [Arc; N] {
    const UNSET: Arc = Arc {
        begin: 0.0,
        omega: 0.0,
        powers: [0.0; 3],
        wave: AccelerationWave::NONE,
    };
    let mut arcs = [UNSET; N];
    let mut begin = 0.0;
    let mut i = 0;
    while i < N {
        let ArcAcceleration {
            length,
            angle,
            constant,
            wave,
        } = law[i];
        // A harmonic combination may have an arc without length.
        let turning = angle.radians > 0.0 && length > 0.0;
        let omega = if turning { angle.radians / length } else { 0.0 };
        let first = if turning {
            wave.integral(omega)
        } else {
            AccelerationWave::NONE
        };
        let zeroth = if turning {
            first.integral(omega)
        } else {
            AccelerationWave::NONE
        };
        let powers = [
            // Continuous at the joint: the wave's own value there, at sine 0 and cosine 1, is taken off.
            position - zeroth.value(0.0, 1.0),
            velocity - first.value(0.0, 1.0),
            constant / 2.0,
        ];
        // By the exact sine and cosine of the angle: joints agree to the last bits.
        position = powers[0]
            + length * (powers[1] + length * powers[2])
            + zeroth.value(angle.sin, angle.cos);
        velocity = powers[1] + 2.0 * length * powers[2] + first.value(angle.sin, angle.cos);
        arcs[i] = Arc {
            begin,
            omega,
            powers,
            wave: zeroth,
        };
        begin += length;
        i += 1;
    }
    arcs
}

/// Makes the law from rest with a stroke of 1 and an acceleration of the given shape.
pub(super) const fn with_unit_stroke<const N: usize>(shape: &[ArcAcceleration; N]) -> [Arc; N] {
    let mut law = *shape;
    // Scaled by its own stroke at compile time, so no amplitude has to be written as a decimal.
    let stroke = stroke(shape);
    let mut i = 0;
    while i < N {
        law[i].constant /= stroke;
        law[i].wave = law[i].wave.scaled(1.0 / stroke);
        i += 1;
    }
    chained(&law, 0.0, 0.0)
}

/// Returns the stroke of an acceleration law from rest.
const fn stroke<const N: usize>(law: &[ArcAcceleration; N]) -> f64 {
    let arcs = chained(law, 0.0, 0.0);
    let ArcAcceleration { length, angle, .. } = law[N - 1];
    let Arc { powers, wave, .. } = arcs[N - 1];
    powers[0] + length * (powers[1] + length * powers[2]) + wave.value(angle.sin, angle.cos)
}
