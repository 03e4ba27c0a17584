//! The axis on cam plates.

use super::*;
use crate::{CamPoints, CoupledStart, CouplingPhase, JobError, Refusal, SlaveError};
use coaxle_axis::{AxisStatus, CommandState, Origin, StateWord};
use coaxle_cam::{
    Activation, ActivationMode, AxisScaling, CamIn, CamInV2, CamRemove, CamScaling, JumpHandling,
    OnlineChangeMode, ScalingData, Tables,
};
use coaxle_gear::LinearGear;
use coaxle_plate::{Course, MotionFunction, MotionPoint, Plate};
use std::vec::Vec;

pub(super) fn plate(top: f64) -> Plate {
    let points = Vec::from([
        MotionPoint::rest(1, 0.0, 0.0),
        MotionPoint::rest(2, 100.0, top),
        MotionPoint::rest(3, 200.0, 0.0),
    ]);
    let function = MotionFunction::new(points).expect("a motion function");
    Plate::from_function(function, Course::Cyclic)
}

/// An axis at rest at 0 with the plates 1 (up to 40 u) and 2 (up to 30 u), and a master at 200 u/s.
fn rig() -> (AxisWithPlates, Master) {
    let mut axis = powered(&PARAMETERS);
    let mut tables = Tables::new(2);
    tables.insert(1, plate(40.0)).expect("room");
    tables.insert(2, plate(30.0)).expect("room");
    axis.select_cams(tables, 7, 8).expect("limits");
    let mut master = Master::at(-20.0, 200.0);
    master.lead(&mut axis, 1);
    (axis, master)
}

pub(super) fn next_cycle() -> Activation {
    Activation::new(ActivationMode::NextCycle)
}

fn cam_in(table: u32) -> CamIn {
    CamIn {
        table,
        activation: next_cycle(),
        ..CamIn::default()
    }
}

/// Leads the axis; returns the largest step that its velocities do not explain.
fn lead(axis: &mut AxisWithPlates, master: &mut Master, cycles: u32) -> f64 {
    let mut largest = 0.0_f64;
    for _ in 0..cycles {
        let before = axis.set();
        master.lead(axis, 1);
        let way = 0.5 * CYCLE.0 * (before.velocity + axis.set().velocity);
        largest = largest.max((axis.set().position - before.position - way).abs());
    }
    largest
}

#[test]
fn an_axis_is_coupled_switched_scaled_and_edited_without_a_jump() {
    let (mut axis, mut master) = rig();
    let job = start(&mut axis, &Command::CamIn(cam_in(1)));
    assert_eq!(axis.progress(job), CommandState::Waiting);
    assert_eq!(axis.coupling_phase(), Some(CouplingPhase::Waiting));
    let image = axis.axis_struct(8);
    assert!(image.state_word.contains(StateWord::CAM_TABLE_QUEUED));
    let mut jump = lead(&mut axis, &mut master, 600);
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert!((axis.set().position - 40.0).abs() < 0.1, "{:?}", axis.set());

    let scale = CamScaling {
        activation: next_cycle(),
        scaling: ScalingData {
            slave: AxisScaling {
                scaling: 1.5,
                ..AxisScaling::default()
            },
            ..ScalingData::default()
        },
        ..CamScaling::default()
    };
    let change = start(&mut axis, &Command::CamScaling(scale));
    assert_eq!(axis.progress(change), CommandState::Active);
    jump = jump.max(lead(&mut axis, &mut master, 1_000));
    assert_eq!(axis.progress(change), CommandState::Done);
    assert!((axis.set().position - 60.0).abs() < 0.1, "{:?}", axis.set());

    let mode = OnlineChangeMode {
        activation: next_cycle(),
        ..OnlineChangeMode::default()
    };
    let points = CamPoints::new(&[MotionPoint::rest(2, 100.0, 20.0)]).expect("a point");
    for command in [
        Command::SetCamOnlineChangeMode { table: 1, mode },
        Command::WriteMotionFunction { table: 1, points },
    ] {
        let job = start(&mut axis, &command);
        assert_eq!(axis.progress(job), CommandState::Done);
    }
    jump = jump.max(lead(&mut axis, &mut master, 1_000));
    assert!((axis.set().position - 30.0).abs() < 0.1, "{:?}", axis.set());

    let switched = start(&mut axis, &Command::CamIn(cam_in(2)));
    assert_eq!(axis.progress(switched), CommandState::Active);
    jump = jump.max(lead(&mut axis, &mut master, 1_000));
    assert!((axis.set().position - 30.0).abs() < 0.1, "{:?}", axis.set());
    assert!(jump < 1e-3, "{jump}");
    assert_eq!(
        (axis.status(), axis.error()),
        (AxisStatus::SynchronizedMotion, None)
    );
}

