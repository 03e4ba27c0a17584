use core::f64::consts::PI;
use std::vec::Vec;

use coaxle_curve::law::MotionLaw;

use super::plates::{motion, rest};
use crate::{
    CamError, Course, Demand, Interpolation, LawAdvice, LawCriteria, LawLimits, MotionPoint,
    PlateSource, PointType, SourceRows,
};

const AT_ONE: LawCriteria = LawCriteria {
    master_velocity: 1.0,
    limits: LawLimits {
        velocity: None,
        acceleration: None,
        jerk: None,
        torque: None,
    },
    least: Demand::Acceleration,
};

fn source(points: impl Into<Vec<MotionPoint>>, course: Course) -> PlateSource {
    PlateSource {
        course,
        rows: SourceRows::Points(points.into()),
    }
}

/// Makes a stroke from 0 to 1 while the master moves from 0 to 1.
fn unit(start_velocity: f64, end_velocity: f64) -> PlateSource {
    let point = |index, at, velocity| MotionPoint {
        point_type: PointType::Motion,
        ..motion(index, at, at, velocity)
    };
    let points = [point(1, 0.0, start_velocity), point(2, 1.0, end_velocity)];
    source(points, Course::Linear)
}

fn of(advice: &[LawAdvice], law: MotionLaw) -> LawAdvice {
    let found = advice.iter().find(|advice| advice.law == law);
    *found.expect("it is allowed")
}

/// Velocity, acceleration and jerk of the laws of TF5050 8.9 over a unit step.
#[test]
fn what_laws_ask_is_what_the_manuals_say() {
    use MotionLaw as L;
    for (law, start, end, expected) in [
        (L::Polynom3, 0.0, 0.0, [1.5, 6.0, 12.0]),
        (L::Polynom5, 0.0, 0.0, [1.875, 5.7735, 60.0]),
        (L::Polynom7, 0.0, 0.0, [2.1875, 7.5132, 52.5]),
        (L::Polynom8, 0.0, 0.0, [2.35, 9.4033, 67.93]),
        (L::Polynom9, 0.0, 0.0, [2.4609, 9.372, 78.75]),
        (L::Polynom11, 0.0, 0.0, [2.707, 11.2666, 108.28]),
        (L::Peisekah11, 0.0, 0.0, [2.0508, 7.91, 56.93]),
        (L::Sinuslinie, 0.0, 0.0, [PI / 2.0, 4.9348, 15.5]),
        (L::Bestehorn, 0.0, 0.0, [2.0, 2.0 * PI, 39.478]),
        (L::Modsinuslinie, 0.0, 0.0, [1.7596, 5.528, 69.466]),
        (L::Beschltrapez, 0.0, 0.0, [2.0, 4.8881, 61.426]),
        (L::HarmonicKombiRt, 0.0, 0.0, [1.7967, 6.8133, 25.84]),
        (L::HarmonicKombiTr, 0.0, 0.0, [1.7967, 6.8133, 25.84]),
        (L::HarmonicKombiVt, 1.0, 0.0, [1.3628, 3.7029, 10.06]),
        (L::HarmonicKombiTv, 0.0, 1.0, [1.3628, 3.7029, 10.06]),
        (L::BeschltrapezRt, 0.0, 0.0, [1.9133, 4.4639, 53.55]),
        (L::BeschltrapezTr, 0.0, 0.0, [1.9133, 4.4639, 53.55]),
        (L::ModsinuslinieVv, 0.5, 1.5, [1.5, 1.7596, 5.528]),
        (L::BeschltrapezRv, 0.0, 1.0, [1.5249, 3.6661, 38.39]),
        (L::BeschltrapezVr, 1.0, 0.0, [1.5249, 3.6661, 38.39]),
    ] {
        let advice = unit(start, end).law_advice(1, &AT_ONE).unwrap();
        let advice = of(&advice, law);
        let received = [
            advice.demand(Demand::Velocity),
            advice.demand(Demand::Acceleration),
            advice.inner_jerk(),
        ];
        for (received, expected) in received.into_iter().zip(expected) {
            // The manuals print four or five digits.
            let is_it = (received - expected).abs() <= 5e-4 * expected;
            assert!(is_it, "{law:?}: {received}, expected {expected}");
        }
    }
}

/// The greatest |v·a| of a 3-4-5 polynomial, where 30z²(1−z)²·60z(1−z)(1−2z) is extreme.
#[test]
fn torque_is_the_highest_product_of_velocity_and_acceleration() {
    let advice = unit(0.0, 0.0).law_advice(1, &AT_ONE).unwrap();
    let received = of(&advice, MotionLaw::Polynom5).demand(Demand::Torque);
    let product = |z: f64| 1800.0 * (z * (1.0 - z)).powi(3) * (1.0 - 2.0 * z);
    let most = (0..100_000)
        .map(|n| product(f64::from(n) * 1e-5))
        .fold(0.0, f64::max);
    assert!((received - most).abs() < 1e-7 * most, "{received} {most}");
}

