//! Plans of a flying saw, compared with an independent generator.

use std::hint::black_box;

use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_saw::{
    CouplingMoment, GearInPos, GearInVelo, Ratio, SlaveLimits, SyncLimits, SyncMask, SyncMode,
};
use rsruckig::prelude::{ControlInterface, IgnoreErrorHandler, InputParameter, Ruckig, Trajectory};

fn moment(acceleration: f64) -> CouplingMoment {
    CouplingMoment {
        master: Kinematics {
            position: -500.0,
            velocity: 500.0,
            acceleration: 0.0,
        },
        encoder: None,
        slave: Kinematics {
            position: -250.0,
            velocity: 250.0,
            acceleration,
        },
        axis: SlaveLimits {
            dynamics: Limits::new(2_000.0, 2_500.0, 2_500.0, 5_000.0).expect("above zero"),
            min_position: Some(-1e4),
            max_position: Some(1e4),
            guard: None,
        },
    }
}

pub(super) fn two_quintics(calls: u32) {
    let command = GearInPos {
        ratio: Ratio::of(1.0),
        master_sync_position: 1_000.0,
        slave_sync_position: 1_000.0,
        master_start_distance: None,
        strategy: None,
        sync_mode: SyncMode::position_based(SyncMask::PREFER_CONST_VELO | SyncMask::MAX_JERK),
        limits: SyncLimits {
            velocity: Some(550.0),
            min_position: Some(-1e4),
            max_position: Some(1e4),
            ..SyncLimits::default()
        },
    };
    let start = moment(0.0);
    for _ in 0..calls {
        let plan = black_box(&command).plan(black_box(&start));
        // A refusal would be cheap, and a figure of it worthless.
        assert!(black_box(&plan).is_ok(), "passes");
    }
}

fn to_velocity(sync_mode: SyncMode, acceleration: f64, calls: u32) {
    let command = GearInVelo {
        ratio: Ratio::of(1.0),
        sync_mode,
        limits: SyncLimits::default(),
    };
    let start = moment(acceleration);
    for _ in 0..calls {
        let plan = black_box(&command).plan(black_box(&start));
        assert!(black_box(&plan).is_ok(), "passes");
    }
}

pub(super) fn ramp(calls: u32) {
    to_velocity(SyncMode::default(), 500.0, calls);
}

pub(super) fn time_based(calls: u32) {
    to_velocity(SyncMode::time_based(SyncMask::empty()), 0.0, calls);
}

pub(super) fn rsruckig(calls: u32) {
    let mut input = InputParameter::<1>::new(None);
    // Its nearest equivalent: to a velocity, since the position is free in a time-based plan.
    input.control_interface = ControlInterface::Velocity;
    input.current_position[0] = -250.0;
    input.current_velocity[0] = 250.0;
    input.target_velocity[0] = 500.0;
    input.max_velocity[0] = 2_000.0;
    input.max_acceleration[0] = 2_500.0;
    input.max_jerk[0] = 5_000.0;
    let mut ruckig = Ruckig::<1, IgnoreErrorHandler>::new(None, 1e-3);
    let mut trajectory = Trajectory::<1>::new(None);
    for _ in 0..calls {
        let _ = black_box(ruckig.calculate(black_box(&input), &mut trajectory).is_ok());
    }
}