#[test]
fn a_plate_is_left_at_the_velocity_it_has() {
    let (mut axis, mut master) = rig();
    start(&mut axis, &Command::CamIn(cam_in(1)));
    lead(&mut axis, &mut master, 300);
    let before = axis.set();
    assert!(before.velocity > 1.0);
    start(&mut axis, &Command::CamOut {});
    assert_eq!(axis.status(), AxisStatus::ContinuousMotion);
    lead(&mut axis, &mut master, 100);
    assert_eq!(axis.set().velocity, before.velocity);
    assert_eq!(axis.coupling_phase(), None);
    // The plates are not in use any more.
    start(&mut axis, &HALT);
    lead(&mut axis, &mut master, 500);
    let apart = -axis.set().position;
    start(
        &mut axis,
        &Command::MoveRelative {
            distance: apart,
            velocity: None,
            dynamics: OWN,
        },
    );
    lead(&mut axis, &mut master, 1_000);
    start(&mut axis, &Command::CamIn(cam_in(2)));
}

#[test]
fn without_its_last_plate_the_axis_is_on_its_own() {
    let (mut axis, mut master) = rig();
    let in_v2 = CamInV2 {
        table: 1,
        activation: next_cycle(),
        ..CamInV2::default()
    };
    let job = start(&mut axis, &Command::CamInV2(in_v2));
    lead(&mut axis, &mut master, 600);
    let remove = CamRemove {
        table: 1,
        activation: next_cycle(),
        ..CamRemove::default()
    };
    let removed = start(&mut axis, &Command::CamRemove(remove));
    let jump = lead(&mut axis, &mut master, 1_000);
    assert!(jump < 1e-3, "{jump}");
    assert_eq!(axis.coupling_phase(), None);
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.progress(removed), CommandState::Done);
    assert!(axis.set().velocity.abs() < 1e-6, "{:?}", axis.set());
}

#[test]
fn a_coupling_that_would_jump_is_refused_when_it_is_due() {
    let (mut axis, mut master) = rig();
    let far_off = CamIn {
        slave_offset: 100.0,
        ..cam_in(1)
    };
    let job = start(&mut axis, &Command::CamIn(far_off));
    lead(&mut axis, &mut master, 200);
    let CommandState::Failed(JobError::Refused(error)) = axis.progress(job) else {
        panic!("{:?}", axis.progress(job));
    };
    assert_eq!(error.code(), 0x421a);
    assert_eq!(
        (axis.status(), axis.error()),
        (AxisStatus::Standstill, None)
    );
    assert_eq!(axis.set(), Kinematics::at_rest(0.0));
    let ramp_in = CamIn {
        jump: JumpHandling::RampIn {
            master_length: 200.0,
        },
        ..far_off
    };
    let job = start(&mut axis, &Command::CamIn(ramp_in));
    let jump = lead(&mut axis, &mut master, 1_000);
    assert_eq!(axis.progress(job), CommandState::Active);
    lead(&mut axis, &mut master, 1_100);
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert!(jump < 1e-3, "{jump}");
}

