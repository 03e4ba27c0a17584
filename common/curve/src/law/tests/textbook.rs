//! Values and derivatives of every law against its definition.

use super::super::{MotionLaw, Segment, Turn};
use super::reference::{
    Reference, bestehorn, harmonic_combination, modified_sine, pulse, quadrature, sinuslinie,
    smooth_harmonic_combination, trapezoid, trapezoid_to_turn,
};
use super::{knot, unit, values};

/// Relative to the greatest value of the law.
const TOLERANCE: f64 = 1e-12;

/// Returns places evenly spread, with joints, ends and places close to both ends.
fn places() -> impl Iterator<Item = f64> {
    (0..=256)
        .map(|k| f64::from(k) / 256.0)
        // Beside the ends and the middle, where formulas change from one end to the other.
        .chain([1e-9, 1e-3, 0.49999, 0.50001, 0.999, 1.0 - 1e-9])
}

fn assert_equal(segment: &Segment, z: f64, expected: [f64; 4], magnitude: [f64; 4]) {
    let received = values(&segment.at(z));
    for order in 0..4 {
        let difference = (received[order] - expected[order]).abs();
        assert!(
            difference <= TOLERANCE * magnitude[order],
            "derivative {order} at {z}: {} instead of {}",
            received[order],
            expected[order],
        );
    }
}

fn magnitudes(segment: &Segment) -> [f64; 4] {
    let extremes = segment.extremes();
    [
        extremes.position.magnitude(),
        extremes.velocity.magnitude(),
        extremes.acceleration.magnitude(),
        extremes.jerk.magnitude(),
    ]
}

/// The polynomials from rest to rest, lowest power first.
pub(super) const POLYNOMIALS: [(MotionLaw, &[i128]); 9] = [
    (MotionLaw::Polynom1, &[0, 1]),
    (MotionLaw::Polynom3, &[0, 0, 3, -2]),
    (MotionLaw::Polynom5, &[0, 0, 0, 10, -15, 6]),
    (MotionLaw::Polynom7, &[0, 0, 0, 0, 35, -84, 70, -20]),
    (MotionLaw::Polynom8, &[0, 0, 0, 0, 70, -224, 280, -160, 35]),
    (
        MotionLaw::Polynom9,
        &[0, 0, 0, 0, 0, 126, -420, 540, -315, 70],
    ),
    (
        MotionLaw::Polynom11,
        &[0, 0, 0, 0, 0, 0, 462, -1980, 3465, -3080, 1386, -252],
    ),
    (
        MotionLaw::Peisekah11,
        &[0, 0, 0, 0, 0, 336, -1890, 4740, -6615, 5320, -2310, 420],
    ),
    (MotionLaw::Polynom5Mm, &[0, 0, 0, 10, -15, 6]),
];

/// Returns the value and three derivatives at k/1024, in whole numbers: only the last division rounds.
pub(super) fn exact(coefficients: &[i128], k: i128) -> [f64; 4] {
    let degree = coefficients.len() as u32 - 1;
    core::array::from_fn(|order| {
        let order = order as u32;
        let numerator: i128 = (order..=degree)
            .map(|power| {
                // The derivative of zⁿ of order k has the factor n(n − 1)…(n − k + 1).
                let falling: i128 = (0..order).map(|i| i128::from(power - i)).product();
                let rest = k.pow(power - order) * 1024_i128.pow(degree - power);
                coefficients[power as usize] * falling * rest
            })
            .sum();
        numerator as f64 / 1024_f64.powi(degree as i32 - order as i32)
    })
}

#[test]
fn polynomials_agree_with_whole_numbers() {
    for (law, coefficients) in POLYNOMIALS {
        let segment = unit(law, [0.0; 2]);
        let mut magnitude = magnitudes(&segment);
        // Lines and parabolas have no such derivative to compare with.
        magnitude.iter_mut().for_each(|m| *m = m.max(1.0));
        for k in 0..=1024 {
            assert_equal(
                &segment,
                f64::from(k) / 1024.0,
                exact(coefficients, k.into()),
                magnitude,
            );
        }
    }
}

/// Near its ends a law of high degree keeps all digits even of its smallest positions.
#[test]
fn high_degrees_are_precise_near_the_ends() {
    for (law, coefficients) in &POLYNOMIALS[4..8] {
        let segment = unit(*law, [0.0; 2]);
        for k in 1..=16 {
            let expected = exact(coefficients, k)[0];
            let received = segment.at(k as f64 / 1024.0).position;
            // Relative to the position itself, down to 462/1024⁶ of the
            // stroke: evaluated from the far end it would be noise.
            assert!((received - expected).abs() <= 1e-14 * expected);
        }
    }
}

