//! Operations of a cam plate in the cycle allocate no memory.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use coaxle_curve::law::MotionLaw;
use coaxle_plate::{Course, Cursor, MotionFunction, MotionPoint, Plate, PointType};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn point(index: u32, slave: f64) -> MotionPoint {
    MotionPoint {
        index,
        function: if index == 1 {
            MotionLaw::SplinePeriodic
        } else {
            MotionLaw::Spline
        },
        point_type: PointType::Motion,
        relative_next: 1,
        master: f64::from(index) * 10.0,
        slave,
        velocity: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
    }
}

#[test]
fn evaluating_asking_and_changing_do_not_allocate() {
    let mut points: Vec<_> = (1..=20)
        .map(|index| point(index, f64::from(index % 4)))
        .collect();
    // Most of them come into use later.
    points[0].relative_next = 19;
    points[0].function = MotionLaw::Polynom3Vv;
    for ignored in &mut points[1..19] {
        ignored.point_type = PointType::Ignore;
    }
    let all: Vec<_> = (1..=20)
        .map(|index| point(index, f64::from(index % 5)))
        .collect();
    let function = MotionFunction::new(points).expect("the points are right");
    let original = Plate::from_function(function, Course::Cyclic);

    // A clone of a vector has no spare capacity, so a derived clone would allocate at its first change.
    for mut plate in [original.clone(), original] {
        let mut cursor = Cursor::default();
        let slave = assert_no_alloc(|| {
            let before = plate.along(&mut cursor, 1e4).position;
            plate.check_change(&all).expect("the change is right");
            plate.segments_changed(&all).expect("the change is right");
            plate.change(&all).expect("the change is right");
            assert!(plate.change(&all[..0]).is_err());
            let after = plate.along(&mut cursor, 105.0).position;
            assert!(plate.master_above(after, 0.0, 0.0).is_some());
            (before, after, plate.at(110.0).position)
        });
        assert!(slave.0.is_finite() && slave.1.is_finite());
        // 110 is the master of point 11, and 11 mod 5 is 1.
        assert!((slave.2 - 1.0).abs() < 1e-12);
    }
}
