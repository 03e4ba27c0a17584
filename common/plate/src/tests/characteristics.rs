//! Demands of a plate, against samples and closed forms.

use core::f64::consts::PI;

use proptest::prelude::*;

use super::plates::{any_plate, plate, rest};
use crate::{Course, Plate, PositionTable};
use crate::{Interpolation, MotionPoint, PointType};
use coaxle_curve::law::{MinMax, Motion, MotionLaw};

fn assert_close(received: f64, expected: f64) {
    assert!(
        (received - expected).abs() <= 1e-12 * expected.abs(),
        "received {received}, expected {expected}"
    );
}

/// True if a segment has that value at that place: at a joint there may be two.
fn touches(plate: &Plate, range: MinMax, value: impl Fn(Motion) -> f64) -> bool {
    let tolerance = 1e-12 * range.magnitude();
    [range.minimum, range.maximum].iter().all(|extreme| {
        plate
            .curve()
            .segments()
            .iter()
            .filter(|segment| (segment.start()..=segment.end()).contains(&extreme.master))
            .any(|segment| (value(segment.at(extreme.master)) - extreme.value).abs() <= tolerance)
    })
}

fn encloses(range: MinMax, value: f64) -> bool {
    let tolerance = 1e-12 * range.magnitude();
    range.minimum.value - tolerance <= value && value <= range.maximum.value + tolerance
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn extremes_enclose_the_plate_and_touch_it(plate in any_plate()) {
        let found = plate.characteristics(1.0).unwrap();
        let extremes = found.extremes;
        let (start, end) = plate.master_range();
        let (mut way, mut squares) = (0.0, 0.0);
        let samples = 5_000;
        for i in 0..=samples {
            let master = start + (end - start) * f64::from(i) / f64::from(samples);
            let motion = plate.at(master.min(end));
            prop_assert!(encloses(extremes.position, motion.position));
            prop_assert!(encloses(extremes.velocity, motion.velocity));
            prop_assert!(encloses(extremes.acceleration, motion.acceleration));
            prop_assert!(encloses(extremes.jerk, motion.jerk));
            let momentum = motion.velocity * motion.acceleration;
            prop_assert!(encloses(found.dynamic_momentum, momentum), "{momentum} {found:?}");
            if i < samples {
                way += motion.velocity.abs();
                squares += motion.acceleration * motion.acceleration;
            }
        }
        prop_assert!(touches(&plate, extremes.position, |m| m.position));
        prop_assert!(touches(&plate, extremes.velocity, |m| m.velocity));
        prop_assert!(touches(&plate, extremes.acceleration, |m| m.acceleration));
        prop_assert!(touches(&plate, extremes.jerk, |m| m.jerk));
        prop_assert!(touches(&plate, found.dynamic_momentum, |m| m.velocity * m.acceleration));
        prop_assert_eq!(plate.slave_range(), extremes.position);

        let samples = f64::from(samples);
        let mean = way / samples;
        // A sample's interval with a joint in it is wrong by 2·v_max at most: some 20 joints are within 100
        // intervals.
        let error = 10.0 * extremes.velocity.magnitude() / samples * 10.0;
        prop_assert!((found.mean_velocity - mean).abs() <= error, "{mean} {found:?}");
        let effective = squares / samples;
        let error = 100.0 * extremes.acceleration.magnitude().powi(2) / samples;
        prop_assert!((found.effective_acceleration.powi(2) - effective).abs() <= error);
    }

    #[test]
    fn the_masters_velocity_scales_them(plate in any_plate(), velocity in 0.1..50.0_f64) {
        let unit = plate.characteristics(1.0).unwrap();
        let forwards = plate.characteristics(velocity).unwrap();
        let backwards = plate.characteristics(-velocity).unwrap();
        let v = velocity;
        assert_close(forwards.extremes.velocity.maximum.value, unit.extremes.velocity.maximum.value * v);
        assert_close(backwards.extremes.velocity.maximum.value, -unit.extremes.velocity.minimum.value * v);
        assert_close(backwards.extremes.acceleration.minimum.value, unit.extremes.acceleration.minimum.value * v * v);
        assert_close(backwards.extremes.jerk.minimum.value, -unit.extremes.jerk.maximum.value * v * v * v);
        assert_close(backwards.dynamic_momentum.maximum.value, -unit.dynamic_momentum.minimum.value * v * v * v);
        assert_close(backwards.mean_velocity, unit.mean_velocity * v);
        assert_close(backwards.effective_acceleration, unit.effective_acceleration * v * v);
        assert_close(backwards.start.slave.velocity, -v * unit.start.slave.velocity);
        assert_close(
            backwards.velocity_at_maximum_acceleration,
            -v * unit.velocity_at_maximum_acceleration,
        );
    }
}

/// Makes a stroke from 0 to 50 over 20 of the master, by one law.
fn stroke(function: MotionLaw) -> Plate {
    let start = MotionPoint {
        function,
        ..rest(1, 0.0, 0.0)
    };
    plate(&[start, rest(2, 20.0, 50.0)], Course::Linear)
}

