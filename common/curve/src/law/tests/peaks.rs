//! Peak factors: against the printed ones, and against a search over the definitions.

use super::super::MotionLaw;
use super::reference::{
    Reference, bestehorn, modified_sine, sinuslinie, smooth_harmonic_combination, trapezoid,
    trapezoid_to_turn,
};
use super::textbook::POLYNOMIALS;
use super::unit;

/// Law, velocities of its `V` ends, and the peaks of velocity, acceleration and jerk as printed.
const PRINTED: [(MotionLaw, [f64; 2], [&str; 3]); 22] = [
    (MotionLaw::Polynom1, [0.0, 0.0], ["1", "0", "0"]),
    (MotionLaw::Polynom3, [0.0, 0.0], ["1.5", "6", "12"]),
    (MotionLaw::Polynom5, [0.0, 0.0], ["1.875", "5.7735", "60"]),
    (
        MotionLaw::Polynom7,
        [0.0, 0.0],
        ["2.1875", "7.5132", "52.5"],
    ),
    (
        MotionLaw::Polynom8,
        [0.0, 0.0],
        ["2.3500", "9.4033", "67.93"],
    ),
    (
        MotionLaw::Polynom9,
        [0.0, 0.0],
        ["2.4609", "9.3720", "78.75"],
    ),
    (
        MotionLaw::Polynom11,
        [0.0, 0.0],
        ["2.7070", "11.2666", "108.28"],
    ),
    (
        MotionLaw::Peisekah11,
        [0.0, 0.0],
        ["2.0508", "7.9100", "56.93"],
    ),
    (
        MotionLaw::Sinuslinie,
        [0.0, 0.0],
        ["1.5708", "4.9348", "15.50"],
    ),
    (MotionLaw::Bestehorn, [0.0, 0.0], ["2", "6.2832", "39.478"]),
    (
        MotionLaw::Modsinuslinie,
        [0.0, 0.0],
        ["1.7596", "5.5280", "69.466"],
    ),
    (
        MotionLaw::Beschltrapez,
        [0.0, 0.0],
        ["2", "4.8881", "61.426"],
    ),
    (
        MotionLaw::HarmonicKombiRt,
        [0.0, 0.0],
        ["1.7967", "6.8133", "25.84"],
    ),
    (
        MotionLaw::HarmonicKombiTr,
        [0.0, 0.0],
        ["1.7967", "6.8133", "25.84"],
    ),
    (
        MotionLaw::HarmonicKombiVt,
        [1.0, 0.0],
        ["1.3628", "3.7029", "10.06"],
    ),
    (
        MotionLaw::HarmonicKombiTv,
        [0.0, 1.0],
        ["1.3628", "3.7029", "10.06"],
    ),
    (
        MotionLaw::BeschltrapezRt,
        [0.0, 0.0],
        ["1.9133", "4.4639", "53.55"],
    ),
    (
        MotionLaw::BeschltrapezTr,
        [0.0, 0.0],
        ["1.9133", "4.4639", "53.55"],
    ),
    (
        MotionLaw::ModsinuslinieVv,
        [0.5, 1.5],
        ["1.5", "1.7596", "5.528"],
    ),
    (
        MotionLaw::BeschltrapezRv,
        [0.0, 1.0],
        ["1.5249", "3.6661", "38.39"],
    ),
    (
        MotionLaw::BeschltrapezVr,
        [1.0, 0.0],
        ["1.5249", "3.6661", "38.39"],
    ),
    (
        MotionLaw::Polynom7Mm,
        [0.0, 0.0],
        ["2.1875", "7.5132", "52.5"],
    ),
];

fn peaks(law: MotionLaw, velocities: [f64; 2]) -> [f64; 3] {
    let extremes = unit(law, velocities).extremes();
    [
        extremes.velocity.magnitude(),
        extremes.acceleration.magnitude(),
        extremes.jerk.magnitude(),
    ]
}

#[test]
fn peak_factors_are_the_printed_ones() {
    for (law, velocities, printed) in PRINTED {
        for (received, printed) in peaks(law, velocities).into_iter().zip(printed) {
            let digits = printed
                .split_once('.')
                .map_or(0, |(_, digits)| digits.len());
            let last_digit = 10_f64.powi(-(digits as i32));
            let expected: f64 = printed.parse().unwrap();
            assert!(
                // Half of the last printed digit, and a little for its rounding in binary.
                (received - expected).abs() <= 0.51 * last_digit,
                "{law:?}: {received} instead of {printed}"
            );
        }
    }
}

