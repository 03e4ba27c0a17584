//! Points changed in place.

use std::vec::Vec;

use proptest::collection::vec;
use proptest::prelude::*;

use super::plates::{motion, plate, points, rest};
use crate::{CamError, Course, MotionFunction, MotionPoint, Plate, PointType};

/// Returns values of a plate at many places.
fn course_of(plate: &Plate) -> Vec<u64> {
    // Beyond both ends of all plates of `points`: from -100 to 100 + 7·50.
    let (start, end) = (-150.0, 600.0);
    (0..=200)
        .map(|i| start + (end - start) * f64::from(i) / 200.0)
        .map(|master| plate.at(master))
        .flat_map(|m| [m.position, m.velocity, m.acceleration, m.jerk])
        .chain(peaks_of(plate))
        .map(f64::to_bits)
        .collect()
}

/// Returns the greatest demands of a plate, and their places.
fn peaks_of(plate: &Plate) -> impl Iterator<Item = f64> {
    let greatest = plate.greatest_demands();
    let demands = [greatest.slope, greatest.speeding_up, greatest.braking];
    demands.into_iter().chain(plate.peaks(|_| true))
}

/// Makes other slave positions for some rows.
fn moved(points: &[MotionPoint], rows: &[(prop::sample::Index, f64)]) -> Vec<MotionPoint> {
    rows.iter()
        .map(|(row, slave)| MotionPoint {
            slave: *slave,
            ..points[row.index(points.len())]
        })
        .collect()
}

fn rows() -> impl Strategy<Value = Vec<(prop::sample::Index, f64)>> {
    vec((any::<prop::sample::Index>(), -100.0..100.0), 1..5)
}

proptest! {
    #[test]
    fn a_change_is_the_same_as_starting_anew(
        points in prop_oneof![points(), super::plates::spline_points()],
        rows in rows(),
        cyclic in any::<bool>(),
    ) {
        let course = if cyclic { Course::Cyclic } else { Course::Linear };
        let mut plate = plate(&points, course);
        let change = moved(&points, &rows);
        let mut expected = points.clone();
        for point in &change {
            expected[point.index as usize - 1] = *point;
        }
        plate.check_change(&change).unwrap();
        plate.segments_changed(&change).unwrap();
        plate.change(&change).unwrap();
        let anew = super::plates::plate(&expected, course);
        prop_assert_eq!(course_of(&plate), course_of(&anew));
        prop_assert_eq!(plate.lift(), anew.lift());
        prop_assert_eq!(plate.function().unwrap().points(), &expected[..]);
        // A clone is made by hand, with capacity of its own, so it could forget a part.
        prop_assert_eq!(course_of(&plate.clone()), course_of(&anew));
    }

    #[test]
    fn a_refused_change_leaves_everything_as_it_was(
        points in points(),
        rows in rows(),
        bad in any::<prop::sample::Index>(),
    ) {
        let mut plate = plate(&points, Course::Cyclic);
        let before = course_of(&plate);
        let mut change = moved(&points, &rows);
        let bad = bad.index(points.len());
        change.push(MotionPoint { master: f64::NAN, ..points[bad] });
        let error = plate.change(&change).unwrap_err();
        let named = matches!(error, CamError::NotFinite { field: "master", .. });
        prop_assert!(named, "{error:?}");
        prop_assert_eq!(plate.segments_changed(&change).unwrap_err().code(), 0x4A1C);
        prop_assert_eq!(course_of(&plate), before);
        prop_assert_eq!(plate.function().unwrap().points(), &points[..]);
    }

    #[test]
    fn outside_what_a_change_touches_the_course_stays(
        points in prop_oneof![points(), super::plates::spline_points()],
        rows in rows(),
        shares in vec(0.0..=1.0_f64, 50),
    ) {
        let mut plate = plate(&points, Course::Linear);
        let before = plate.clone();
        let change = moved(&points, &rows);
        // Linear: a cyclic plate whose period or lift differs is touched as a whole.
        let touched = plate.segments_changed(&change).unwrap();
        plate.change(&change).unwrap();
        let (start, end) = plate.master_range();
        for share in shares {
            let master = start + share * (end - start);
            if !(touched.start..=touched.end).contains(&master) {
                prop_assert_eq!(plate.at(master), before.at(master));
            }
        }
    }
}

