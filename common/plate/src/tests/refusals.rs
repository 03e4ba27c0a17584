//! Errors of plates and queries, with their codes and texts.

use std::string::ToString;
use std::vec::Vec;

use super::plates::{motion, plate, rest};
use crate::{CamError, Course, Interpolation, MasterQuery, MotionFunction, MotionPoint};
use crate::{Plate, PointType, PositionTable, ValueSelect};
use coaxle_curve::law::MotionLaw;

const NAN: f64 = f64::NAN;

/// Makes three points at rest, one of them replaced by `point`.
fn with(point: MotionPoint) -> Vec<MotionPoint> {
    let mut points = [rest(1, 0.0, 0.0), rest(2, 10.0, 5.0), rest(3, 20.0, 0.0)].to_vec();
    let row = points.iter().position(|p| p.index == point.index);
    points[row.expect("the row is one of them")] = point;
    points
}

fn of_type(point_type: PointType, point: MotionPoint) -> MotionPoint {
    MotionPoint {
        point_type,
        ..point
    }
}

fn by(function: MotionLaw, point: MotionPoint) -> MotionPoint {
    MotionPoint { function, ..point }
}

fn leading(relative_next: i32, point: MotionPoint) -> MotionPoint {
    MotionPoint {
        relative_next,
        ..point
    }
}

#[track_caller]
fn assert_refused(refused: CamError, code: u32, words: &str) {
    assert_eq!(refused.to_string(), words);
    assert_eq!(refused.code(), code, "{refused}");
}

#[test]
fn motion_functions() {
    use MotionLaw::{Polynom5, Spline, SplineNatural, SplinePeriodic};
    let cases = [
        (
            [rest(1, 0.0, 0.0)].to_vec(),
            0x4A23,
            "0x4a23: received 1 points, expected at least 2",
        ),
        (
            [rest(1, 0.0, 0.0), rest(3, 1.0, 0.0)].to_vec(),
            0x4A1F,
            "0x4a1f: row 1: received point index 3, expected 2",
        ),
        (
            with(rest(2, 10.0, NAN)),
            0x4A1C,
            "0x4a1c: point 2, slave: received NaN, expected a finite number",
        ),
        (
            with(rest(2, 0.0, 5.0)),
            0x4A06,
            "0x4a06: point 2, master: received 0, expected above 0",
        ),
        (
            with(of_type(PointType::Ignore, rest(3, 20.0, 0.0))),
            0x42DB,
            "0x42db: point 3: received point type ignore, expected the first and the last point in use",
        ),
        (
            with(leading(0, rest(2, 10.0, 5.0))),
            0x42DB,
            "0x42db: point 2, relative next: received 0, expected 1 to 1",
        ),
        (
            with(of_type(PointType::Ignore, rest(2, 10.0, 5.0))),
            0x42DB,
            "0x42db: point 1, relative next: leads to point 2, which is ignored, expected a point in use",
        ),
        (
            with(of_type(PointType::Rest, motion(2, 10.0, 5.0, 1.5))),
            0x42DA,
            "0x42da: point 2, velocity: received 1.5, expected 0 at a point of type \"rest\"",
        ),
        (
            with(of_type(
                PointType::Velocity,
                MotionPoint {
                    acceleration: -2.0,
                    ..motion(2, 10.0, 5.0, 1.5)
                },
            )),
            0x42DA,
            "0x42da: point 2, acceleration: received -2, expected 0 at a point of type \"velocity\"",
        ),
        (
            with(of_type(PointType::Add, rest(2, 10.0, 5.0))),
            0x4A12,
            "0x4a12: point 2: received point type add, which has no defined course, expected another one",
        ),
        (
            with(by(Polynom5, motion(2, 10.0, 5.0, 1.5))),
            0x42DA,
            "0x42da: point 2, velocity: received 1.5, expected 0 at the end of law \"polynom5\", which leads from \
             point 1 to point 2",
        ),
        (
            // A jerk of 1e915.
            with(rest(2, 1e-300, 1e15)),
            0x42DA,
            "0x42da: law \"polynom5\" from point 1 to point 2: length of the segment: received 1e-300, expected one over \
             which velocity, acceleration and jerk are finite",
        ),
        (
            with(by(Spline, rest(2, 10.0, 5.0))),
            0x42DA,
            "0x42da: point 2: received an inner spline point, expected it after the first point of a spline",
        ),
        (
            [
                by(SplineNatural, rest(1, 0.0, 0.0)),
                by(Spline, rest(2, 1.0, 0.0)),
                by(SplinePeriodic, rest(3, 2.0, 0.0)),
            ]
            .to_vec(),
            0x42DA,
            "0x42da: spline from point 1 to point 3: periodic at one end, expected at both or none",
        ),
        (
            with(by(SplinePeriodic, rest(2, 10.0, 5.0))),
            0x4A21,
            "0x4a21: spline from point 2: received 2 points, expected at least 3",
        ),
        (
            [
                by(SplineNatural, rest(1, 0.0, 0.0)),
                // A slope of 1e350.
                by(Spline, rest(2, 1e-200, 1e150)),
                by(SplineNatural, rest(3, 1.0, 0.0)),
            ]
            .to_vec(),
            0x4A20,
            "0x4a20: from point 1: received slopes that are not finite, expected less extreme positions",
        ),
    ];
    for (points, code, words) in cases {
        assert_refused(MotionFunction::new(points).unwrap_err(), code, words);
    }
}

