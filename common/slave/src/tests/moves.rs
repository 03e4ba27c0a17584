//! Motions of the axis's own.

use super::*;
use crate::{Outlook, Refusal, SlaveError};
use coaxle_axis::drive::Drive;
use coaxle_axis::guard::{GuardFault, GuardRefusal};
use coaxle_axis::{AxisState, AxisStatus, CommandState, CoupleState, StateWord};
use coaxle_curve::profile::{Limits, to_position};

#[test]
fn a_move_is_the_profile_of_its_limits() {
    let mut axis = powered(&PARAMETERS);
    let job = start(
        &mut axis,
        &Command::MoveAbsolute {
            position: 300.0,
            velocity: Some(200.0),
            dynamics: Dynamics {
                jerk: Some(20_000.0),
                ..OWN
            },
        },
    );
    let limits = Limits::new(200.0, 5_000.0, 4_000.0, 20_000.0).unwrap();
    let profile = to_position(&Kinematics::at_rest(0.0), 300.0, &limits);
    assert_eq!(axis.progress(job), CommandState::Active);
    for k in 1..2_000 {
        let set = axis.update(None, CYCLE);
        let expected = profile.at(Seconds(f64::from(k) * CYCLE.0));
        assert!((set.position - expected.position).abs() < 1e-9);
        assert!((axis.axis_struct(7).target_position - 300.0).abs() < 1e-9);
    }
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    assert_eq!(axis.set(), Kinematics::at_rest(300.0));
    assert!((axis.actual_position() - 300.0).abs() < 1e-6);
}

#[test]
fn a_command_takes_over_from_a_moving_state() {
    let mut axis = powered(&PARAMETERS);
    let first = start(&mut axis, &move_absolute(5_000.0));
    run(&mut axis, 700);
    let moving = axis.set();
    let second = start(
        &mut axis,
        &Command::MoveRelative {
            distance: 100.0,
            velocity: None,
            dynamics: OWN,
        },
    );
    assert_eq!(axis.progress(first), CommandState::Aborted);
    assert!(!axis.was_rolled_back(first));
    run(&mut axis, 3_000);
    assert_eq!(axis.progress(second), CommandState::Done);
    assert!((axis.set().position - (moving.position + 100.0)).abs() < 1e-9);
}

#[test]
fn what_becomes_of_a_motion_is_known() {
    let mut axis = powered(&PARAMETERS);
    assert_eq!(axis.outlook(), Outlook::AtRest);
    start(&mut axis, &move_velocity(-250.0));
    assert_eq!(axis.outlook(), Outlook::UnderWay);
    run(&mut axis, 1_000);
    assert_eq!(axis.outlook(), Outlook::ConstantVelocity(-250.0));
    let mut master = Master::at(0.0, 100.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    assert_eq!(axis.outlook(), Outlook::Led);
    start(&mut axis, &Command::GearOut {});
    master.lead(&mut axis, 1_000);
    assert!(matches!(axis.outlook(), Outlook::ConstantVelocity(_)));
    start(&mut axis, &HALT);
    assert_eq!(axis.outlook(), Outlook::UnderWay);
    run(&mut axis, 1_000);
    assert_eq!(axis.outlook(), Outlook::AtRest);
    assert!(axis.is_power_on());
    start(&mut axis, &Command::Power(false));
    assert!(!axis.is_power_on());
}

#[test]
fn a_velocity_is_kept_without_an_end() {
    let mut axis = powered(&PARAMETERS);
    let job = start(&mut axis, &move_velocity(-400.0));
    assert_eq!(axis.progress(job), CommandState::Active);
    run(&mut axis, 10_000);
    assert_eq!(axis.progress(job), CommandState::InSync);
    assert_eq!(axis.status(), AxisStatus::ContinuousMotion);
    assert_eq!(axis.set().velocity, -400.0);
    let image = axis.axis_struct(3);
    assert_eq!(image.axis_state, AxisState::ConstantVelocity);
    assert_eq!(image.couple_state, CoupleState::Single);
    assert!(image.state_word.contains(
        StateWord::CONTINUOUS_MOTION | StateWord::NEGATIVE_DIRECTION | StateWord::OPERATIONAL
    ));
    assert_eq!(image.target_position, image.set_position);
}

#[test]
fn homing_says_where_the_axis_stands_and_moves_nothing() {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_absolute(10.0));
    run(&mut axis, 2_000);
    let job = start(&mut axis, &Command::Home { position: -3.0 });
    assert_eq!(axis.status(), AxisStatus::Homing);
    let before = axis.actual().position;
    run(&mut axis, 5);
    assert_eq!(axis.progress(job), CommandState::Done);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    assert_eq!(axis.set().position, -3.0);
    assert!((axis.actual_position() + 3.0).abs() < 1e-6);
    assert!((axis.actual().position - before).abs() < 1e-9);
    assert!(axis.axis_struct(1).state_word.contains(StateWord::HOMED));
    start(&mut axis, &move_absolute(0.0));
    run(&mut axis, 2_000);
    assert!((axis.actual().position - before - 3.0).abs() < 1e-6);
}

