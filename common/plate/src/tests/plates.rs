//! Plates to test with.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;

use crate::{Course, Interpolation, MotionFunction, MotionPoint, Plate, PointType};
use crate::{PositionTable, TableType};
use coaxle_curve::law::MotionLaw;

/// Makes a point at rest that a quintic leaves.
pub(super) const fn rest(index: u32, master: f64, slave: f64) -> MotionPoint {
    MotionPoint::rest(index, master, slave)
}

/// Makes a point with any motion, that a quintic leaves.
pub(super) fn motion(index: u32, master: f64, slave: f64, velocity: f64) -> MotionPoint {
    MotionPoint {
        function: MotionLaw::Polynom5Mm,
        point_type: PointType::Motion,
        velocity,
        ..rest(index, master, slave)
    }
}

pub(super) fn plate(points: &[MotionPoint], course: Course) -> Plate {
    Plate::from_function(
        MotionFunction::new(points.to_vec()).expect("the points are right"),
        course,
    )
}

/// Laws allowed from one type of point to another.
fn laws_between(from: PointType, to: PointType) -> &'static [MotionLaw] {
    use MotionLaw as L;
    use PointType as P;
    match (from, to) {
        (P::Rest, P::Rest) => &[
            L::Polynom1,
            L::Polynom3,
            L::Polynom5,
            L::Polynom7,
            L::Polynom8,
            L::Polynom9,
            L::Polynom11,
            L::Peisekah11,
            L::Sinuslinie,
            L::Modsinuslinie,
            L::Bestehorn,
            L::Beschltrapez,
        ],
        (P::Rest, P::Turn) => &[L::HarmonicKombiRt, L::BeschltrapezRt, L::Polynom5Mm],
        (P::Turn, P::Rest) => &[L::HarmonicKombiTr, L::BeschltrapezTr, L::Polynom7Mm],
        (P::Rest, P::Velocity) => &[L::BeschltrapezRv, L::ModsinuslinieVv, L::Polynom1],
        (P::Velocity, P::Rest) => &[L::BeschltrapezVr, L::ModsinuslinieVv, L::Polynom3Vv],
        (P::Velocity, P::Velocity) => &[L::ModsinuslinieVv, L::Polynom1, L::Polynom3Vv],
        _ => &[L::Polynom5Mm, L::Polynom7Mm, L::Polynom3Vv],
    }
}

/// Data of a random point: master step, slave, type, derivatives, choice of law.
type Draft = (f64, f64, PointType, [f64; 3], usize);

fn draft() -> impl Strategy<Value = Draft> {
    let kind = prop_oneof![
        Just(PointType::Rest),
        Just(PointType::Turn),
        Just(PointType::Velocity),
        Just(PointType::Motion),
    ];
    (
        0.5..50.0,
        -100.0..100.0,
        kind,
        [-5.0..5.0, -1.0..1.0, -0.1..0.1],
        any::<prop::sample::Index>().prop_map(|index| index.index(1_000)),
    )
}

/// Points with all kinds of laws between them.
pub(super) fn points() -> impl Strategy<Value = Vec<MotionPoint>> {
    (-100.0..100.0, vec(draft(), 2..9)).prop_map(|(start, drafts)| points_of(start, &drafts))
}

fn points_of(start: f64, drafts: &[Draft]) -> Vec<MotionPoint> {
    let mut master = start;
    let mut points = Vec::new();
    for (row, &(step, slave, kind, [velocity, acceleration, jerk], choice)) in
        drafts.iter().enumerate()
    {
        // The last point's law leads nowhere, but must not be that of a spline that has not begun.
        let next = drafts.get(row + 1).map_or(kind, |draft| draft.2);
        let laws = laws_between(kind, next);
        // Values that contradict the type would be refused before any law is tried.
        let moves = matches!(kind, PointType::Velocity | PointType::Motion);
        let bends = kind == PointType::Motion;
        points.push(MotionPoint {
            function: laws[choice % laws.len()],
            point_type: kind,
            velocity: if moves { velocity } else { 0.0 },
            acceleration: if bends { acceleration } else { 0.0 },
            jerk: if bends { jerk } else { 0.0 },
            ..rest(row as u32 + 1, master, slave)
        });
        master += step;
    }
    points
}

