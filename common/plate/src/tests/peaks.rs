//! Places and amounts of the greatest demands.

use std::vec::Vec;

use proptest::prelude::*;

use super::plates::{any_plate, plate, rest};
use crate::{Course, PeakDemands, Plate};

fn places(plate: &Plate) -> Vec<f64> {
    plate.peaks(|_| true).collect()
}

proptest! {
    #[test]
    fn they_are_those_of_the_characteristics(plate in any_plate()) {
        let extremes = plate.characteristics(1.0).unwrap().extremes;
        let demands = plate.greatest_demands();
        for (received, expected) in [
            (demands.slope, extremes.velocity.magnitude()),
            (demands.curvature(), extremes.acceleration.magnitude()),
        ] {
            prop_assert!((received - expected).abs() <= 1e-9 * expected, "{received} {expected}");
        }
        let at_peaks = places(&plate).into_iter().map(|master| plate.at(master).velocity.abs());
        prop_assert!(at_peaks.fold(0.0, f64::max) >= (1.0 - 1e-6) * demands.slope);
    }

    #[test]
    fn no_place_exceeds_them(plate in any_plate(), share in 0.0..1.0) {
        let (start, _) = plate.master_range();
        let motion = plate.at(start + share * plate.period());
        let demands = plate.greatest_demands();
        let within = |value: f64, most: f64| value.abs() <= most * (1.0 + 1e-9) + 1e-12;
        prop_assert!(within(motion.velocity, demands.slope));
        prop_assert!(within(motion.acceleration, demands.curvature()));
    }
}

#[test]
fn only_the_segments_asked_for_are_searched() {
    let points = [
        rest(1, 0.0, 0.0),
        rest(2, 10.0, 1.0),
        rest(3, 11.0, 2.0),
        rest(4, 20.0, 2.0),
    ];
    let plate = plate(&points, Course::Cyclic);
    assert_eq!(places(&plate).len(), 3 * Plate::PEAKS_OF_A_SEGMENT);
    let steep: Vec<f64> = plate.peaks(|demands| demands.slope > 1.0).collect();
    assert_eq!(steep.len(), Plate::PEAKS_OF_A_SEGMENT);
    assert!(
        steep.iter().all(|master| (10.0..=11.0).contains(master)),
        "{steep:?}"
    );
    assert_eq!(plate.peaks(|_| false).count(), 0);
}

/// A parabola from a velocity to rest only brakes; a quintic between rests does both alike.
#[test]
fn speeding_up_and_braking_are_apart() {
    use coaxle_curve::law::MotionLaw;
    let brakes = [
        crate::MotionPoint {
            function: MotionLaw::Polynom3Vv,
            point_type: crate::PointType::Velocity,
            velocity: 2.0,
            ..rest(1, 0.0, 0.0)
        },
        rest(2, 1.0, 1.0),
    ];
    // 2z - z²: slope 2(1-z), curvature -2, also at its end, where the slave may as well reverse.
    let PeakDemands {
        slope,
        speeding_up,
        braking,
    } = *plate(&brakes, Course::Linear).greatest_demands();
    assert!((slope - 2.0).abs() < 1e-12 && (braking - 2.0).abs() < 1e-12);
    assert!((speeding_up - 2.0).abs() < 1e-12);
    let quintic = [rest(1, 0.0, 0.0), rest(2, 1.0, 1.0)];
    let demands = *plate(&quintic, Course::Linear).greatest_demands();
    for curvature in [demands.speeding_up, demands.braking] {
        assert!(
            (curvature - 10.0 / 3.0_f64.sqrt()).abs() < 1e-9,
            "{demands:?}"
        );
    }
}
