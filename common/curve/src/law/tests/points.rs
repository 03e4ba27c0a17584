//! Behaviour of a law at its points, and its refusals.

use std::string::ToString;

use super::super::{LawError, Motion, MotionLaw, Quantity, Segment, Side, Turn};
use super::{knot, laws, unit, values};

/// Laws with `V` and `M` ends take over the values of the points.
#[test]
fn general_laws_take_over_their_points() {
    let start = knot(-7.0, [3.0, 0.4, -1.5, 20.0]);
    let end = knot(-4.5, [-8.0, 2.5, 0.7, -3.0]);
    for (law, orders) in [
        (MotionLaw::Polynom1, 0..=0),
        (MotionLaw::Polynom3Vv, 0..=1),
        (MotionLaw::Polynom5Mm, 0..=2),
        (MotionLaw::Polynom7Mm, 0..=3),
    ] {
        let segment = Segment::new(law, &start, &end).unwrap();
        for point in [start, end] {
            let received = values(&segment.at(point.master));
            for order in orders.clone() {
                let expected = values(&point.motion)[order];
                assert!(
                    (received[order] - expected).abs() <= 1e-12 * 20.0,
                    "{law:?}"
                );
            }
        }
    }
}

#[test]
fn laws_keep_the_conditions_of_their_ends() {
    for law in laws() {
        let name = law.name();
        let velocities = match name.rsplit_once('_').map(|(_, ends)| ends) {
            Some("VV") => [0.4, 0.9],
            Some("RV" | "TV") => [0.0, 1.1],
            Some("VR" | "VT") => [1.1, 0.0],
            _ => [0.0, 0.0],
        };
        let segment = unit(law, velocities);
        for (z, velocity) in [(0.0, velocities[0]), (1.0, velocities[1])] {
            let motion = segment.at(z);
            assert!((motion.position - z).abs() <= 1e-12, "{name}");
            if law == MotionLaw::Polynom1 {
                continue;
            }
            assert!((motion.velocity - velocity).abs() <= 1e-12, "{name}");
            let ends: [char; 2] = match name.rsplit_once('_').map(|(_, ends)| ends) {
                Some("RT") => ['R', 'T'],
                Some("TR") => ['T', 'R'],
                Some("VT") => ['V', 'T'],
                Some("TV") => ['T', 'V'],
                _ => ['R', 'R'],
            };
            let turns = ends[z as usize] == 'T'
                || matches!(
                    law,
                    MotionLaw::Polynom3 | MotionLaw::Polynom3Vv | MotionLaw::Sinuslinie
                );
            if turns {
                assert!(motion.acceleration.abs() > 1.0, "{name}");
            } else {
                assert!(motion.acceleration.abs() <= 1e-12, "{name}");
            }
        }
    }
}

/// Position, velocity and acceleration have no step at the inner joints.
#[test]
fn inner_joints_are_continuous() {
    // Joints of the sine laws and of the trapezoid: quarters, and eighths.
    let joints = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875];
    // Those of the trapezoid that ends turning, and of the harmonic combination from rest.
    let ramp = 1.0 / (7.0 + core::f64::consts::FRAC_2_PI);
    let ramps = [ramp, 3.0 * ramp, 4.0 * ramp, 5.0 * ramp];
    let turn = 2.0 - 2_f64.sqrt();
    for law in laws() {
        let segment = unit(law, [0.0; 2]);
        let places = joints.iter().chain(&ramps).chain([&turn]);
        for place in places.flat_map(|&z| [z, 1.0 - z]) {
            // Wider than the rounding of the joint, narrower than the tolerance.
            let (before, after) = (place - 4e-16, place + 4e-16);
            let (before, after) = (segment.at(before), segment.at(after));
            let bound = segment.extremes();
            let step = |a: f64, b: f64, magnitude: f64| (a - b).abs() <= 1e-12 * magnitude.max(1.0);
            assert!(step(before.position, after.position, 1.0));
            assert!(step(
                before.velocity,
                after.velocity,
                bound.velocity.magnitude()
            ));
            assert!(step(
                before.acceleration,
                after.acceleration,
                bound.acceleration.magnitude()
            ));
        }
    }
}

