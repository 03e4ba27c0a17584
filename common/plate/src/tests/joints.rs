use std::vec::Vec;

use coaxle_curve::law::MotionLaw;

use super::plates::{motion, plate, rest};
use crate::{Course, MotionPoint};

fn steps(points: &[MotionPoint], course: Course) -> Vec<(f64, [bool; 3])> {
    let plate = plate(points, course);
    let joints = plate.joints();
    joints
        .map(|joint| (joint.master, joint.steps().map(|step| step != 0.0)))
        .collect()
}

fn by(function: MotionLaw, point: MotionPoint) -> MotionPoint {
    MotionPoint { function, ..point }
}

#[test]
fn what_steps_is_told_for_each_derivative() {
    let points = [
        by(MotionLaw::Polynom7, rest(1, 0.0, 0.0)),
        by(MotionLaw::Polynom7, rest(2, 10.0, 5.0)),
        by(MotionLaw::Polynom5, rest(3, 30.0, 9.0)),
        by(MotionLaw::Polynom3, rest(4, 40.0, 9.5)),
        by(MotionLaw::Polynom1, rest(5, 50.0, 2.0)),
        rest(6, 60.0, 0.0),
    ];
    // Septic laws end with jerk 0, a quintic with jerk, a cubic with acceleration and jerk.
    let (no, jerk, acceleration) = ([false; 3], [false, false, true], [false, true, true]);
    // A straight line has neither acceleration nor jerk, unlike the law before it at its end.
    let all = [true, true, true];
    let expected = [(10.0, no), (30.0, jerk), (40.0, acceleration), (50.0, all)];
    let cyclic = steps(&points, Course::Cyclic);
    assert_eq!(cyclic[1..], expected);
    // The line ends with slope -0.2 and the septic begins at rest: both without acceleration and jerk.
    assert_eq!(cyclic[0], (0.0, [true, false, false]));
    let linear = steps(&points, Course::Linear);
    assert_eq!(linear[1..5], expected);
    assert_eq!(
        (linear[0], linear[5]),
        ((0.0, no), (60.0, [true, false, false]))
    );
}

#[test]
fn a_spline_goes_on_but_for_its_jerk_and_a_cycle_meets_its_start() {
    let spline = |index, at, slave| by(MotionLaw::SplinePeriodic, motion(index, at, slave, 0.0));
    let inner = |index, at, slave| by(MotionLaw::Spline, motion(index, at, slave, 0.0));
    let points = [
        spline(1, 0.0, 0.0),
        // Thousands of the master, so that third derivatives are differences over 1e9 and rounding shows.
        inner(2, 1e3, 5.0),
        inner(3, 1.7e3, -2.0),
        inner(4, 2.1e3, 0.4),
        spline(5, 4e3, 0.0),
    ];
    for (master, steps) in steps(&points, Course::Cyclic) {
        assert_eq!(steps[..2], [false, false], "{master}");
    }
}