#[test]
fn the_best_law_of_each_kind_between_rests() {
    for (least, expected) in [
        // Least peaks of the laws with a continuous acceleration beside rests: Cv 1.7596, Ca 4.8881, Cj 39.478.
        (Demand::Velocity, MotionLaw::Modsinuslinie),
        (Demand::Acceleration, MotionLaw::Beschltrapez),
        (Demand::Jerk, MotionLaw::Bestehorn),
    ] {
        let question = LawCriteria { least, ..AT_ONE };
        let plate = source(
            [rest(1, 0.0, 0.0), rest(2, 10.0, 5.0), rest(3, 30.0, 0.0)],
            Course::Cyclic,
        );
        let advice = plate.law_advice(1, &question).unwrap();
        // A law that steps beside neighbours at rest has infinite jerk, however small its other demands.
        let smooth = advice
            .iter()
            .find(|advice| advice.passes && advice.acceleration_step == 0.0);
        assert_eq!(smooth.map(|advice| advice.law), Some(expected), "{least:?}");
    }
    let jerk = LawCriteria {
        least: Demand::Jerk,
        ..AT_ONE
    };
    let advice = unit(0.0, 0.0).law_advice(1, &jerk).unwrap();
    assert_eq!(advice[0].law, MotionLaw::Bestehorn);
    assert_eq!(
        of(&advice, MotionLaw::Polynom3).demand(Demand::Jerk),
        f64::INFINITY
    );
}

#[test]
fn limits_are_kept_before_anything_is_least() {
    let with = |limits| LawCriteria {
        master_velocity: -2.0,
        limits,
        ..AT_ONE
    };
    let limits = LawLimits {
        // At |V| = 2 a quintic has 1.875·2 = 3.75 and 60·8 of jerk, a trapezoid 2·2 = 4, a septic 2.1875·2.
        velocity: Some(3.8),
        jerk: Some(8.0 * 65.0),
        ..LawLimits::default()
    };
    let advice = unit(0.0, 0.0).law_advice(1, &with(limits)).unwrap();
    assert_eq!(advice[0].law, MotionLaw::Polynom5);
    // The law from motion to motion is equal between rests.
    assert_eq!(advice.iter().filter(|advice| advice.passes).count(), 2);
    let broken: Vec<_> = of(&advice, MotionLaw::Beschltrapez)
        .broken(&limits)
        .collect();
    assert_eq!(broken, [Demand::Velocity]);
    let torque = LawLimits {
        torque: Some(1e-9),
        ..LawLimits::default()
    };
    let advice = unit(0.0, 0.0).law_advice(1, &with(torque)).unwrap();
    assert!(advice.iter().all(|advice| !advice.passes));
}

#[test]
fn a_law_that_does_not_join_its_points_is_last() {
    let plate = source([rest(1, 0.0, 0.0), rest(2, 1.0, 1.0)], Course::Linear);
    let advice = plate.law_advice(1, &AT_ONE).unwrap();
    let line = of(&advice, MotionLaw::Polynom1);
    assert_eq!((line.velocity_step, line.passes), (1.0, false));
    // Between moving points the rest laws are not allowed at all.
    let advice = unit(1.0, 2.0).law_advice(1, &AT_ONE).unwrap();
    let laws: Vec<_> = advice
        .iter()
        .filter(|advice| advice.passes)
        .map(|advice| advice.law)
        .collect();
    assert!(
        !laws.contains(&MotionLaw::Polynom5) && laws.contains(&MotionLaw::Polynom5Mm),
        "{laws:?}"
    );
}

#[test]
fn what_comes_before_and_after_counts() {
    let turn = |function| MotionPoint {
        function,
        point_type: PointType::Turn,
        ..rest(2, 1.0, 1.0)
    };
    let rise = MotionPoint {
        function: MotionLaw::HarmonicKombiRt,
        ..rest(1, 0.0, 0.0)
    };
    // Up and down by mirror images: the acceleration is continuous at the top.
    let points = [rise, turn(MotionLaw::HarmonicKombiTr), rest(3, 2.0, 0.0)];
    for (course, point) in [(Course::Linear, 1), (Course::Cyclic, 2)] {
        let advice = source(points, course).law_advice(point, &AT_ONE).unwrap();
        let law = points[point as usize - 1].function;
        assert_eq!(of(&advice, law).acceleration_step, 0.0, "{course:?}");
        assert!(of(&advice, MotionLaw::Polynom5).acceleration_step > 1.0);
    }
    // Advice is for a plate that is not valid yet.
    let wrong = [
        rise,
        MotionPoint {
            velocity: 1.0,
            ..turn(MotionLaw::Polynom5)
        },
        rest(3, 2.0, 0.0),
    ];
    let wrong = wrong.map(|point| MotionPoint {
        point_type: PointType::Motion,
        ..point
    });
    let advice = source(wrong, Course::Linear)
        .law_advice(2, &AT_ONE)
        .unwrap();
    assert_eq!(of(&advice, MotionLaw::BeschltrapezVr).velocity_step, 0.0);
    // The only segment of a cyclic plate follows itself.
    let advice =
        source([rest(1, 0.0, 0.0), rest(2, 1.0, 1.0)], Course::Cyclic).law_advice(1, &AT_ONE);
    let sine = of(&advice.unwrap(), MotionLaw::Sinuslinie);
    assert!(
        // From -π²/2 at its end to π²/2 at its start.
        (sine.acceleration_step - 2.0 * 4.9348).abs() < 1e-3,
        "{sine:?}"
    );
}

