//! Planning, against the manuals' numbers and against itself.

mod checks;
mod guard;
mod independent;
mod properties;
mod refusals;
mod remedy;
mod resting;
mod steps;
mod strategies;
mod worked;

use coaxle_clock::Seconds;

use super::{CouplingMoment, GearInPos, GearInVelo, Ratio, SlaveLimits, SyncLimits, SyncMode};
use coaxle_curve::profile::{Kinematics, Limits};

/// Makes a moment with both axes at constant velocity, and an axis with ample limits of its own.
pub(super) fn moment(master: (f64, f64), slave: (f64, f64)) -> CouplingMoment {
    let moving = |(position, velocity)| Kinematics {
        position,
        velocity,
        acceleration: 0.0,
    };
    CouplingMoment {
        master: moving(master),
        encoder: None,
        slave: moving(slave),
        axis: SlaveLimits {
            dynamics: Limits::new(1e4, 1e5, 1e5, 1e6).expect("limits above zero"),
            min_position: None,
            max_position: None,
            guard: None,
        },
    }
}

/// Makes limits with equal acceleration and deceleration, and a jerk.
pub(super) fn dynamics(acceleration: f64, jerk: f64) -> SyncLimits {
    SyncLimits {
        acceleration: Some(acceleration),
        deceleration: Some(acceleration),
        jerk: Some(jerk),
        ..SyncLimits::default()
    }
}

pub(super) fn to_velocity(ratio: f64, sync_mode: SyncMode, limits: SyncLimits) -> GearInVelo {
    GearInVelo {
        ratio: Ratio::of(ratio),
        sync_mode,
        limits,
    }
}

pub(super) fn to_position(
    ratio: f64,
    sync: (f64, f64),
    sync_mode: SyncMode,
    limits: SyncLimits,
) -> GearInPos {
    GearInPos {
        ratio: Ratio::of(ratio),
        master_sync_position: sync.0,
        slave_sync_position: sync.1,
        master_start_distance: None,
        strategy: None,
        sync_mode,
        limits,
    }
}

/// Checks a value within half of the last digit that the manuals' tables print, and a little for its
/// rounding.
fn printed(value: f64, expected: f64, unit: f64) {
    assert!(
        (value - expected).abs() <= 0.51 * unit,
        "{value}, expected {expected}"
    );
}

fn seconds(time: f64) -> Seconds {
    Seconds(time)
}