#[test]
fn far_from_zero_they_are_the_same() {
    // 2^20: adding it to the ends is exact, so that the length of the segment stays the same to the last bit.
    let far = 1_048_576.0;
    let at = |begin: f64| {
        let start = MotionPoint {
            function: MotionLaw::HarmonicKombiTr,
            ..rest(1, begin, 50.0)
        };
        let plate = plate(&[start, rest(2, begin + 2.0, 0.0)], Course::Linear);
        plate.characteristics(1.0).unwrap()
    };
    let (near, moved) = (at(0.0), at(far));
    assert_eq!(moved.mean_velocity, near.mean_velocity);
    assert_eq!(moved.effective_acceleration, near.effective_acceleration);
    let (near, moved) = (near.dynamic_momentum, moved.dynamic_momentum);
    assert_eq!(moved.minimum.value, near.minimum.value);
    assert_eq!(moved.maximum.value, near.maximum.value);
    assert!((moved.maximum.master - far - near.maximum.master).abs() < 1e-9);
}

#[test]
fn a_quintic_from_rest_to_rest_by_its_closed_form() {
    let (h, b, v) = (50.0, 20.0, 3.0);
    let found = stroke(MotionLaw::Polynom5).characteristics(v).unwrap();
    assert_close(found.mean_velocity, h / b * v);
    // The integral of (60z - 180z² + 120z³)² is 120/7.
    assert_close(
        found.effective_acceleration,
        h * v * v / (b * b) * libm::sqrt(120.0 / 7.0),
    );
    assert_close(found.extremes.velocity.maximum.value, 1.875 * h * v / b);
    assert_close(found.extremes.velocity.maximum.master, b / 2.0);
    let peak = 10.0 / libm::sqrt(3.0) * h * v * v / (b * b);
    assert_close(found.extremes.acceleration.maximum.value, peak);
    assert_close(found.extremes.acceleration.minimum.value, -peak);
    // The acceleration peaks at z = (3 - √3)/6, where z(1 - z) = 1/6 and the velocity 30/36.
    let at_peak = 30.0 / 36.0 * h * v / b;
    assert_close(found.velocity_at_maximum_acceleration, at_peak);
    assert_close(found.velocity_at_minimum_acceleration, at_peak);
    // v·a is 1800·z³(1-z)³(1-2z); with q = z(1-z) its square, q⁶(1-4q), peaks at q = 3/14.
    let q: f64 = 3.0 / 14.0;
    let momentum = 1800.0 * q * q * q * libm::sqrt(1.0 - 4.0 * q) * h * h * v * v * v / (b * b * b);
    assert_close(found.dynamic_momentum.maximum.value, momentum);
    assert_close(found.dynamic_momentum.minimum.value, -momentum);
    assert_close(found.end.slave.jerk, 60.0 * h * (v * v * v) / (b * b * b));
    assert_eq!((found.end.master, found.rows, found.columns), (b, 2, 1));
}

#[test]
fn a_sine_by_its_closed_form() {
    let (h, b) = (50.0, 20.0);
    let found = stroke(MotionLaw::Sinuslinie).characteristics(1.0).unwrap();
    // v·a = (π/2)sin πz · (π²/2)cos πz = (π³/8) sin 2πz.
    let momentum = PI * PI * PI / 8.0 * h * h / (b * b * b);
    assert_close(found.dynamic_momentum.maximum.value, momentum);
    assert!((found.dynamic_momentum.maximum.master - b / 4.0).abs() < 1e-6);
    assert_close(
        found.effective_acceleration,
        PI * PI / 2.0 * h / (b * b) / libm::sqrt(2.0),
    );
}

#[test]
fn the_way_back_counts_as_way() {
    let rows = [(0.0, 0.0), (3.0, 6.0), (4.0, 2.0), (6.0, 2.0)];
    let table = PositionTable::new(&rows, Interpolation::Linear, Course::Linear).unwrap();
    let found = Plate::from_table(table).characteristics(2.0).unwrap();
    // Path 6 + 4 + 0 over 6 of the master.
    assert_close(found.mean_velocity, 2.0 * 10.0 / 6.0);
    assert_eq!(found.effective_acceleration, 0.0);
    assert_eq!(found.extremes.velocity.minimum.value, -8.0);
    assert_eq!(found.columns, 2);
    // Both velocities at the steps count, though only one of them is in force there.
    assert_eq!(found.extremes.velocity.maximum.value, 4.0);
}

#[test]
fn a_segment_may_turn_inside() {
    // From 0 with velocity 6 back to 0 with velocity 6: z(1 - z)(1 - 2z)·6 as a cubic.
    let point = |index, master| MotionPoint {
        function: MotionLaw::Polynom3Vv,
        point_type: PointType::Velocity,
        velocity: 6.0,
        ..rest(index, master, 0.0)
    };
    let plate = plate(&[point(1, 0.0), point(2, 1.0)], Course::Linear);
    let found = plate.characteristics(1.0).unwrap();
    // Its two humps are of height √3/3 each and passed up and down.
    assert_close(found.mean_velocity, 4.0 * libm::sqrt(3.0) / 3.0);
}
