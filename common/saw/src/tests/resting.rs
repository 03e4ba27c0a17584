//! A master at rest when the saw is planned, with a configured velocity for later.

use coaxle_clock::Seconds;

use std::string::ToString;

use super::*;
use crate::{SawCommand, SawCoupling, SawForm, SawRefusal, SawTolerances, SyncMask};
use coaxle_axis::CommandState;

const CHECKED: SyncMask = SyncMask::MAX_ACC.union(SyncMask::OVERSHOOT_VELO);

/// A distance ahead, with at most 1000 u/s² and no overshoot of the velocity, for a master with this
/// velocity later.
fn ahead(distance: f64, master_velocity: Option<f64>) -> GearInPos {
    let limits = SyncLimits {
        master_velocity,
        ..dynamics(1_000.0, 1e6)
    };
    to_position(
        1.0,
        // τ = 0.4: P1+P5 with a ramp of 0.8 of the distance, 80 u of 100.
        (distance, 0.4 * distance),
        SyncMode::position_based(CHECKED),
        limits,
    )
}

const RESTING: (f64, f64) = (0.0, 0.0);

#[test]
fn what_cannot_be_done_at_the_velocity_of_the_master_is_refused_while_it_stands() {
    let start = moment(RESTING, RESTING);
    for distance in [100.0, -100.0] {
        assert!(
            ahead(distance, None).plan(&start).is_ok(),
            "everything can be done beside one that stands"
        );
        let slow = ahead(distance, Some(50.0))
            .plan(&start)
            .expect("1.5·50²/80 u/s²");
        let same = moment((0.0, 50.0 * distance.signum()), RESTING);
        assert_eq!(
            slow,
            ahead(distance, None).plan(&same).expect("it is as fast")
        );
        let refused = ahead(distance, Some(1_000.0)).plan(&start).unwrap_err();
        assert_eq!(refused.code(), 0x42df, "{refused}");
        let moving = moment((0.0, 1_000.0 * distance.signum()), RESTING);
        assert_eq!(Err(refused), ahead(distance, None).plan(&moving));
    }
    // A moving master has its actual velocity.
    let moving = moment((0.0, 1_000.0), RESTING);
    assert!(ahead(100.0, Some(50.0)).plan(&moving).is_err());
}

#[test]
fn a_velocity_that_the_slave_cannot_have_is_refused_while_the_master_stands() {
    let start = moment(RESTING, RESTING);
    for mode in [SyncMode::default(), SyncMode::time_based(SyncMask::empty())] {
        let fast = |master_velocity| {
            let limits = SyncLimits {
                master_velocity,
                ..SyncLimits::default()
            };
            to_velocity(3.0, mode, limits).plan(&start)
        };
        // 3 · 3000 u/s is below the axis's 1e4, 3 · 4000 above it.
        assert_eq!(fast(None), fast(Some(3_000.0)));
        let refused = fast(Some(4_000.0)).unwrap_err();
        assert!(
            matches!(refused, SawRefusal::SyncVelocity { .. }),
            "{refused}"
        );
    }
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = ahead(100.0, Some(wrong)).plan(&start).unwrap_err();
        assert_eq!(refused.code(), 0x42dd);
        assert!(refused.to_string().contains("master-velocity"), "{refused}");
    }
}

/// The profile begins when the master starts, and is the one that was checked: there is no overshoot of
/// the velocity.
#[test]
fn the_slave_waits_with_its_master_and_is_synchronous_as_planned() {
    let start = moment(RESTING, RESTING);
    let command = ahead(100.0, Some(50.0));
    let tolerances = SawTolerances::default();
    let mut saw = SawCoupling::start(SawCommand::GearInPos(command), &start, tolerances)
        .expect("at 50 u/s it can");
    assert_ne!(saw.plan().form(), SawForm::Quintic);
    let (mut master, dt) = (start.master, 1e-3);
    for cycle in 0..6_000 {
        if cycle >= 100 {
            // Within 100 ms it is at its velocity.
            let faster = (master.velocity + 500.0 * dt).min(50.0);
            master.acceleration = (faster - master.velocity) / dt;
            master.position += 0.5 * (master.velocity + faster) * dt;
            master.velocity = faster;
        }
        let slave = saw.update(&master, Seconds(dt));
        assert!(cycle >= 100 || slave == start.slave, "{slave:?}");
        assert!(slave.velocity <= 50.0 + 1e-9, "{slave:?}");
    }
    assert_eq!(saw.state(), &CommandState::InSync);
    assert!((saw.update(&master, Seconds(dt)).position - (master.position - 60.0)).abs() < 1e-9);
}
