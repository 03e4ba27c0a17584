//! The modified acceleration trapezoid: constant acceleration between sine ramps. See VDI 2143.

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_2_PI};

use super::arc::{Angle, Arc, ArcAcceleration, with_unit_stroke};
use super::blend::{BlendPart, BlendedLaw};
use super::wave::AccelerationWave;

/// Ramps of an eighth: up, hold, through zero, hold, up.
pub(super) static BESCHLTRAPEZ: [Arc; 8] = with_unit_stroke(&eighths([
    twice(1.0, 0.0),
    held(1.0),
    held(1.0),
    twice(0.0, 1.0),
    twice(-1.0, 0.0),
    held(-1.0),
    held(-1.0),
    twice(0.0, -1.0),
]));

/// The accelerating half of the trapezoid, stretched: leads from rest to twice the mean velocity.
static PULSE: [Arc; 8] = with_unit_stroke(&eighths([
    once(1.0, 0.0),
    // A quarter sine over two eighths: the angle starts at 45°, so sin(u + 45°) in both amplitudes.
    once(FRAC_1_SQRT_2, FRAC_1_SQRT_2),
    held(1.0),
    held(1.0),
    held(1.0),
    held(1.0),
    once(0.0, 1.0),
    once(-FRAC_1_SQRT_2, FRAC_1_SQRT_2),
]));

/// The ramp of the trapezoid from rest to turn, for which the end velocity is zero.
// Ramps of b add 2b/π three times, one of them negative, and flat parts 2b and −(1 − 5b): zero at the end.
const RAMP: f64 = 1.0 / (7.0 + FRAC_2_PI);

/// The trapezoid without its last ramp: it ends braking.
pub(super) static BESCHLTRAPEZ_RT: [Arc; 5] = with_unit_stroke(&[
    ArcAcceleration::quarter(RAMP, 1.0, 0.0),
    ArcAcceleration::constant(2.0 * RAMP, 1.0),
    ArcAcceleration::quarter(RAMP, 0.0, 1.0),
    ArcAcceleration::quarter(RAMP, -1.0, 0.0),
    ArcAcceleration::constant(1.0 - 5.0 * RAMP, -1.0),
]);

/// BESCHLTRAPEZ_RV: the pulse for the velocity, the trapezoid for the rest of the stroke.
pub(super) const fn to_velocity(start: f64, stroke: f64, end_velocity: f64) -> BlendedLaw {
    let pulse = BlendPart {
        // A pulse of stroke 1 ends at velocity 2.
        weight: 0.5 * end_velocity,
        arcs: &PULSE,
    };
    let trapezoid = BlendPart {
        // The stroke that the pulse leaves; the trapezoid adds no velocity at its end.
        weight: stroke - 0.5 * end_velocity,
        arcs: &BESCHLTRAPEZ,
    };
    BlendedLaw::new(start, 0.0, [pulse, trapezoid])
}

/// Makes eight equal intervals, by constant acceleration and wave. Pulse and trapezoid have them in
/// common, so that they can be added.
const fn eighths(law: [(f64, AccelerationWave); 8]) -> [ArcAcceleration; 8] {
    let mut stretches = [ArcAcceleration::constant(0.125, 0.0); 8];
    let mut i = 0;
    while i < 8 {
        stretches[i].angle = Angle::EIGHTH;
        (stretches[i].constant, stretches[i].wave) = law[i];
        i += 1;
    }
    stretches
}

const fn held(constant: f64) -> (f64, AccelerationWave) {
    (constant, AccelerationWave::NONE)
}

/// Returns an eighth of a turn.
const fn once(sin: f64, cos: f64) -> (f64, AccelerationWave) {
    (0.0, AccelerationWave::new(sin, cos))
}

/// Returns a quarter of a turn: the doubled angle.
const fn twice(sin2: f64, cos2: f64) -> (f64, AccelerationWave) {
    let wave = AccelerationWave {
        sin2,
        cos2,
        ..AccelerationWave::NONE
    };
    (0.0, wave)
}