#[test]
fn only_the_last_point_may_lead_anywhere() {
    let points = with(leading(-7, rest(3, 20.0, 0.0)));
    assert!(MotionFunction::new(points).is_ok());
    // In an ignored point, only the index is checked.
    let mut points = with(of_type(PointType::Ignore, leading(9, rest(2, NAN, NAN))));
    points[0].relative_next = 2;
    assert!(MotionFunction::new(points).is_ok());
}

#[test]
fn changes() {
    let mut plate = plate(&with(rest(2, 10.0, 5.0)), Course::Cyclic);
    assert_refused(
        plate.change(&[]).unwrap_err(),
        0x4B34,
        "0x4b34: received no points to change, expected at least 1",
    );
    assert_refused(
        plate.change(&[rest(4, 30.0, 0.0)]).unwrap_err(),
        0x4B33,
        "0x4b33: received point index 4, expected 1 to 3",
    );
    let rows = [(0.0, 0.0), (1.0, 1.0)];
    let table = PositionTable::new(&rows, Interpolation::Linear, Course::Linear).unwrap();
    assert_refused(
        Plate::from_table(table).change(&[]).unwrap_err(),
        0x4262,
        "0x4262: received a table of type NonEquidistant, expected a motion function",
    );
}

#[test]
fn position_tables() {
    let three = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)];
    let new = |rows: &[(f64, f64)], interpolation| {
        PositionTable::new(rows, interpolation, Course::Linear).unwrap_err()
    };
    assert_refused(
        new(&[], Interpolation::Linear),
        0x4B36,
        "0x4b36: received 0 rows, expected at least 2",
    );
    assert_refused(
        new(&three[..1], Interpolation::Linear),
        0x4A02,
        "0x4a02: received 1 rows, expected at least 2",
    );
    assert_refused(
        new(&three, Interpolation::Spline),
        0x4A02,
        "0x4a02: received 3 rows, expected at least 4",
    );
    assert_refused(
        new(&three, Interpolation::FourPoint),
        0x4A08,
        "0x4a08: four-point interpolation is no longer supported, expected linear, spline or sliding spline",
    );
    assert_refused(
        new(&[(0.0, 0.0), (0.0, 1.0)], Interpolation::Linear),
        0x4A06,
        "0x4a06: row 1, master: received 0, expected above 0",
    );
    assert_refused(
        new(&[(0.0, 0.0), (f64::INFINITY, 1.0)], Interpolation::Linear),
        0x4A1C,
        "0x4a1c: row 1, master: received inf, expected a finite number",
    );
    // A slope of 1e400 is beyond the largest double, 1.8e308.
    let steep = [(0.0, 0.0), (1e-200, 1e200), (1.0, 0.0), (2.0, 0.0)];
    for interpolation in [
        Interpolation::Linear,
        Interpolation::Spline,
        Interpolation::SlidingSpline,
    ] {
        assert_refused(
            new(&steep, interpolation),
            0x4A20,
            "0x4a20: from row 0: received slopes that are not finite, expected less extreme positions",
        );
    }
    let uneven = [(0.0, 0.0), (1.5, 1.0), (2.0, 0.0)];
    assert_refused(
        PositionTable::equidistant(&uneven, Interpolation::Linear, Course::Linear).unwrap_err(),
        0x4A04,
        "0x4a04: row 1, master: received 1.5, expected 1 at equal steps",
    );
}

#[test]
fn questions() {
    let plate = plate(&with(rest(2, 10.0, 5.0)), Course::Cyclic);
    let values = |from, to, increment, select| {
        plate
            .values(from, to, increment, select)
            .map(Iterator::count)
            .unwrap_err()
    };
    let position = ValueSelect::POSITION;
    assert_refused(
        values(0.0, 1.0, -0.1, position),
        0x4B38,
        "0x4b38: increment: received -0.1, expected a number other than 0 towards a distance of 1",
    );
    // 1/0 and 1/1e-300 are more rows than can be read, and an infinite increment never arrives.
    for increment in [0.0, NAN, f64::INFINITY, 1e-300] {
        assert_eq!(values(0.0, 1.0, increment, position).code(), 0x4B38);
    }
    assert_eq!(values(0.0, 0.0, 0.0, position).code(), 0x4B38);
    assert_refused(
        values(0.0, 1.0, 0.1, ValueSelect::empty()),
        0x4B37,
        "0x4b37: value selection: received 0x0000, expected a sum of some of 1, 2, 4 and 8",
    );
    let unknown = ValueSelect::from_bits_retain(17);
    assert_eq!(values(0.0, 1.0, 0.1, unknown).code(), 0x4B37);
    assert_refused(
        values(0.0, NAN, 0.1, position),
        0x4A1C,
        "0x4a1c: end position: received NaN, expected a finite number",
    );
    assert_refused(
        plate.characteristics(0.0).unwrap_err(),
        0x4A1C,
        "0x4a1c: master velocity: received 0, expected a finite number other than 0",
    );
    let ask = |query| plate.master_positions(&query).unwrap_err().to_string();
    let query = MasterQuery::default();
    assert_eq!(
        ask(MasterQuery {
            slave_scaling: 0.0,
            ..query
        }),
        "0x4a1c: slave scaling: received 0, expected a finite number other than 0"
    );
    assert_eq!(
        ask(MasterQuery {
            master_start: NAN,
            ..query
        }),
        "0x4a1c: master start position: received NaN, expected a finite number"
    );
    assert_eq!(
        ask(MasterQuery {
            accuracy: -1.0,
            ..query
        }),
        "0x4a1c: master accuracy: received -1, expected a finite number from 0"
    );
}
