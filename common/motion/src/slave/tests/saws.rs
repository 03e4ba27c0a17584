//! The axis as a flying saw.

use super::*;
use crate::axis::{AxisState, AxisStatus, CoupleState};
use crate::plc::CommandState;
use crate::saw::{GearInPos, GearInVelo, Ratio, SyncLimits, SyncMask, SyncMode};
use crate::slave::{CouplingPhase, Refusal, SlaveError};

fn to_position(sync: (f64, f64), mask: SyncMask) -> GearInPos {
    GearInPos {
        ratio: Ratio::of(1.0),
        master_sync_position: sync.0,
        slave_sync_position: sync.1,
        master_start_distance: None,
        sync_mode: SyncMode::position_based(mask),
        limits: SyncLimits::default(),
    }
}

fn to_velocity(sync_mode: SyncMode) -> Command {
    Command::GearInVelo(GearInVelo {
        ratio: Ratio::of(1.0),
        sync_mode,
        limits: SyncLimits::default(),
    })
}

/// An axis with power, and a master at a velocity.
fn beside(parameters: &SlaveParameters, velocity: f64) -> (SlaveAxis, Master) {
    let mut axis = powered(parameters);
    let mut master = Master::at(0.0, velocity);
    master.lead(&mut axis, 1);
    (axis, master)
}

/// Couples the axis to positions that lie ahead, and waits until it is in sync.
fn in_sync(axis: &mut SlaveAxis, master: &mut Master, sync: (f64, f64)) -> JobNumber {
    let job = start(
        axis,
        &Command::GearInPos(to_position(sync, SyncMask::empty())),
    );
    while axis.progress(job) != CommandState::InSync {
        assert_eq!(axis.progress(job), CommandState::Active);
        assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
        master.lead(axis, 1);
    }
    job
}

#[test]
fn a_saw_couples_an_axis_at_rest_and_leaves_it_its_velocity() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    let job = in_sync(&mut axis, &mut master, (400.0, 150.0));
    master.lead(&mut axis, 500);
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert_eq!(axis.coupling_phase(), Some(CouplingPhase::InSync));
    assert!((axis.set().position - 150.0 - (master.0.position - 400.0)).abs() < 1e-9);
    let image = axis.axis_struct(1);
    assert_eq!(image.axis_state, AxisState::SlaveSynchronous);
    assert_eq!(image.couple_state, CoupleState::Slave);

    let out = start(&mut axis, &Command::GearOut {});
    assert_eq!(axis.progress(out), CommandState::Done);
    assert_eq!(axis.progress(job), CommandState::Aborted);
    assert_eq!(axis.status(), AxisStatus::ContinuousMotion);
    master.0.velocity = 0.0;
    master.lead(&mut axis, 100);
    assert_eq!((axis.set().velocity, axis.set().acceleration), (200.0, 0.0));
    assert_eq!(axis.axis_struct(1).axis_state, AxisState::ConstantVelocity);
    assert!(axis.saw_plan().is_some());
}

#[test]
fn the_next_cut_is_synchronised_during_the_return() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    in_sync(&mut axis, &mut master, (400.0, 150.0));
    master.lead(&mut axis, 500);
    start(&mut axis, &Command::GearOut {});
    start(&mut axis, &move_absolute(0.0));
    while axis.set().velocity > -100.0 {
        master.lead(&mut axis, 1);
    }
    let before = axis.set();
    assert_eq!(axis.status(), AxisStatus::DiscreteMotion);
    let next = (master.0.position + 300.0, 300.0);
    let job = in_sync(&mut axis, &mut master, next);
    let plan = axis.saw_plan().unwrap();
    assert_eq!(plan.slave_start(), &before);
    assert!((axis.set().position - next.1 - (master.0.position - next.0)).abs() < 1e-9);
    // Coupled as it is, it can be coupled anew.
    let further = (master.0.position + 300.0, axis.set().position + 330.0);
    in_sync(&mut axis, &mut master, further);
    assert_eq!(axis.progress(job), CommandState::Aborted);
    assert_eq!(axis.error(), None);
}

#[test]
fn every_motion_of_its_own_can_turn_into_a_saw() {
    let motions = [
        move_absolute(500.0),
        move_velocity(-150.0),
        move_velocity(300.0),
        HALT,
    ];
    for motion in motions {
        for mode in [
            SyncMode::position_based(SyncMask::empty()),
            SyncMode::time_based(SyncMask::empty()),
        ] {
            let (mut axis, mut master) = beside(&PARAMETERS, 200.0);
            start(&mut axis, &move_velocity(100.0));
            master.lead(&mut axis, 500);
            start(&mut axis, &motion);
            master.lead(&mut axis, 50);
            let job = start(&mut axis, &to_velocity(mode));
            master.lead(&mut axis, 2_000);
            assert_eq!(
                axis.progress(job),
                CommandState::InSync,
                "{motion:?} {mode:?}"
            );
            assert!((axis.set().velocity - 200.0).abs() < 1e-9);
        }
    }
}

#[test]
fn a_refused_saw_leaves_the_axis_as_it_is() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    start(&mut axis, &move_velocity(-50.0));
    master.lead(&mut axis, 100);
    let before = std::format!("{axis:?}");
    // The way back leads below the software limit.
    let far = to_position((9_000.0, 900.0), SyncMask::DETAILED_ERROR_CODES);
    let too_near = to_position((30.0, 60.0), SyncMask::empty());
    let behind = to_position((-1.0, 60.0), SyncMask::empty());
    for (command, code) in [(far, 0x4372), (too_near, 0x42df), (behind, 0x42de)] {
        let refused = axis.command(&Command::GearInPos(command)).unwrap_err();
        assert_eq!(refused.code(), code, "{refused}");
        assert_eq!(std::format!("{axis:?}"), before);
    }
}

#[test]
fn a_lost_master_is_an_error_stop_while_synchronising() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    let command = to_position((400.0, 150.0), SyncMask::empty());
    let job = start(&mut axis, &Command::GearInPos(command));
    master.lead(&mut axis, 300);
    assert_eq!(axis.coupling_phase(), Some(CouplingPhase::Synchronizing));
    axis.update(None, CYCLE);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    assert_eq!(
        axis.progress(job),
        CommandState::Failed(SlaveError::MasterLost)
    );
    master.lead(&mut axis, 1_000);
    assert_eq!(axis.set().velocity, 0.0);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
}

#[test]
fn a_saw_needs_a_master() {
    let mut axis = powered(&PARAMETERS);
    let command = Command::GearInPos(to_position((10.0, 10.0), SyncMask::empty()));
    assert_eq!(axis.command(&command), Err(Refusal::NoMaster));
    let read = Command::ReadFlyingSawCharacteristics {};
    assert_eq!(axis.command(&read), Err(Refusal::NoCharacteristics));
}