fn assert_is(segment: &Segment, reference: &Reference) {
    let magnitude = magnitudes(segment);
    for z in places() {
        assert_equal(segment, z, reference.at(z), magnitude);
    }
}

#[test]
fn trigonometric_laws_agree_with_their_integrals() {
    assert_is(&unit(MotionLaw::Sinuslinie, [0.0; 2]), &sinuslinie());
    assert_is(&unit(MotionLaw::Bestehorn, [0.0; 2]), &bestehorn());
    assert_is(&unit(MotionLaw::Modsinuslinie, [0.0; 2]), &modified_sine());
    assert_is(&unit(MotionLaw::Beschltrapez, [0.0; 2]), &trapezoid());
    assert_is(
        &unit(MotionLaw::BeschltrapezRt, [0.0; 2]),
        &trapezoid_to_turn(),
    );
}

#[test]
fn the_trapezoid_to_a_velocity_is_pulse_and_trapezoid() {
    let (pulse, trapezoid) = (pulse(), trapezoid());
    for velocity in [-3.0, 0.0, 0.5, 1.0, 2.0, 5.0] {
        let segment = unit(MotionLaw::BeschltrapezRv, [0.0, velocity]);
        let magnitude = magnitudes(&segment);
        for z in places() {
            let (p, t) = (pulse.at(z), trapezoid.at(z));
            // The pulse of stroke 1 ends at velocity 2.
            let share = 0.5 * velocity;
            let expected = core::array::from_fn(|i| share * p[i] + (1.0 - share) * t[i]);
            assert_equal(&segment, z, expected, magnitude);
        }
    }
}

#[test]
fn the_modified_sine_leads_between_velocities() {
    let sine = modified_sine();
    for [v0, v1] in [[0.5, 1.5], [1.0, 0.0], [-2.0, 3.0], [0.0, 0.0], [1.0, 1.0]] {
        let segment = unit(MotionLaw::ModsinuslinieVv, [v0, v1]);
        let magnitude = magnitudes(&segment);
        // The stroke beyond that of the mean velocity.
        let bell = 1.0 - 0.5 * (v0 + v1);
        for z in places() {
            let [m, m1, m2, m3] = sine.at(z);
            let joints = sine.joints();
            let integral: f64 = joints
                .windows(2)
                .map(|piece| quadrature(piece[0].min(z), piece[1].min(z), |x| sine.at(x)[0]))
                .sum();
            let expected = [
                v0 * z + (v1 - v0) * integral + bell * m,
                v0 + (v1 - v0) * m + bell * m1,
                (v1 - v0) * m1 + bell * m2,
                (v1 - v0) * m2 + bell * m3,
            ];
            assert_equal(&segment, z, expected, magnitude);
        }
    }
}

#[test]
fn harmonic_combinations_have_continuous_jerk() {
    let rt = unit(MotionLaw::HarmonicKombiRt, [0.0; 2]);
    assert_is(&rt, &smooth_harmonic_combination(0.0, [0.1, 0.9]));
    let vt = |velocity| unit(MotionLaw::HarmonicKombiVt, [velocity, 0.0]);
    for velocity in [0.01, 0.5, 1.0, 1.5] {
        // The joint is at 2 − √2 = 0.586 from rest, and lower for any velocity towards the end.
        let reference = smooth_harmonic_combination(velocity, [1e-3, 0.59]);
        assert_is(&vt(velocity), &reference);
    }
    // Backwards at first, or so fast that the slave overshoots and returns.
    for velocity in [-0.1, -2.0, 2.5, 8.0] {
        // Backwards, or above twice the mean velocity, the joint lies beyond 0.586.
        let reference = smooth_harmonic_combination(velocity, [0.58, 0.999]);
        assert_is(&vt(velocity), &reference);
    }
}

#[test]
fn harmonic_combinations_turn_where_they_are_told() {
    let start = knot(0.0, [0.0, 0.8, 0.0, 0.0]);
    let end = knot(1.0, [1.0, 0.0, 0.0, 0.0]);
    for share in [0.05, 0.3, 0.5, 0.9] {
        let turn = Turn::At(share);
        let segment = Segment::with_turn(MotionLaw::HarmonicKombiVt, &start, &end, turn).unwrap();
        assert_is(&segment, &harmonic_combination(0.8, share));

        let told = segment.at(1.0).acceleration;
        let turn = Turn::Acceleration(told);
        let same = Segment::with_turn(MotionLaw::HarmonicKombiVt, &start, &end, turn).unwrap();
        assert!((same.at(1.0).acceleration - told).abs() <= 1e-12 * told.abs());
        for z in places() {
            assert!((same.at(z).position - segment.at(z).position).abs() <= 1e-12);
        }
    }
}
