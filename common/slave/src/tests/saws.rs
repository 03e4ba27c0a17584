//! The axis as a flying saw.

use super::*;
use crate::{CouplingFault, CouplingPhase, CouplingRefusal, JobError, Refusal, SlaveError};
use coaxle_axis::{AxisState, AxisStatus, CommandState, CoupleState};
use coaxle_saw::{Check, GearInPos, GearInVelo, Ratio, SawFault, SyncLimits, SyncMask, SyncMode};

pub(super) fn to_position(sync: (f64, f64), mask: SyncMask) -> GearInPos {
    GearInPos {
        ratio: Ratio::of(1.0),
        master_sync_position: sync.0,
        slave_sync_position: sync.1,
        master_start_distance: None,
        strategy: None,
        sync_mode: SyncMode::position_based(mask),
        limits: SyncLimits::default(),
    }
}

pub(super) fn to_velocity(sync_mode: SyncMode) -> Command {
    Command::GearInVelo(GearInVelo {
        ratio: Ratio::of(1.0),
        sync_mode,
        limits: SyncLimits::default(),
    })
}

/// An axis with power, and a master at a velocity.
pub(super) fn beside(parameters: &SlaveParameters, velocity: f64) -> (AxisWithPlates, Master) {
    let mut axis = powered(parameters);
    let mut master = Master::at(0.0, velocity);
    master.lead(&mut axis, 1);
    (axis, master)
}

/// Couples the axis to positions ahead, and waits until it is in sync.
fn in_sync(axis: &mut AxisWithPlates, master: &mut Master, sync: (f64, f64)) -> Job {
    let job = start(axis, &Command::from(to_position(sync, SyncMask::empty())));
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
    // While coupled, it can be coupled again.
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
    // The path back leads below the software limit.
    let far = to_position((9_000.0, 900.0), SyncMask::DETAILED_ERROR_CODES);
    let too_near = to_position((30.0, 60.0), SyncMask::empty());
    let behind = to_position((-1.0, 60.0), SyncMask::empty());
    for (command, code) in [(far, 0x4372), (too_near, 0x42df), (behind, 0x42de)] {
        let refused = axis.command(&Command::from(command)).unwrap_err();
        assert_eq!(refused.code(), code, "{refused}");
        assert_eq!(std::format!("{axis:?}"), before);
    }
}

#[test]
fn a_lost_master_is_an_error_stop_while_synchronising() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    let command = to_position((400.0, 150.0), SyncMask::empty());
    let job = start(&mut axis, &Command::from(command));
    master.lead(&mut axis, 300);
    assert_eq!(axis.coupling_phase(), Some(CouplingPhase::Synchronizing));
    axis.update(None, CYCLE);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    assert_eq!(
        axis.progress(job),
        CommandState::Failed(JobError::Failed(SlaveError::MasterLost))
    );
    master.lead(&mut axis, 1_000);
    assert_eq!(axis.set().velocity, 0.0);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
}

#[test]
fn a_saw_needs_a_master() {
    let mut axis = powered(&PARAMETERS);
    let command = Command::from(to_position((10.0, 10.0), SyncMask::empty()));
    assert_eq!(axis.command(&command).unwrap_err(), Refusal::NoMaster);
    let read = Command::ReadFlyingSawCharacteristics {};
    assert_eq!(axis.command(&read).unwrap_err(), Refusal::NoCharacteristics);
}

#[test]
fn a_wait_for_the_start_distance_that_ends_in_a_refusal_leaves_the_velocity() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    start(&mut axis, &move_velocity(50.0));
    master.lead(&mut axis, 200);
    let command = GearInPos {
        master_start_distance: Some(100.0),
        ..to_position((300.0, 150.0), SyncMask::empty())
    };
    let job = start(&mut axis, &Command::from(command));
    assert_eq!(axis.progress(job), CommandState::Waiting);
    assert_eq!(axis.axis_struct(1).axis_state, AxisState::SlavePrephase);
    // At twice the expected velocity, the master leaves the slave less time than it needs.
    for _ in 0..1_000 {
        master.0.velocity += 0.9;
        master.lead(&mut axis, 1);
    }
    let CommandState::Failed(JobError::Refused(Refusal::Coupling(CouplingRefusal::Saw(refusal)))) =
        axis.progress(job)
    else {
        panic!("{:?}", axis.progress(job));
    };
    assert_eq!(refusal.violation().map(|v| v.check), Some(Check::MaxVelo));
    assert_eq!(axis.status(), AxisStatus::ContinuousMotion);
    assert_eq!((axis.set().velocity, axis.error()), (50.0, None));
}

