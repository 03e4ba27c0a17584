//! Properties of all laws, for any points.

use proptest::prelude::*;

use super::super::{MinMax, MotionLaw, Segment, Turn};
use super::{knot, laws, values};

/// A segment of any law, size and place.
fn segment() -> impl Strategy<Value = Segment> {
    let law = prop::sample::select(laws());
    let numbers = (-1e3..1e3, 1e-2..1e3, -1e3..1e3, -1e2..1e2);
    // In units of the mean slope, so that segments of every size are equally steep at their ends.
    let ends = prop::array::uniform6(-2.0..2.0);
    (law, numbers, ends, 0.1..0.9).prop_map(
        |(law, (master, length, position, stroke), ends, turn): (_, (f64, f64, f64, f64), _, _)| {
            let [v0, a0, j0, v1, a1, j1] = ends;
            let (with_start, with_end) = taken_over(law);
            let slope = stroke / length;
            let [v0, v1] = [v0 * slope, v1 * slope];
            let (with_curve, slope) = (law_takes_curve(law), slope / length);
            let end = |taken: bool, master, position, v: f64, a: f64, j: f64| {
                let v = if taken { v } else { 0.0 };
                let a = if with_curve { a * slope } else { 0.0 };
                knot(master, [position, v, a, j * slope / length])
            };
            let start = end(with_start, master, position, v0, a0, j0);
            let end = end(with_end, master + length, position + stroke, v1, a1, j1);
            Segment::with_turn(law, &start, &end, Turn::At(turn)).unwrap()
        },
    )
}

/// True for each end at which a law takes over the velocity of its point.
fn taken_over(law: MotionLaw) -> (bool, bool) {
    match law {
        MotionLaw::Polynom3Vv
        | MotionLaw::Polynom5Mm
        | MotionLaw::Polynom7Mm
        | MotionLaw::ModsinuslinieVv => (true, true),
        MotionLaw::HarmonicKombiVt | MotionLaw::BeschltrapezVr => (true, false),
        MotionLaw::HarmonicKombiTv | MotionLaw::BeschltrapezRv => (false, true),
        _ => (false, false),
    }
}

fn law_takes_curve(law: MotionLaw) -> bool {
    matches!(law, MotionLaw::Polynom5Mm | MotionLaw::Polynom7Mm)
}

fn place(segment: &Segment, share: f64) -> f64 {
    segment.start() + share * (segment.end() - segment.start())
}

fn ranges(segment: &Segment) -> [MinMax; 4] {
    let extremes = segment.extremes();
    [
        extremes.position,
        extremes.velocity,
        extremes.acceleration,
        extremes.jerk,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn a_derivative_is_the_limit_of_difference_quotients(
        segment in segment(),
        share in 0.01..0.99,
    ) {
        let step = 1e-4 * (segment.end() - segment.start());
        let master = place(&segment, share);
        let at = |steps: f64| values(&segment.at(master + steps * step));
        let samples = [-2.0, -1.0, 1.0, 2.0].map(at);
        let magnitudes = ranges(&segment).map(|range| range.magnitude());
        // At joints the acceleration has a kink and the jerk a jump.
        let jump = (samples[3][3] - samples[0][3]).abs();
        for order in 0..3 {
            let [a, b, c, d] = samples.map(|sample| sample[order]);
            // The quotient of five points errs by the fourth power of the step.
            let quotient = (8.0 * (c - b) - (d - a)) / (12.0 * step);
            let joint = [jump * step * step, jump * step, jump][order];
            let slack = 1e-6 * magnitudes[order + 1]
                + 2.0 * joint
                + 1e-14 * (magnitudes[order] + magnitudes[1] * master.abs()) / step;
            prop_assert!((quotient - at(0.0)[order + 1]).abs() <= slack);
        }
    }

    #[test]
    fn extremes_bound_the_segment_and_are_taken(segment in segment()) {
        let ranges = ranges(&segment);
        // Samples are the independent judge: they can only stay inside.
        for k in 0..=500 {
            let motion = segment.at(place(&segment, f64::from(k) / 500.0));
            for (value, range) in values(&motion).into_iter().zip(&ranges) {
                let slack = 1e-12 * range.magnitude();
                prop_assert!(value >= range.minimum.value - slack);
                prop_assert!(value <= range.maximum.value + slack);
            }
        }
        for (order, range) in ranges.iter().enumerate() {
            for extreme in [range.minimum, range.maximum] {
                prop_assert!(segment.start() <= extreme.master);
                prop_assert!(extreme.master <= segment.end());
                // From one side at least: at joints the jerk jumps.
                let nudge = 1e-12 * (segment.end() - segment.start()).max(extreme.master.abs());
                let near = [-nudge, 0.0, nudge].map(|nudge| extreme.master + nudge);
                let slack = 1e-8 * range.magnitude();
                let is_taken = near.iter().any(|&master| {
                    (values(&segment.at(master))[order] - extreme.value).abs() <= slack
                });
                prop_assert!(is_taken);
            }
        }
    }

    #[test]
    fn a_position_is_found_where_it_is_reached(segment in segment(), share in 0.0..=1.0) {
        let master = place(&segment, share);
        let here = segment.at(master);
        let masters = segment.masters_at(here.position);
        let [position, velocity, ..] = ranges(&segment);
        prop_assert!(masters.is_sorted_by(|a, b| a < b));
        // Rounding of the position, and of the master times the slope.
        let noise = 1e-14 * (position.magnitude() + velocity.magnitude() * master.abs());
        for &reached in masters.iter() {
            prop_assert!(segment.start() <= reached && reached <= segment.end());
            let off = (segment.at(reached).position - here.position).abs();
            prop_assert!(off <= 4.0 * noise, "{off} off at {reached}");
        }
        // If the slave creeps, a rounding error of the position is a great distance.
        let length = segment.end() - segment.start();
        let creeps = here.velocity.abs() <= 1e-3 * velocity.magnitude();
        let slack = if creeps {
            length
        } else {
            4.0 * noise / here.velocity.abs() + 1e-14 * (length + master.abs())
        };
        prop_assert!(masters.iter().any(|reached| (reached - master).abs() <= slack));
    }

    /// Finds as many crossings as a dense sampling.
    #[test]
    fn no_crossing_is_missed(segment in segment(), level in 0.0..1.0) {
        let [position, ..] = ranges(&segment);
        let (low, high) = (position.minimum.value, position.maximum.value);
        let target = low + level * (high - low);
        let side = |k: i32| {
            segment.at(place(&segment, f64::from(k) / 400.0)).position > target
        };
        // A sampling may miss two crossings within a step, so it is a lower bound.
        let crossings = (0..400).filter(|&k| side(k) != side(k + 1)).count();
        prop_assert!(segment.masters_at(target).len() >= crossings);
    }
}