#[test]
fn what_concerns_no_coupling_or_no_plate_is_refused() {
    let (mut axis, _) = rig();
    let code = |answer: Result<Job, Refusal>| answer.unwrap_err().code();
    let scaling = Command::CamScaling(CamScaling::default());
    assert_eq!(code(axis.command(&scaling)), 0x4256);
    assert_eq!(code(axis.command(&Command::CamIn(cam_in(3)))), 0x4216);
    let mode = OnlineChangeMode::default();
    let of_none = Command::SetCamOnlineChangeMode { table: 3, mode };
    assert_eq!(code(axis.command(&of_none)), 0x4216);
    assert_eq!(code(axis.command(&Command::CamOut {})), 0x424d);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    assert!(
        CamPoints::new(&[]).is_err()
            && CamPoints::new(&[MotionPoint::rest(1, 0.0, 0.0); 5]).is_err()
    );
}

#[test]
fn a_lost_master_breaks_the_coupling_and_reset_clears_it() {
    let (mut axis, mut master) = rig();
    start(&mut axis, &Command::CamIn(cam_in(1)));
    lead(&mut axis, &mut master, 300);
    run(&mut axis, 500);
    assert_eq!(axis.error(), Some(SlaveError::MasterLost));
    let info = axis.cam_info(0, None);
    assert_eq!(
        info.map(|info| info.table),
        Ok(1),
        "what it was can still be asked"
    );
    start(&mut axis, &Command::Reset {});
    let info = axis.cam_info(0, None);
    assert!(info.is_err());
    let away = -axis.set().position;
    start(
        &mut axis,
        &Command::MoveRelative {
            distance: away,
            velocity: None,
            dynamics: OWN,
        },
    );
    lead(&mut axis, &mut master, 1_000);
    let job = start(&mut axis, &Command::CamIn(cam_in(1)));
    lead(&mut axis, &mut master, 1_100);
    assert_eq!(axis.progress(job), CommandState::InSync);
}

#[test]
fn an_axis_can_be_coupled_from_the_start() {
    let gear = LinearGear::new(0.5, 10.0).expect("a gear");
    let instantly = CamIn {
        activation: Activation::default(),
        ..cam_in(1)
    };
    for (with, position) in [
        (CoupledStart::Gear(gear), 60.0),
        (CoupledStart::Cam(instantly), 40.0),
    ] {
        let mut axis = axis(&PARAMETERS);
        let mut tables = Tables::new(1);
        tables.insert(1, plate(40.0)).expect("room");
        axis.select_cams(tables, 7, 8).expect("limits");
        let mut master = Master::at(100.0, 200.0);
        let job = axis.switch_on_coupled(&with, Some(&master.0)).unwrap();
        assert_eq!(job.origin, Origin::Start);
        assert_eq!(axis.set().position, position);
        let jump = lead(&mut axis, &mut master, 200);
        assert!(jump < 1e-3, "{jump}");
        assert_eq!(axis.progress(job), CommandState::InSync);
        assert!(axis.actual().following_error.abs() < 1.0);
        assert!(
            axis.switch_on_coupled(&with, Some(&master.0)).is_err(),
            "once"
        );
    }
    let mut limited = axis(&LIMITED);
    let refused =
        limited.switch_on_coupled(&CoupledStart::Gear(gear), Some(&Master::at(1e4, 0.0).0));
    assert_eq!(refused.unwrap_err().code(), 0x4229);
    let refused =
        limited.switch_on_coupled(&CoupledStart::Gear(gear), Some(&Master::at(0.0, 1e4).0));
    assert_eq!(refused.unwrap_err().code(), 0x42dd);
    // Half a unit before the limit, at a speed that needs more.
    let gear = LinearGear::new(1.0, 0.0).expect("a gear");
    let near = Master::at(LIMITED.max_position.unwrap() - 0.5, 80.0);
    let refused = limited.switch_on_coupled(&CoupledStart::Gear(gear), Some(&near.0));
    assert_eq!(refused.unwrap_err().code(), 0x4229);
    assert_eq!(limited.status(), AxisStatus::Disabled);
}
