//! The sine laws: simple harmonic, inclined sine (Bestehorn), modified sine. See VDI 2143.

use super::arc::{Angle, Arc, ArcAcceleration, chained, with_unit_stroke};
use super::blend::{BlendPart, BlendedLaw};

/// ½(1 − cos πz).
pub(super) static SINUSLINIE: [Arc; 2] = with_unit_stroke(&[
    ArcAcceleration::quarter(0.5, 0.0, 1.0),
    // Each arc is a quarter turn, whose sine and cosine at the end are exactly 1 and 0.
    ArcAcceleration::quarter(0.5, -1.0, 0.0),
]);

/// z − sin(2πz)/2π.
pub(super) static BESTEHORN: [Arc; 4] = with_unit_stroke(&[
    ArcAcceleration::quarter(0.25, 1.0, 0.0),
    ArcAcceleration::quarter(0.25, 0.0, 1.0),
    ArcAcceleration::quarter(0.25, -1.0, 0.0),
    ArcAcceleration::quarter(0.25, 0.0, -1.0),
]);

/// The acceleration rises over the first eighth, falls over the six in the middle, and rises again.
pub(super) static MODSINUSLINIE: [Arc; 4] = MODIFIED_SINE;

/// The integral of the modified sine: its velocity leads from 0 to 1.
static MODSINUSLINIE_INTEGRAL: [Arc; 4] = integral(&MODIFIED_SINE);

const MODIFIED_SINE: [Arc; 4] = with_unit_stroke(&[
    ArcAcceleration::quarter(0.125, 1.0, 0.0),
    ArcAcceleration::quarter(0.375, 0.0, 1.0),
    ArcAcceleration::quarter(0.375, -1.0, 0.0),
    ArcAcceleration::quarter(0.125, 0.0, -1.0),
]);

/// MODSINUSLINIE_VV: the velocity follows the modified sine from one value to the other, plus a bell for
/// the rest of the stroke.
pub(super) const fn between_velocities(
    start: f64,
    stroke: f64,
    start_velocity: f64,
    end_velocity: f64,
) -> BlendedLaw {
    // The modified sine is symmetric, so the ramp covers the mean of both velocities.
    let mean = 0.5 * (start_velocity + end_velocity);
    let ramp = BlendPart {
        weight: end_velocity - start_velocity,
        arcs: &MODSINUSLINIE_INTEGRAL,
    };
    let bell = BlendPart {
        weight: stroke - mean,
        arcs: &MODSINUSLINIE,
    };
    // Ramp and bell have joints at the same places, as the sum of two laws needs.
    BlendedLaw::new(start, start_velocity, [ramp, bell])
}

/// Returns the antiderivative, from 0, of a law of quarter turns without constant acceleration.
const fn integral<const N: usize>(law: &[Arc; N]) -> [Arc; N] {
    // Its acceleration is the law's velocity.
    let mut accelerations = [ArcAcceleration::constant(0.0, 0.0); N];
    let mut i = 0;
    while i < N {
        let Arc {
            begin,
            omega,
            powers,
            wave,
        } = law[i];
        let end = if i + 1 < N { law[i + 1].begin } else { 1.0 };
        accelerations[i] = ArcAcceleration {
            length: end - begin,
            angle: Angle::QUARTER,
            // Without constant acceleration the law has no square
            // term, so its velocity is a constant plus a wave.
            constant: powers[1],
            wave: wave.derivative(omega),
        };
        i += 1;
    }
    chained(&accelerations, 0.0, 0.0)
}