#[test]
fn peak_factors_are_those_of_the_definitions() {
    let laws = [
        (MotionLaw::Sinuslinie, [0.0; 2], sinuslinie()),
        (MotionLaw::Bestehorn, [0.0; 2], bestehorn()),
        (MotionLaw::Modsinuslinie, [0.0; 2], modified_sine()),
        (MotionLaw::Beschltrapez, [0.0; 2], trapezoid()),
        (MotionLaw::BeschltrapezRt, [0.0; 2], trapezoid_to_turn()),
        (
            MotionLaw::HarmonicKombiRt,
            [0.0; 2],
            smooth_harmonic_combination(0.0, [0.1, 0.9]),
        ),
        (
            MotionLaw::HarmonicKombiVt,
            [1.0, 0.0],
            smooth_harmonic_combination(1.0, [0.1, 0.59]),
        ),
    ];
    for (law, velocities, reference) in laws {
        let joints = reference.joints();
        assert_peaks(law, velocities, &joints, |z| reference.at(z));
    }
}

#[test]
fn peak_factors_of_polynomials_are_those_of_their_powers() {
    for (law, coefficients) in &POLYNOMIALS[1..] {
        let by_powers = |z: f64| {
            let value = |order: usize| -> f64 {
                let terms = coefficients.iter().enumerate().skip(order);
                terms
                    .map(|(power, &c)| {
                        let falling: i128 = (0..order).map(|i| (power - i) as i128).product();
                        (c * falling) as f64 * z.powi((power - order) as i32)
                    })
                    .sum()
            };
            core::array::from_fn(value)
        };
        // The first half only, where few digits cancel. All but POLYNOM8 are symmetric.
        if *law != MotionLaw::Polynom8 {
            assert_peaks(*law, [0.0; 2], &[0.0, 0.5], by_powers);
        }
    }
    // v' = 0 at z = 3/7, a' = 0 at 7z = 3 ± √2: in closed form.
    // Derivatives of 70z⁴ − 224z⁵ + 280z⁶ − 160z⁷ + 35z⁸, factored: no digits cancel.
    let v = |z: f64| 280.0 * z.powi(3) * (1.0 - z).powi(4);
    let a = |z: f64| 280.0 * z.powi(2) * (1.0 - z).powi(3) * (3.0 - 7.0 * z);
    let [cv, ca, _] = peaks(MotionLaw::Polynom8, [0.0; 2]);
    assert!((cv / v(3.0 / 7.0) - 1.0).abs() <= 1e-12);
    assert!((ca / a((3.0 - 2_f64.sqrt()) / 7.0) - 1.0).abs() <= 1e-12);
}

/// Searches each stretch between joints for the largest magnitudes.
fn assert_peaks(
    law: MotionLaw,
    velocities: [f64; 2],
    joints: &[f64],
    definition: impl Fn(f64) -> [f64; 4],
) {
    for (index, received) in peaks(law, velocities).into_iter().enumerate() {
        let magnitude = |z: f64| definition(z)[index + 1].abs();
        let expected = joints
            .windows(2)
            // A joint belongs to the next piece, where the jerk already has its other value.
            .map(|stretch| largest(stretch[0], stretch[1].next_down(), magnitude))
            .fold(0.0, f64::max);
        assert!(
            (received - expected).abs() <= 1e-12 * expected,
            "{law:?}: {received} instead of {expected}"
        );
    }
}

/// Returns the best of a grid, then narrowed down by thirds.
fn largest(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const GRID: i32 = 64;
    let place = |k: i32| from + (to - from) * f64::from(k) / f64::from(GRID);
    let best = (0..=GRID)
        .max_by(|&a, &b| f(place(a)).total_cmp(&f(place(b))))
        .unwrap();
    let (mut low, mut high) = (place((best - 1).max(0)), place((best + 1).min(GRID)));
    // Two thirds are left per step: (2/3)¹⁰⁰ is below the resolution of the place.
    for _ in 0..100 {
        let third = (high - low) / 3.0;
        if f(low + third) < f(high - third) {
            low += third;
        } else {
            high -= third;
        }
    }
    [from, to, low, high].into_iter().map(f).fold(0.0, f64::max)
}

/// The comparison above must be able to fail.
#[test]
fn another_definition_has_other_peaks() {
    // Without the last ramp the stroke, and so every scaled amplitude, is another one.
    let wrong = Reference::of_shape(&trapezoid().pieces[..4]);
    let received = peaks(MotionLaw::Beschltrapez, [0.0; 2])[1];
    assert!((received - wrong.at(0.2)[2]).abs() > 1e-3);
}