fn three_rests() -> [MotionPoint; 4] {
    [
        rest(1, 0.0, 0.0),
        rest(2, 10.0, 5.0),
        rest(3, 20.0, 5.0),
        rest(4, 30.0, 0.0),
    ]
}

#[test]
fn a_change_touches_the_segments_around_its_points() {
    let points = three_rests();
    let mut plate = plate(&points, Course::Cyclic);
    let to = |row: usize, slave| MotionPoint {
        slave,
        ..points[row]
    };
    assert_eq!(plate.segments_changed(&[to(1, 6.0)]), Ok(0.0..20.0));
    assert_eq!(plate.segments_changed(&[to(2, 6.0)]), Ok(10.0..30.0));
    assert!(plate.segments_changed(&[to(1, 5.0)]).unwrap().is_empty());
    // Both ends at once keep the lift, one alone changes every other turn.
    let both = [to(0, 1.0), to(3, 1.0)];
    assert_eq!(plate.segments_changed(&both), Ok(0.0..30.0));
    assert_eq!(plate.segments_changed(&both[..1]), Ok(0.0..30.0));
    let longer = MotionPoint {
        master: 31.0,
        ..points[3]
    };
    assert_eq!(plate.segments_changed(&[longer]), Ok(0.0..31.0));
    // Passed once, only the first segment changes.
    let mut linear = super::plates::plate(&points, Course::Linear);
    assert_eq!(linear.segments_changed(&both[..1]), Ok(0.0..10.0));
    assert_eq!(linear.segments_changed(&[longer]), Ok(20.0..31.0));
}

#[test]
fn points_come_into_use_and_go_out_of_it() {
    let mut points = three_rests();
    points[1].relative_next = 2;
    points[2].point_type = PointType::Ignore;
    let mut plate = plate(&points, Course::Linear);
    assert!((plate.at(20.0).position - 2.5).abs() < 1e-12);

    let all = three_rests();
    assert_eq!(plate.segments_changed(&all[1..3]), Ok(10.0..30.0));
    plate.change(&all[1..3]).unwrap();
    assert!((plate.at(20.0).position - 5.0).abs() < 1e-12);
    // A point that still leads to the ignored one is refused.
    let refused = plate.change(&points[2..3]).unwrap_err();
    assert_eq!(refused, CamError::NextPointIgnored { point: 2, next: 3 });
    plate.change(&points[1..3]).unwrap();
    assert!((plate.at(20.0).position - 2.5).abs() < 1e-12);
}

#[test]
fn points_are_read_back() {
    let points = three_rests();
    let function = MotionFunction::new(points.to_vec()).unwrap();
    assert_eq!(function.point(3), Ok(&points[2]));
    assert_eq!(function.read(1, 0), Ok(&points[..]));
    assert_eq!(function.read(2, 2), Ok(&points[1..3]));
    assert_eq!(function.read(4, 100), Ok(&points[3..]));
    for beyond in [0, 5, u32::MAX] {
        let error = CamError::UnknownPoint {
            received: beyond,
            last: 4,
        };
        assert_eq!(function.point(beyond), Err(error));
        assert_eq!(function.read(beyond, 1), Err(error));
    }
}

#[test]
fn of_two_points_with_one_index_the_later_counts() {
    let mut plate = plate(&three_rests(), Course::Linear);
    let twice = [motion(2, 10.0, 1.0, 0.0), rest(2, 10.0, 4.0)];
    plate.change(&twice).unwrap();
    assert_eq!(plate.function().unwrap().point(2), Ok(&twice[1]));
}
