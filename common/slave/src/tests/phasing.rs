//! A shift of the master as the coupled slave sees it.

use super::*;
use crate::{JobError, Refusal, SlaveError};
use coaxle_axis::{AxisStatus, CommandState};

fn by(shift: f64) -> Command {
    Command::PhasingRelative {
        shift,
        velocity: None,
        dynamics: OWN,
    }
}

fn to(shift: f64) -> Command {
    Command::PhasingAbsolute {
        shift,
        velocity: Some(40.0),
        dynamics: OWN,
    }
}

/// An axis coupled by a ratio of 0.5 to a master at 200 u/s.
fn coupled() -> (AxisWithPlates, Master) {
    let mut axis = powered(&PARAMETERS);
    let mut master = Master::at(0.0, 200.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &Command::GearIn(GearIn::of(0.5)));
    master.lead(&mut axis, 500);
    (axis, master)
}

fn lead(axis: &mut AxisWithPlates, master: &mut Master, cycles: u32) {
    let mut differences = Differences::of(axis);
    for _ in 0..cycles {
        master.lead(axis, 1);
        differences.keep(axis, &PARAMETERS);
    }
}

fn apart(axis: &AxisWithPlates, master: &Master) -> f64 {
    axis.set().position - 0.5 * master.0.position
}

#[test]
fn the_slave_is_led_as_if_its_master_were_ahead() {
    let (mut axis, mut master) = coupled();
    let gear = axis.job().0.unwrap();
    let before = apart(&axis, &master);
    let job = start(&mut axis, &by(30.0));
    assert_eq!(axis.progress(job), CommandState::Active);
    lead(&mut axis, &mut master, 1_000);
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.progress(gear), CommandState::InSync);
    assert!((apart(&axis, &master) - before - 15.0).abs() < 1e-9);
    let back = start(&mut axis, &to(0.0));
    lead(&mut axis, &mut master, 500);
    assert_eq!(axis.progress(back), CommandState::Active, "at 40 u/s");
    lead(&mut axis, &mut master, 1_000);
    assert_eq!(axis.progress(back), CommandState::Done);
    assert!((apart(&axis, &master) - before).abs() < 1e-9);
    assert_eq!(axis.error(), None);
}

#[test]
fn another_shift_takes_over_on_the_way() {
    let (mut axis, mut master) = coupled();
    let before = apart(&axis, &master);
    let first = start(&mut axis, &to(50.0));
    let mut differences = Differences::of(&axis);
    for cycle in 0..3_000 {
        if cycle == 300 {
            let second = start(&mut axis, &to(-10.0));
            assert_eq!(axis.progress(first), CommandState::Aborted);
            assert_eq!(axis.progress(second), CommandState::Active);
        }
        master.lead(&mut axis, 1);
        differences.keep(&axis, &PARAMETERS);
    }
    assert!((apart(&axis, &master) - before + 5.0).abs() < 1e-9);
}

#[test]
fn it_ends_with_the_coupling() {
    let (mut axis, mut master) = coupled();
    let job = start(&mut axis, &by(30.0));
    lead(&mut axis, &mut master, 50);
    let before = axis.set();
    start(&mut axis, &Command::GearOut {});
    assert_eq!(axis.progress(job), CommandState::Aborted);
    master.lead(&mut axis, 1);
    assert!((axis.set().velocity - before.velocity).abs() < 5.0);
    // The next coupling sees its master unshifted.
    start(&mut axis, &Command::GearIn(GearIn::of(0.5)));
    lead(&mut axis, &mut master, 500);
    assert_eq!(axis.job().1, CommandState::InSync);

    let (mut axis, mut master) = coupled();
    let job = start(&mut axis, &by(30.0));
    master.lead(&mut axis, 20);
    axis.update(None, CYCLE);
    let failed = CommandState::Failed(JobError::Failed(SlaveError::MasterLost));
    assert_eq!(axis.progress(job), failed);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
}

#[test]
fn what_leaves_the_limits_or_shifts_nothing_is_refused() {
    let (axis, _) = coupled();
    let fast = |velocity| Command::PhasingRelative {
        shift: 10.0,
        velocity: Some(velocity),
        dynamics: OWN,
    };
    // 990 u/s less 100 u/s of the slave are 1780 u/s of the master.
    assert!(axis.plan(&fast(1_779.0)).is_ok());
    assert_eq!(axis.plan(&fast(1_781.0)).unwrap_err().code(), 0x42dd);
    let alone = powered(&PARAMETERS);
    let refused = alone.plan(&by(1.0)).unwrap_err();
    assert_eq!(refused.code(), 0x424d);
    assert!(matches!(refused, Refusal::Status { .. }));
}

#[test]
fn on_a_plate_its_dynamics_have_to_be_given() {
    let mut axis = powered(&PARAMETERS);
    let mut tables = coaxle_cam::Tables::new(1);
    tables.insert(1, super::cams::plate(40.0)).unwrap();
    axis.select_cams(tables, 7, 8).unwrap();
    let mut master = Master::at(0.0, 200.0);
    master.lead(&mut axis, 1);
    let cam_in = coaxle_cam::CamIn {
        table: 1,
        ..coaxle_cam::CamIn::default()
    };
    start(&mut axis, &Command::CamIn(cam_in));
    master.lead(&mut axis, 100);
    assert_eq!(
        axis.plan(&by(10.0)).unwrap_err(),
        Refusal::NotGiven {
            field: "acceleration"
        }
    );
    let given = Command::PhasingRelative {
        shift: 10.0,
        velocity: Some(50.0),
        dynamics: Dynamics {
            acceleration: Some(500.0),
            deceleration: None,
            jerk: Some(10_000.0),
        },
    };
    let job = start(&mut axis, &given);
    master.lead(&mut axis, 1_000);
    assert_eq!(axis.progress(job), CommandState::Done);
    let seen = axis.cam_info(1, None).unwrap().master_axis_position;
    assert!((seen - master.0.position - 10.0).abs() < 1e-9);
}
