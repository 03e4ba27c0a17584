//! Steps of the velocity, and plates as they are written.

use super::plates::{plate, rest};
use crate::{
    CamError, Course, Interpolation, MotionFunction, MotionPoint, Plate, PlateSource,
    PositionTable, SourceRows, VelocityStep,
};
use alloc::vec::Vec;
use coaxle_curve::law::MotionLaw;

/// Follows the master for a while, and returns: the synchronous piece does not state its slope.
fn synchronous(slope_at_its_ends: f64) -> Vec<MotionPoint> {
    let point = |index, function, master, slave, velocity| MotionPoint {
        index,
        function,
        velocity,
        point_type: crate::PointType::Motion,
        ..MotionPoint::rest(index, master, slave)
    };
    Vec::from([
        point(1, MotionLaw::Polynom5Mm, 0.0, 0.0, 0.0),
        point(2, MotionLaw::Polynom1, 100.0, 50.0, slope_at_its_ends),
        point(3, MotionLaw::Polynom5Mm, 300.0, 250.0, slope_at_its_ends),
        point(4, MotionLaw::Polynom5Mm, 800.0, 0.0, 0.0),
    ])
}

fn function(points: Vec<MotionPoint>, course: Course) -> Plate {
    Plate::from_function(MotionFunction::new(points).expect("points"), course)
}

#[test]
fn a_synchronous_piece_that_its_points_do_not_know_of_makes_two_steps() {
    let steps: Vec<_> = function(synchronous(0.0), Course::Linear)
        .velocity_steps()
        .collect();
    let step = |master, before, after| VelocityStep {
        master,
        before,
        after,
    };
    // The line's slope is (250 - 50)/(300 - 100) = 1, and the points beside it claim 0.
    assert_eq!(steps, [step(100.0, 0.0, 1.0), step(300.0, 1.0, 0.0)]);
    let smooth = function(synchronous(1.0), Course::Cyclic);
    assert_eq!(smooth.velocity_steps().count(), 0);
}

#[test]
fn each_row_of_straight_lines_is_one_and_the_seam_of_a_cyclic_table_too() {
    let rows = [(0.0, 0.0), (10.0, 2.0), (20.0, 8.0), (30.0, 10.0)];
    let table = |course| {
        Plate::from_table(PositionTable::new(&rows, Interpolation::Linear, course).unwrap())
    };
    assert_eq!(table(Course::Linear).velocity_steps().count(), 2);
    let cyclic = [(0.0, 0.0), (10.0, 2.0), (20.0, 2.5), (30.0, 10.0)];
    let cyclic = PositionTable::new(&cyclic, Interpolation::Linear, Course::Cyclic).unwrap();
    let found = Plate::from_table(cyclic).characteristics(2.0).unwrap();
    assert_eq!(found.velocity_steps, 3, "two rows and the seam");
    let largest = found.largest_velocity_step.unwrap();
    assert_eq!(
        (largest.master, largest.before, largest.after),
        // Slopes of 0.05 and 0.75 at a master velocity of 2.
        (20.0, 0.1, 1.5)
    );
}

#[test]
fn smooth_laws_make_none() {
    let plate = plate(
        &[rest(1, 0.0, 0.0), rest(2, 180.0, 50.0), rest(3, 360.0, 0.0)],
        Course::Cyclic,
    );
    assert_eq!(plate.largest_velocity_step(), None);
    let rows = [(0.0, 0.0), (1.0, 3.0), (2.0, 1.0), (3.0, 4.0), (4.0, 0.0)];
    for interpolation in [Interpolation::Spline, Interpolation::SlidingSpline] {
        let spline = PositionTable::new(&rows, interpolation, Course::Cyclic).unwrap();
        let spline = Plate::from_table(spline);
        assert_eq!(spline.velocity_steps().count(), 0, "{interpolation:?}");
    }
}

#[test]
fn a_plate_is_made_of_what_it_says_it_is_made_of() {
    let rows = [(0.0, 0.0), (10.0, 2.0), (20.0, 8.0), (30.0, 10.0)];
    let table = PositionTable::equidistant(&rows, Interpolation::Spline, Course::Linear).unwrap();
    for plate in [
        function(synchronous(1.0), Course::Cyclic),
        Plate::from_table(table),
    ] {
        let source = plate.source();
        let again = source.plate().unwrap();
        assert_eq!((again.source(), source.len()), (source, plate.rows()));
        assert_eq!(again.table_type(), plate.table_type());
        assert_eq!(again.at(12.5), plate.at(12.5));
    }
}

#[test]
fn points_that_were_written_are_put_over_those_of_the_source() {
    let mut plate = plate(
        &[rest(1, 0.0, 0.0), rest(2, 180.0, 50.0), rest(3, 360.0, 0.0)],
        Course::Cyclic,
    );
    let source = plate.source();
    let changed = [rest(2, 170.0, 40.0)];
    plate.change(&changed).unwrap();
    assert_eq!(source.with_points(&changed), plate.source());
    assert_eq!(
        source.with_points(&[rest(9, 1.0, 1.0)]),
        source,
        "there is no such point"
    );
}

#[test]
fn no_number_is_larger_than_any_axis() {
    let source = PlateSource {
        course: Course::Linear,
        rows: SourceRows::Points(Vec::from([rest(1, 0.0, 0.0), rest(2, 1.0, -2e15)])),
    };
    let error: CamError = source.check_size().unwrap_err();
    assert_eq!(error.code(), 0x4A1C);
    assert!(std::format!("{error}").starts_with("0x4a1c: point 2, slave: received -2e15"));
}