/// The step from the cubic before, 6 u/x² at its end, was lost beside rows that the course does not use.
#[test]
fn rows_beside_the_course_are_no_neighbours() {
    let cubic = |index, at, relative_next| MotionPoint {
        function: MotionLaw::Polynom3,
        relative_next,
        ..rest(index, at, at)
    };
    let ignored = MotionPoint {
        point_type: PointType::Ignore,
        master: f64::NAN,
        ..rest(2, 0.5, 0.0)
    };
    let step = |points: &[MotionPoint], course, point| {
        let advice = source(points, course).law_advice(point, &AT_ONE).unwrap();
        of(&advice, MotionLaw::Polynom5).acceleration_step
    };
    let direct = [cubic(1, 0.0, 1), cubic(2, 1.0, 1), rest(3, 2.0, 2.0)];
    assert_eq!(step(&direct, Course::Linear, 2), 6.0);
    // A row that leads to the point, too, but that the course passes over.
    let skipped = rest(2, 0.9, 0.5);
    for unused in [ignored, skipped] {
        let points = [
            cubic(1, 0.0, 2),
            unused,
            cubic(3, 1.0, 1),
            rest(4, 2.0, 2.0),
        ];
        assert_eq!(step(&points, Course::Linear, 3), 6.0, "{unused:?}");
        // Before the seam of a cyclic plate.
        let points = [
            cubic(1, 0.0, 1),
            cubic(2, 1.0, 2),
            MotionPoint { index: 3, ..unused },
            rest(4, 2.0, 2.0),
        ];
        assert_eq!(step(&points, Course::Cyclic, 1), 6.0, "{unused:?}");
        // A plate that is not valid upstream has neighbours all the same.
        let points = [
            cubic(1, 0.0, 9),
            cubic(2, 0.0, 2),
            unused,
            cubic(4, 1.0, 1),
            rest(5, 2.0, 2.0),
        ];
        assert_eq!(step(&points, Course::Linear, 4), 6.0, "{unused:?}");
    }
}

#[test]
fn where_no_segment_begins_there_is_no_advice() {
    let spline = |index, master| MotionPoint {
        function: MotionLaw::SplineNatural,
        ..rest(index, master, master)
    };
    let ignored = MotionPoint {
        point_type: PointType::Ignore,
        ..rest(2, 0.5, 0.0)
    };
    let leads = |index, relative_next| MotionPoint {
        relative_next,
        ..rest(index, 0.0, 0.0)
    };
    let refused = |points: [MotionPoint; 3], point| {
        let refused = source(points, Course::Linear).law_advice(point, &AT_ONE);
        refused.unwrap_err().code()
    };
    let points = [leads(1, 2), ignored, rest(3, 1.0, 1.0)];
    assert_eq!(refused(points, 0), 0x4b33);
    assert_eq!(refused(points, 4), 0x4b33);
    assert_eq!(refused(points, 2), 0x4a1c);
    assert_eq!(refused(points, 3), 0x4a1c);
    assert_eq!(
        refused([leads(1, 9), ignored, rest(3, 1.0, 1.0)], 1),
        0x42db
    );
    assert_eq!(
        refused([spline(1, 0.0), spline(2, 1.0), spline(3, 2.0)], 1),
        0x4a1c
    );
    let table = PlateSource {
        course: Course::Linear,
        rows: SourceRows::Positions {
            rows: [(0.0, 0.0), (1.0, 1.0)].into(),
            interpolation: Interpolation::Linear,
            equidistant: true,
        },
    };
    let refused = table.law_advice(1, &AT_ONE).unwrap_err();
    assert!(matches!(refused, CamError::NotAMotionFunction { .. }));
    for (velocity, limit) in [(0.0, 1.0), (f64::NAN, 1.0), (1.0, 0.0), (1.0, f64::NAN)] {
        let limits = LawLimits {
            jerk: Some(limit),
            ..LawLimits::default()
        };
        let question = LawCriteria {
            master_velocity: velocity,
            limits,
            ..AT_ONE
        };
        let refused = unit(0.0, 0.0).law_advice(1, &question).unwrap_err();
        assert_eq!(refused.code(), 0x4a1c);
    }
}