#[test]
fn a_law_run_backwards_is_its_mirror_image() {
    for (law, mirrored) in [
        (MotionLaw::HarmonicKombiRt, MotionLaw::HarmonicKombiTr),
        (MotionLaw::HarmonicKombiVt, MotionLaw::HarmonicKombiTv),
        (MotionLaw::BeschltrapezRt, MotionLaw::BeschltrapezTr),
        (MotionLaw::BeschltrapezRv, MotionLaw::BeschltrapezVr),
        (MotionLaw::ModsinuslinieVv, MotionLaw::ModsinuslinieVv),
    ] {
        let velocities = match law {
            MotionLaw::HarmonicKombiVt => [0.7, 0.0],
            MotionLaw::BeschltrapezRv => [0.0, 0.7],
            MotionLaw::ModsinuslinieVv => [0.2, 0.7],
            _ => [0.0, 0.0],
        };
        let (one, other) = (
            unit(law, velocities),
            unit(mirrored, [velocities[1], velocities[0]]),
        );
        for k in 0..=100 {
            let z = f64::from(k) / 100.0;
            let Motion {
                position,
                velocity,
                acceleration,
                jerk,
            } = other.at(1.0 - z);
            let expected = [1.0 - position, velocity, -acceleration, jerk];
            for (received, expected) in values(&one.at(z)).into_iter().zip(expected).take(3) {
                assert!((received - expected).abs() <= 1e-13, "{law:?} at {z}");
            }
        }
    }
}

#[test]
fn a_cubic_is_given_by_its_powers() {
    let segment = Segment::cubic(10.0, 14.0, [1.0, -2.0, 3.0, -0.5]);
    assert_eq!((segment.start(), segment.end()), (10.0, 14.0));
    // With x = 2: 1 − 4 + 12 − 4, −2 + 12 − 6, 6 − 6, −3.
    let at_12 = Motion {
        position: 5.0,
        velocity: 4.0,
        acceleration: 0.0,
        jerk: -3.0,
    };
    assert_eq!(segment.at(12.0), at_12);
}

#[test]
fn start_and_end_keep_their_sides() {
    for law in laws() {
        let (start, end) = (
            knot(3.0, [1.0, 0.0, 0.0, 0.0]),
            knot(8.0, [2.0, 0.0, 0.0, 0.0]),
        );
        let segment = Segment::new(law, &start, &end).unwrap();
        assert_eq!((segment.start(), segment.end()), (3.0, 8.0));
        assert_eq!(segment.masters_at(1.0).as_ref(), [3.0], "{law:?}");
        assert_eq!(segment.masters_at(2.0).as_ref(), [8.0], "{law:?}");
        assert!(segment.masters_at(2.1).is_empty());
    }
}

#[test]
fn a_dwell_stays_where_it_is() {
    for law in laws() {
        let (start, end) = (
            knot(3.0, [7.0, 0.0, 0.0, 0.0]),
            knot(8.0, [7.0, 0.0, 0.0, 0.0]),
        );
        let segment = Segment::new(law, &start, &end).unwrap();
        let still = Motion {
            position: 7.0,
            ..Motion::default()
        };
        assert_eq!(segment.at(4.9), still);
        assert_eq!(segment.masters_at(7.0).as_ref(), [3.0], "{law:?}");
        assert!(segment.masters_at(6.0).is_empty());
        assert_eq!(segment.extremes().position.maximum.value, 7.0);
    }
}

#[test]
fn points_which_contradict_the_law_are_refused() {
    let rest = knot(0.0, [0.0; 4]);
    let moving = knot(2.0, [5.0, 1.5, 0.0, 0.0]);
    let refused = Segment::new(MotionLaw::Polynom5, &rest, &moving).unwrap_err();
    assert_eq!(refused.code(), 0x42DA);
    assert_eq!(
        refused.to_string(),
        "velocity at the end: received 1.5, expected 0 for MOTIONFUNCTYPE_POLYNOM5"
    );
    let curved = knot(-2.0, [5.0, 0.0, -3.0, 0.0]);
    for law in [MotionLaw::HarmonicKombiVt, MotionLaw::BeschltrapezRt] {
        assert_eq!(
            Segment::new(law, &curved, &rest),
            Err(LawError::Boundary {
                law,
                side: Side::Start,
                quantity: Quantity::Acceleration,
                received: -3.0,
                expected: 0.0,
            })
        );
    }
    // At a turn the acceleration is the law's own.
    assert!(Segment::new(MotionLaw::HarmonicKombiTr, &curved, &rest).is_ok());
    // A rest within rounding counts as one.
    let almost = knot(2.0, [5.0, 1e-12, -1e-12, 0.0]);
    assert!(Segment::new(MotionLaw::Bestehorn, &rest, &almost).is_ok());
}