#[test]
fn what_the_master_does_to_a_synchronised_slave_may_be_too_much_for_it() {
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    in_sync(&mut axis, &mut master, (400.0, 150.0));
    master.0.velocity = 1_100.0;
    master.lead(&mut axis, 1);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    let Some(SlaveError::Coupling(CouplingFault::Saw(SawFault::Limit(violation)))) = axis.error()
    else {
        panic!("{:?}", axis.error());
    };
    assert_eq!(
        (violation.check, violation.code()),
        (Check::MaxVelo, 0x42df)
    );
    assert_eq!(violation.limit, 1_000.0);

    // Before a software limit it is braked in time.
    let (mut axis, mut master) = beside(&LIMITED, 200.0);
    in_sync(&mut axis, &mut master, (400.0, 150.0));
    master.lead(&mut axis, 10_000);
    assert_eq!(axis.error().map(|error| error.code()), Some(0x4229));
    assert!((999.0..=1_000.0).contains(&axis.set().position));
}

#[test]
fn a_plate_in_the_place_of_the_saws_table_refuses_it() {
    let (mut axis, _) = beside(&PARAMETERS, 200.0);
    let plate = super::cams::plate(10.0);
    let mut tables = coaxle_cam::Tables::new(1);
    tables.insert(253, plate).unwrap();
    axis.select_cams(tables, 1, 3).unwrap();
    let command = Command::from(to_position((400.0, 150.0), SyncMask::empty()));
    assert_eq!(axis.command(&command).map_err(|r| r.code()), Err(0x4063));
}

#[test]
fn an_encoders_noise_is_no_acceleration_of_the_master() {
    let noisy = Kinematics {
        acceleration: 1_500.0,
        ..Master::at(0.0, 200.0).0
    };
    let plan = |master_increment| {
        let mut axis = powered(&SlaveParameters {
            master_increment,
            ..PARAMETERS
        });
        axis.update(Some(&noisy), CYCLE);
        let mask = SyncMask::OVERSHOOT_VELO | SyncMask::UNDERSHOOT_VELO;
        let command = to_position((400.0, 150.0), mask);
        let change = axis.plan(&Command::from(command)).ok()?;
        change.saw_plan().map(|plan| plan.form())
    };
    use coaxle_saw::SawForm;
    assert_eq!(plan(Some(0.001)), Some(SawForm::LineQuintic));
    assert_ne!(plan(None), Some(SawForm::LineQuintic));
}

#[test]
fn a_saw_keeps_the_limits_of_the_axis_whatever_is_checked() {
    let prefer = SyncMask::PREFER_CONST_VELO;
    let masks = [
        SyncMask::empty(),
        prefer,
        prefer | SyncMask::MAX_VELO,
        SyncMask::OVERSHOOT_VELO,
        SyncMask::MAX_VELO,
    ];
    let mut accepted = 0;
    for mask in masks {
        for (way, share) in [(60.0, 0.5), (100.0, 0.5), (150.0, 1.3), (400.0, 0.4)] {
            for limits in [None, Some(1e7)] {
                let (mut axis, mut master) = beside(&PARAMETERS, 400.0);
                let sync = (master.0.position + way, axis.set().position + share * way);
                let mut command = to_position(sync, mask);
                command.limits.jerk = limits;
                let command = Command::from(command);
                let mut differences = Differences::of(&axis);
                for _ in 0..5 {
                    differences.keep(&axis, &PARAMETERS);
                }
                match axis.command(&command) {
                    Ok(_) => accepted += 1,
                    Err(refusal) => assert_eq!(refusal.code(), 0x42df, "{refusal}"),
                }
                for _ in 0..2_000 {
                    master.lead(&mut axis, 1);
                    differences.keep(&axis, &PARAMETERS);
                }
                assert_eq!(axis.error(), None);
            }
        }
    }
    assert!(accepted > 10, "{accepted}");
}