#[test]
fn targets_and_ways_beyond_the_software_limits_are_refused() {
    let mut axis = powered(&LIMITED);
    for command in [
        move_absolute(1_000.1),
        move_absolute(-100.1),
        Command::Home { position: 2_000.0 },
    ] {
        let refused = axis.command(&command).unwrap_err();
        assert_eq!(refused.code(), 0x4229, "{refused}");
    }
    start(&mut axis, &move_absolute(1_000.0));
    run(&mut axis, 5_000);
    assert_eq!(axis.set().position, 1_000.0);
    // From speed towards the limit a gentle return would lead beyond it; the axis uses its own dynamics.
    start(&mut axis, &move_absolute(0.0));
    run(&mut axis, 5_000);
    start(&mut axis, &move_velocity(1_000.0));
    while axis.set().position < 780.0 {
        run(&mut axis, 1);
    }
    start(
        &mut axis,
        &Command::MoveAbsolute {
            position: 0.0,
            velocity: None,
            dynamics: Dynamics {
                deceleration: Some(100.0),
                ..OWN
            },
        },
    );
    let mut highest = 0.0_f64;
    for _ in 0..5_000 {
        highest = highest.max(axis.update(None, CYCLE).position);
    }
    assert!(highest <= 1_000.0, "{highest}");
    assert_eq!(axis.set(), Kinematics::at_rest(0.0));
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn continuous_motion_is_braked_before_the_software_limit() {
    let mut axis = powered(&LIMITED);
    let job = start(&mut axis, &move_velocity(1_000.0));
    run(&mut axis, 5_000);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    let Some(SlaveError::Guard(GuardFault::SoftwareLimit { limit, .. })) = axis.error() else {
        panic!("{:?}", axis.error());
    };
    assert_eq!(limit, 1_000.0);
    assert!(matches!(axis.progress(job), CommandState::Failed(_)));
    let rest = axis.set();
    assert!((998.0..=1_000.0).contains(&rest.position), "{rest:?}");
    assert_eq!(axis.axis_struct(1).error_code, 0x4229);
    axis.command(&Command::Reset {}).unwrap();
    start(&mut axis, &move_absolute(500.0));
}

#[test]
fn an_axis_beyond_a_software_limit_may_only_come_back() {
    // A drive that was moved by another configuration.
    let mut drive = drive(0.0);
    drive.power_on(50.0, 0.0);
    drive.reset();
    let narrow = SlaveParameters {
        max_position: Some(20.0),
        ..PARAMETERS
    };
    let mut axis = AxisWithPlates::new(&narrow, drive, cycle_time()).unwrap();
    axis.command(&Command::Power(true)).unwrap();
    assert!(axis.set().position > 49.0);
    assert!(
        axis.axis_struct(1)
            .state_word
            .contains(StateWord::SOFT_LIMIT_MAX_EXCEEDED)
    );
    assert!(axis.command(&move_absolute(49.0)).is_err());
    start(&mut axis, &move_absolute(10.0));
    run(&mut axis, 2_000);
    assert_eq!(axis.set().position, 10.0);
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn values_that_no_axis_can_take_are_named() {
    let mut axis = powered(&PARAMETERS);
    let value = |axis: &mut AxisWithPlates, command: &Command| match axis.command(command) {
        Err(Refusal::Guard(
            GuardRefusal::Value { field, .. } | GuardRefusal::AboveLimit { field, .. },
        )) => field,
        other => panic!("{other:?}"),
    };
    assert_eq!(value(&mut axis, &move_absolute(f64::NAN)), "position");
    assert_eq!(value(&mut axis, &move_absolute(1e300)), "position");
    assert_eq!(value(&mut axis, &move_velocity(f64::NAN)), "velocity");
    assert_eq!(value(&mut axis, &move_velocity(1_000.1)), "velocity");
    for (dynamics, field) in [
        (
            Dynamics {
                jerk: Some(-1.0),
                ..OWN
            },
            "jerk",
        ),
        (
            Dynamics {
                acceleration: Some(f64::NAN),
                ..OWN
            },
            "acceleration",
        ),
        (
            Dynamics {
                deceleration: Some(1e6),
                ..OWN
            },
            "deceleration",
        ),
    ] {
        assert_eq!(value(&mut axis, &Command::Halt { dynamics }), field);
    }
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn parameters_that_no_axis_can_have_are_named() {
    for (parameters, named) in [
        (
            SlaveParameters {
                velocity: 0.0,
                ..PARAMETERS
            },
            "velocity",
        ),
        (
            SlaveParameters {
                deceleration: Some(f64::NAN),
                ..PARAMETERS
            },
            "deceleration",
        ),
        (
            SlaveParameters {
                jerk: 1e300,
                ..PARAMETERS
            },
            "jerk",
        ),
        (
            SlaveParameters {
                min_position: Some(f64::INFINITY),
                ..PARAMETERS
            },
            "min-position",
        ),
        (
            SlaveParameters {
                max_position: Some(-100.0),
                ..LIMITED
            },
            "max-position",
        ),
    ] {
        let wrong = AxisWithPlates::new(&parameters, drive(0.0), cycle_time()).unwrap_err();
        assert_eq!(wrong.parameter, named);
    }
}