#[test]
fn segments_without_length_and_numbers_are_refused() {
    let at = |master| knot(master, [0.0; 4]);
    for end in [1.0, 0.5] {
        assert_eq!(
            Segment::new(MotionLaw::Polynom1, &at(1.0), &at(end)),
            Err(LawError::NoLength { start: 1.0, end })
        );
    }
    let bad = knot(2.0, [0.0, 0.0, f64::INFINITY, 0.0]);
    let refused = Segment::new(MotionLaw::Polynom5Mm, &at(1.0), &bad).unwrap_err();
    assert_eq!(
        refused,
        LawError::NotFinite {
            side: Side::End,
            quantity: Quantity::Acceleration,
            received: f64::INFINITY,
        }
    );
    assert!(Segment::new(MotionLaw::Polynom1, &at(f64::NAN), &at(1.0)).is_err());
    // Finite each, but not together.
    // 1e10 · (1e200)³ overflows, and 1e200 · 1e200 as well.
    let far = knot(1e200, [0.0, 0.0, 0.0, 1e10]);
    for (start, end) in [
        (at(0.0), far),
        (knot(-1e200, [0.0, 1e200, 0.0, 0.0]), at(0.0)),
    ] {
        for law in [MotionLaw::Polynom7Mm, MotionLaw::ModsinuslinieVv] {
            let refused = Segment::new(law, &start, &end).unwrap_err();
            assert!(matches!(refused, LawError::NotFinite { .. }), "{refused}");
        }
    }
    let low = knot(0.0, [-1.7e308, 0.0, 0.0, 0.0]);
    let high = knot(1.0, [1.7e308, 0.0, 0.0, 0.0]);
    assert!(Segment::new(MotionLaw::Polynom5, &low, &high).is_err());
}

#[test]
fn impossible_turning_points_are_refused() {
    let (start, end) = (knot(0.0, [0.0; 4]), knot(2.0, [1.0, 0.0, 0.0, 0.0]));
    let with = |turn| Segment::with_turn(MotionLaw::HarmonicKombiRt, &start, &end, turn);
    for share in [0.0, 1.0, -0.2, f64::NAN] {
        assert!(matches!(
            with(Turn::At(share)),
            Err(LawError::TurnShare { .. })
        ));
    }
    // The gentlest turn is that of a quarter sine alone: π²/4 of the stroke per squared length.
    let gentlest = core::f64::consts::PI.powi(2) / 16.0;
    // Anything stronger has a half sine before it; weaker ones, or of the other sign, none.
    assert!(with(Turn::Acceleration(-1.01 * gentlest)).is_ok());
    for acceleration in [-0.99 * gentlest, 5.0, 0.0] {
        assert_eq!(
            with(Turn::Acceleration(acceleration)),
            Err(LawError::TurnAcceleration {
                received: acceleration
            })
        );
    }
    let fast = knot(0.0, [0.0, 0.9, 0.0, 0.0]);
    assert_eq!(
        Segment::new(MotionLaw::HarmonicKombiVt, &fast, &end),
        Err(LawError::TurnVelocity {
            received: 0.9,
            mean: 0.5
        })
    );
    // Other laws have no turning point.
    let plain = Segment::new(MotionLaw::Polynom5, &start, &end);
    let told = Segment::with_turn(MotionLaw::Polynom5, &start, &end, Turn::At(7.0));
    assert_eq!(plain, told);
}

#[test]
fn a_spline_is_no_law_between_two_points() {
    for &law in MotionLaw::ALL.iter().filter(|law| law.is_spline()) {
        let refused = Segment::new(law, &knot(0.0, [0.0; 4]), &knot(1.0, [0.0; 4]));
        assert_eq!(refused, Err(LawError::Spline { law }));
    }
}