/// Points of one spline.
pub(super) fn spline_points() -> impl Strategy<Value = Vec<MotionPoint>> {
    let ends = prop_oneof![
        Just(MotionLaw::SplineNatural),
        Just(MotionLaw::SplineTangential),
        Just(MotionLaw::SplineLinear),
        Just(MotionLaw::SplinePeriodic),
    ];
    (ends, vec((0.5..50.0, -100.0..100.0, -5.0..5.0), 3..20)).prop_map(|(law, drafts)| {
        let last = drafts.len() - 1;
        let mut master = 0.0;
        let point = |(row, (step, slave, velocity)): (usize, (f64, f64, f64))| {
            let here = master;
            master += step;
            MotionPoint {
                function: if row == 0 || row == last {
                    law
                } else {
                    MotionLaw::Spline
                },
                ..motion(row as u32 + 1, here, slave, velocity)
            }
        };
        drafts.into_iter().enumerate().map(point).collect()
    })
}

/// Rows of a position table.
pub(super) fn rows() -> impl Strategy<Value = Vec<(f64, f64)>> {
    (-100.0..100.0, vec((0.5..50.0, -100.0..100.0), 4..20)).prop_map(|(start, steps)| {
        let mut master = start;
        let row = |(step, slave): (f64, f64)| {
            master += step;
            (master, slave)
        };
        steps.into_iter().map(row).collect()
    })
}

pub(super) fn course() -> impl Strategy<Value = Course> {
    prop_oneof![Just(Course::Linear), Just(Course::Cyclic)]
}

pub(super) fn interpolation() -> impl Strategy<Value = Interpolation> {
    prop_oneof![
        Just(Interpolation::Linear),
        Just(Interpolation::Spline),
        Just(Interpolation::SlidingSpline),
    ]
}

/// Any plate.
pub(super) fn any_plate() -> impl Strategy<Value = Plate> {
    course().prop_flat_map(plate_of)
}

/// Any plate of one course.
pub(super) fn plate_of(course: Course) -> impl Strategy<Value = Plate> {
    let function = prop_oneof![3 => points(), 1 => spline_points()]
        .prop_map(move |points| plate(&points, course));
    let table = (rows(), interpolation()).prop_map(move |(rows, interpolation)| {
        let table = PositionTable::new(&rows, interpolation, course);
        Plate::from_table(table.expect("the rows are right"))
    });
    // Functions have all laws, tables lines and cubics only: so functions come twice as often.
    prop_oneof![2 => function, 1 => table]
}

/// Returns the masters between which the course of a plate is smooth: its points or rows in use.
pub(super) fn knots(plate: &Plate) -> Vec<f64> {
    let segments = plate.curve().segments();
    let (start, _) = plate.master_range();
    core::iter::once(start)
        .chain(segments.iter().map(coaxle_curve::law::Segment::end))
        .collect()
}

#[test]
fn there_are_plates_of_all_types() {
    let rows = [(0.0, 0.0), (1.0, 1.0)];
    let table = PositionTable::new(&rows, Interpolation::Linear, Course::Linear).unwrap();
    let even = PositionTable::equidistant(&rows, Interpolation::Linear, Course::Cyclic).unwrap();
    let function = plate(&[rest(1, 0.0, 0.0), rest(2, 1.0, 1.0)], Course::Cyclic);
    for (plate, table_type, columns, course) in [
        (function, TableType::MotionFunction, 1, Course::Cyclic),
        (
            Plate::from_table(table),
            TableType::NonEquidistant,
            2,
            Course::Linear,
        ),
        (
            Plate::from_table(even),
            TableType::Equidistant,
            2,
            Course::Cyclic,
        ),
    ] {
        assert_eq!(plate.table_type(), table_type);
        assert_eq!(TableType::from_code(table_type.code()), Some(table_type));
        assert_eq!((plate.rows(), plate.columns()), (2, columns));
        assert_eq!(plate.course(), course);
        assert_eq!(plate.function().is_some(), columns == 1);
        assert_eq!(plate.table().is_some(), columns == 2);
    }
}
