//! A distance that is added to any motion of the axis.

use super::*;
use crate::Refusal;
use coaxle_axis::{AxisStatus, CommandState};
use std::string::ToString;

fn superimposed(distance: f64) -> Command {
    Command::MoveSuperimposed {
        distance,
        velocity: Some(50.0),
        dynamics: OWN,
    }
}

fn run_within(axis: &mut AxisWithPlates, cycles: u32) {
    let mut differences = Differences::of(axis);
    for _ in 0..cycles {
        axis.update(None, CYCLE);
        differences.keep(axis, &PARAMETERS);
    }
}

#[test]
fn a_coupled_axis_gets_a_distance_more() {
    let mut axis = powered(&PARAMETERS);
    let mut master = Master::at(0.0, 300.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    master.lead(&mut axis, 500);
    let apart = axis.set().position - master.0.position;
    let gear = axis.job().0.unwrap();
    let job = start(&mut axis, &superimposed(-20.0));
    let mut differences = Differences::of(&axis);
    for _ in 0..1_000 {
        master.lead(&mut axis, 1);
        differences.keep(&axis, &PARAMETERS);
    }
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.progress(gear), CommandState::InSync);
    assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
    assert!((axis.set().position - master.0.position - apart + 20.0).abs() < 1e-9);
}

#[test]
fn a_motion_of_its_own_ends_as_much_farther() {
    let mut axis = powered(&PARAMETERS);
    let slowly = Dynamics {
        acceleration: Some(1_000.0),
        deceleration: Some(1_000.0),
        jerk: Some(20_000.0),
    };
    let base = start(
        &mut axis,
        &Command::MoveAbsolute {
            position: 300.0,
            velocity: Some(200.0),
            dynamics: slowly,
        },
    );
    run(&mut axis, 400);
    let added = Dynamics {
        acceleration: Some(1_000.0),
        deceleration: Some(1_000.0),
        jerk: Some(50_000.0),
    };
    let job = start(
        &mut axis,
        &Command::MoveSuperimposed {
            distance: 100.0,
            velocity: Some(40.0),
            dynamics: added,
        },
    );
    assert_eq!(axis.axis_struct(1).target_position, 400.0);
    run_within(&mut axis, 1_700);
    assert_eq!(axis.status(), AxisStatus::DiscreteMotion, "one is not over");
    run_within(&mut axis, 2_000);
    assert_eq!(axis.progress(base), CommandState::Done);
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    assert_eq!(axis.set(), Kinematics::at_rest(400.0));
}

#[test]
fn an_axis_at_rest_goes_the_distance() {
    let mut axis = powered(&PARAMETERS);
    let job = start(&mut axis, &superimposed(12.5));
    assert_eq!(axis.status(), AxisStatus::DiscreteMotion);
    run_within(&mut axis, 1_000);
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    assert_eq!(axis.set(), Kinematics::at_rest(12.5));
    // The next one begins there.
    start(&mut axis, &move_absolute(0.0));
    run_within(&mut axis, 1_000);
    assert_eq!(axis.set(), Kinematics::at_rest(0.0));
}

#[test]
fn it_is_cut_short_by_the_next_motion_and_goes_on_in_it() {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_velocity(100.0));
    run(&mut axis, 300);
    let job = start(&mut axis, &superimposed(50.0));
    let mut differences = Differences::of(&axis);
    for cycle in 0..800 {
        if cycle == 100 {
            assert!(axis.set().velocity > 140.0);
            start(&mut axis, &HALT);
            assert_eq!(axis.progress(job), CommandState::Aborted);
        }
        axis.update(None, CYCLE);
        differences.keep(&axis, &PARAMETERS);
    }
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn what_leaves_the_limits_is_refused() {
    let mut axis = powered(&LIMITED);
    let too_far = superimposed(1_200.0);
    assert_eq!(axis.plan(&too_far).unwrap_err().code(), 0x4229);
    // A motion that needs the whole acceleration leaves none.
    start(&mut axis, &move_absolute(900.0));
    assert_eq!(axis.plan(&superimposed(10.0)).unwrap_err().code(), 0x42dd);
    let stopping = {
        let mut axis = powered(&LIMITED);
        start(&mut axis, &STOP);
        axis
    };
    assert_eq!(
        stopping.plan(&superimposed(1.0)).unwrap_err().code(),
        0x42ef
    );
}

#[test]
fn what_a_motion_of_its_own_leaves_of_the_jerk_is_all_there_is() {
    let base = |jerk| Command::MoveAbsolute {
        position: 300.0,
        velocity: Some(200.0),
        dynamics: Dynamics {
            acceleration: Some(1_000.0),
            deceleration: Some(1_000.0),
            jerk: Some(jerk),
        },
    };
    for moment in (10..1_500).step_by(89) {
        let mut axis = powered(&PARAMETERS);
        start(&mut axis, &base(60_000.0));
        let mut differences = Differences::of(&axis);
        for _ in 0..moment {
            run(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        start(&mut axis, &superimposed(5.0));
        for _ in 0..1_000 {
            run(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
    }
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &base(100_000.0));
    run(&mut axis, 10);
    let refused = axis.plan(&superimposed(5.0)).unwrap_err();
    assert!(
        std::string::ToString::to_string(&refused)
            .starts_with("0x42dd: jerk: the motion under way takes 100000")
    );
}

/// A move that uses the whole acceleration leaves none: the refusal names a valid value, which then
/// passes.
#[test]
fn what_leaves_nothing_to_add_with_is_said_with_what_would() {
    let begin = |acceleration: f64| {
        let mut axis = powered(&PARAMETERS);
        let dynamics = Dynamics {
            acceleration: Some(acceleration),
            deceleration: Some(acceleration),
            jerk: Some(50_000.0),
        };
        let base = Command::MoveAbsolute {
            position: 500.0,
            velocity: Some(400.0),
            dynamics,
        };
        start(&mut axis, &base);
        run(&mut axis, 20);
        axis
    };
    let refused = begin(4_000.0).command(&superimposed(5.0)).unwrap_err();
    let Refusal::NothingLeft { field, passes, .. } = refused else {
        panic!("{refused}");
    };
    assert_eq!((field, refused.code()), ("acceleration", 0x42dd));
    assert!(
        refused
            .to_string()
            .contains("takes 4000, expected at most 3996"),
        "{refused}"
    );
    let mut axis = begin(passes - 1.0);
    let job = start(&mut axis, &superimposed(5.0));
    run_within(&mut axis, 20_000);
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.set(), Kinematics::at_rest(505.0));
}
