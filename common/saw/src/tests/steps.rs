//! Choice of the profile.

use super::super::{Check, EncoderNoise, SawForm, SyncMask};
use super::*;

#[test]
fn an_encoders_noise_is_no_acceleration() {
    let mask = SyncMask::OVERSHOOT_VELO | SyncMask::UNDERSHOOT_VELO;
    let mode = SyncMode::position_based(mask);
    let command = to_position(1.0, (1_000.0, 1_000.0), mode, SyncLimits::default());
    let mut start = moment((-500.0, 500.0), (-250.0, 250.0));
    // The threshold below is 2 · 1e-4/1e-6 = 200 u/s².
    start.master.acceleration = 150.0;
    assert!(command.plan(&start).is_err(), "P5 overshoots");
    start.encoder = Some(EncoderNoise {
        scaling: 1e-4,
        cycle: seconds(1e-3),
    });
    assert_eq!(command.plan(&start).unwrap().form(), SawForm::QuinticLine);
    start.master.acceleration = 250.0;
    assert!(command.plan(&start).is_err());

    let mode = SyncMode::position_based(mask | SyncMask::IGNORE_MASTER_ACC);
    let command = to_position(1.0, (1_000.0, 1_000.0), mode, SyncLimits::default());
    assert_eq!(command.plan(&start).unwrap().form(), SawForm::QuinticLine);
    start.slave.acceleration = 10.0;
    assert!(command.plan(&start).is_err());
    let mode = SyncMode::position_based(mode.mask | SyncMask::IGNORE_SLAVE_ACC);
    let command = to_position(1.0, (1_000.0, 1_000.0), mode, SyncLimits::default());
    assert_eq!(command.plan(&start).unwrap().form(), SawForm::QuinticLine);
}

#[test]
fn the_steps_are_taken_in_the_manuals_order() {
    let start = moment((-500.0, 500.0), (-250.0, 250.0));
    let form = |mask, limits| {
        let mode = SyncMode::position_based(mask);
        let command = to_position(1.0, (1_000.0, 1_000.0), mode, limits);
        command.plan(&start).map(|plan| plan.form())
    };
    let below_peak = SyncLimits {
        // P5 peaks at 506 u/s.
        velocity: Some(503.0),
        ..SyncLimits::default()
    };
    let velocity = SyncMask::MAX_VELO;
    let shoots = SyncMask::OVERSHOOT_VELO | SyncMask::UNDERSHOOT_VELO;
    assert_eq!(form(SyncMask::empty(), below_peak), Ok(SawForm::Quintic));
    assert_eq!(form(velocity, below_peak), Ok(SawForm::QuinticLineQuintic));
    assert_eq!(
        form(velocity | shoots, below_peak),
        Ok(SawForm::QuinticLine)
    );
    let constant = SyncMask::PREFER_CONST_VELO;
    assert_eq!(form(constant, below_peak), Ok(SawForm::QuinticLineQuintic));
    // 187.5 u/s² for step 1, 175.046 u/s² for P5: values in between allow P5 only.
    let between = dynamics(180.0, 5_000.0);
    assert_eq!(form(SyncMask::MAX_ACC, between), Ok(SawForm::Quintic));
    let refused = form(SyncMask::MAX_ACC | shoots, between).unwrap_err();
    assert_eq!(
        refused.violation().unwrap().check,
        Check::OvershootVeloForwardFromBelow
    );
}

#[test]
fn a_slave_with_the_gears_velocity_makes_up_its_place_at_the_acceleration_limit() {
    let start = moment((0.0, 100.0), (0.0, 100.0));
    let limits = dynamics(500.0, 1e4);
    // 10 u more than the gear in one second.
    let plan = to_position(1.0, (100.0, 110.0), SyncMode::default(), limits)
        .plan(&start)
        .unwrap();
    assert_eq!(plan.form(), SawForm::QuinticLineQuintic);
    let extremes = plan.characteristics(1).extremes;
    assert!((extremes.acceleration.maximum.value - 500.0).abs() < 1e-9);
    assert!((extremes.acceleration.minimum.value + 500.0).abs() < 1e-9);
}

#[test]
fn a_slave_in_place_already_stays_so_whatever_it_prefers() {
    for mask in [SyncMask::PREFER_CONST_VELO, SyncMask::empty()] {
        let start = moment((0.0, 100.0), (50.0, 100.0));
        let mode = SyncMode::position_based(mask);
        let command = to_position(1.0, (300.0, 350.0), mode, dynamics(500.0, 1e4));
        let plan = command.plan(&start).expect("there is nothing to do");
        let extremes = plan.characteristics(1).extremes;
        assert!(
            extremes.acceleration.magnitude() < 1e-9,
            "{mask:?} {extremes:?}"
        );
        let half = plan.slave_of(&Kinematics {
            position: 150.0,
            velocity: 100.0,
            acceleration: 0.0,
        });
        assert!((half.position - 200.0).abs() < 1e-9 && (half.velocity - 100.0).abs() < 1e-9);
    }
}
