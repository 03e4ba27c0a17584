//! The state diagram in operation.

use std::string::ToString;
use std::vec::Vec;

use super::*;
use crate::{JobError, Refusal, SlaveError};
use coaxle_axis::AxisStatus::{
    self, ContinuousMotion, Disabled, DiscreteMotion, ErrorStop, Homing, Standstill, Stopping,
    SynchronizedMotion,
};
use coaxle_axis::CommandState;
use coaxle_axis::drive::DriveFault;
use coaxle_gear::FlyingGearParameters;
use coaxle_saw::SyncMode;

/// A flying gear for an axis at 0 and a master at 0.
const FLYING: FlyingGearParameters = FlyingGearParameters {
    ratio: 1.0,
    master_sync_position: 100.0,
    slave_sync_position: 40.0,
    slave_desync_position: 200.0,
    slave_stop_position: 250.0,
    default_slave_negative: false,
};

/// An axis in each of the states, with a master at rest.
fn axis_in(status: AxisStatus) -> AxisWithPlates {
    let mut axis = match status {
        Disabled => axis(&PARAMETERS),
        _ => powered(&PARAMETERS),
    };
    let master = Master::at(0.0, 0.0).0;
    axis.update(Some(&master), CYCLE);
    match status {
        Disabled | Standstill => {}
        Homing => {
            start(&mut axis, &Command::Home { position: 0.0 });
        }
        DiscreteMotion => {
            start(&mut axis, &move_absolute(10.0));
        }
        ContinuousMotion => {
            start(&mut axis, &move_velocity(0.0));
            axis.update(Some(&master), CYCLE);
        }
        SynchronizedMotion => {
            start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
        }
        Stopping => {
            start(&mut axis, &STOP);
        }
        ErrorStop => {
            start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
            axis.update(None, CYCLE);
            axis.update(Some(&master), CYCLE);
        }
    }
    assert_eq!(axis.status(), status);
    axis
}

/// Every command in every state: the new state, or the code of the refusal. Columns are the states
/// of [`AxisStatus::ALL`].
#[test]
fn every_command_in_every_state() {
    let commands: [(Command, &str); 13] = [
        //                            Disabled Standst. Homing Discrete Contin. Synchr. Stopping ErrorStop
        (
            Command::Power(true),
            "Standstill Standstill Homing DiscreteMotion ContinuousMotion SynchronizedMotion Stopping ErrorStop",
        ),
        (
            Command::Power(false),
            "Disabled Disabled Stopping Stopping Stopping Stopping Stopping ErrorStop",
        ),
        (
            Command::Reset {},
            "Disabled Standstill Homing DiscreteMotion ContinuousMotion SynchronizedMotion Stopping Standstill",
        ),
        (
            Command::Home { position: 5.0 },
            "422a Homing 4b05 4b05 4b05 4b05 42ef 4b09",
        ),
        (
            move_absolute(5.0),
            "422a DiscreteMotion 4b05 DiscreteMotion DiscreteMotion DiscreteMotion 42ef 4b09",
        ),
        (
            Command::MoveRelative {
                distance: 5.0,
                velocity: None,
                dynamics: OWN,
            },
            "422a DiscreteMotion 4b05 DiscreteMotion DiscreteMotion DiscreteMotion 42ef 4b09",
        ),
        (
            move_velocity(5.0),
            "422a ContinuousMotion 4b05 ContinuousMotion ContinuousMotion ContinuousMotion 42ef 4b09",
        ),
        (
            HALT,
            "422a DiscreteMotion 4b05 DiscreteMotion DiscreteMotion DiscreteMotion 42ef 4b09",
        ),
        (
            STOP,
            "422a Stopping Stopping Stopping Stopping Stopping 42ef 4b09",
        ),
        (
            Command::GearIn(GearIn::of(1.0)),
            "422a SynchronizedMotion 4b05 SynchronizedMotion SynchronizedMotion SynchronizedMotion 42ef 4b09",
        ),
        (
            Command::GearOut {},
            "422a 424d 424d 424d 424d Standstill 42ef 4b09",
        ),
        (
            super::saws::to_velocity(SyncMode::default()),
            "422a SynchronizedMotion 4b05 SynchronizedMotion SynchronizedMotion SynchronizedMotion 42ef 4b09",
        ),
        (
            Command::from(FLYING),
            "422a SynchronizedMotion 4b05 SynchronizedMotion SynchronizedMotion SynchronizedMotion 42ef 4b09",
        ),
    ];
    for (command, expected) in commands {
        let found: Vec<std::string::String> = AxisStatus::ALL
            .into_iter()
            .map(|status| {
                let mut axis = axis_in(status);
                let before = axis.set();
                match axis.command(&command) {
                    Ok(_) => std::format!("{:?}", axis.status()),
                    Err(refusal) => {
                        assert_eq!(axis.status(), status);
                        assert_eq!(axis.set(), before);
                        std::format!("{:x}", refusal.code())
                    }
                }
            })
            .collect();
        assert_eq!(found.join(" "), expected, "{}", command.name());
    }
}

#[test]
fn a_refusal_says_where_the_command_is_possible() {
    let refused = axis_in(Standstill)
        .command(&Command::GearOut {})
        .unwrap_err();
    assert_eq!(
        refused.to_string(),
        "0x424d: MC_GearOut: the axis is in standstill, expected synchronized-motion"
    );
}

#[test]
fn power_taken_away_stops_the_axis_first() {
    let mut axis = powered(&PARAMETERS);
    let job = start(&mut axis, &move_velocity(500.0));
    run(&mut axis, 500);
    axis.command(&Command::Power(false)).unwrap();
    assert_eq!(axis.status(), Stopping);
    assert_eq!(axis.progress(job), CommandState::Aborted);
    run(&mut axis, 50);
    assert!(axis.set().velocity > 0.0, "not at once");
    run(&mut axis, 500);
    assert_eq!(axis.status(), Disabled);
    assert!(!axis.is_operational());
    let stands = axis.set();
    run(&mut axis, 10);
    assert_eq!(axis.set(), stands);
}

#[test]
fn power_given_back_while_it_stops_leaves_it_powered() {
    let mut axis = powered(&PARAMETERS);
    start(&mut axis, &move_velocity(500.0));
    run(&mut axis, 500);
    axis.command(&Command::Power(false)).unwrap();
    run(&mut axis, 10);
    axis.command(&Command::Power(true)).unwrap();
    run(&mut axis, 500);
    assert_eq!(axis.status(), Standstill);
    assert!(axis.is_operational());
}

#[test]
fn a_halt_can_be_taken_over_and_a_stop_cannot() {
    for (command, takes_over) in [(HALT, true), (STOP, false)] {
        let mut axis = powered(&PARAMETERS);
        start(&mut axis, &move_velocity(500.0));
        run(&mut axis, 500);
        let job = start(&mut axis, &command);
        run(&mut axis, 10);
        assert_eq!(axis.command(&move_absolute(0.0)).is_ok(), takes_over);
        run(&mut axis, 3_000);
        assert_eq!(axis.status(), Standstill);
        assert_eq!(axis.set().position == 0.0, takes_over);
        let seen = if takes_over {
            CommandState::Aborted
        } else {
            CommandState::Done
        };
        assert_eq!(axis.progress(job), seen);
    }
}

#[test]
fn an_error_is_latched_until_reset_at_rest() {
    let mut axis = powered(&PARAMETERS);
    let mut master = Master::at(0.0, 0.0);
    master.lead(&mut axis, 1);
    start(&mut axis, &move_velocity(300.0));
    run(&mut axis, 500);
    let mut master = Master::at(0.0, 300.0);
    master.lead(&mut axis, 1);
    let job = start(&mut axis, &Command::GearIn(GearIn::of(1.0)));
    master.lead(&mut axis, 100);
    axis.update(None, CYCLE);
    assert_eq!(axis.status(), ErrorStop);
    assert_eq!(axis.error(), Some(SlaveError::MasterLost));
    assert_eq!(
        axis.progress(job),
        CommandState::Failed(JobError::Failed(SlaveError::MasterLost))
    );
    assert!(matches!(
        axis.command(&Command::Reset {}),
        Err(Refusal::NotAtRest { .. })
    ));
    master.lead(&mut axis, 2_000);
    assert_eq!(
        axis.set().velocity,
        0.0,
        "the master is back, the slave stays"
    );
    assert_eq!(axis.status(), ErrorStop);
    axis.command(&Command::Reset {}).unwrap();
    assert_eq!((axis.status(), axis.error()), (Standstill, None));
    let stands = axis.set();
    master.lead(&mut axis, 100);
    assert_eq!(axis.set(), stands);
    start(&mut axis, &move_absolute(0.0));
}

#[test]
fn a_tripped_drive_is_an_error_stop() {
    let mut axis = AxisWithPlates::new(&PARAMETERS, drive(0.001), cycle_time()).unwrap();
    axis.command(&Command::Power(true)).unwrap();
    let job = start(&mut axis, &move_absolute(500.0));
    run(&mut axis, 2_000);
    assert_eq!(axis.status(), ErrorStop);
    assert!(matches!(
        axis.error(),
        Some(SlaveError::Drive(DriveFault::FollowingError { .. }))
    ));
    assert_eq!(axis.error().unwrap().code(), 0x4550);
    assert!(matches!(axis.progress(job), CommandState::Failed(_)));
    axis.command(&Command::Reset {}).unwrap();
    assert_eq!(axis.status(), Standstill);
    assert_eq!(axis.set().position, axis.actual_position());
    assert!(axis.is_operational());
}

#[test]
fn without_power_wanted_a_reset_leaves_the_axis_disabled() {
    let mut axis = axis_in(ErrorStop);
    axis.command(&Command::Power(false)).unwrap();
    run(&mut axis, 10);
    assert_eq!(axis.status(), ErrorStop);
    axis.command(&Command::Reset {}).unwrap();
    assert_eq!(axis.status(), Disabled);
    axis.command(&Command::Power(true)).unwrap();
    assert_eq!(axis.status(), Standstill);
}

/// A node executes up to 16 orders in a cycle. With four ended jobs kept, ends were not reported, and a
/// job that was done counted as aborted.
#[test]
fn the_end_of_a_job_is_known_after_all_the_orders_of_a_cycle() {
    let mut axis = powered(&PARAMETERS);
    let done = start(&mut axis, &move_absolute(1.0));
    while axis.progress(done) == CommandState::Active {
        run(&mut axis, 1);
    }
    let mut jobs: Vec<_> = (0..17)
        .map(|place| start(&mut axis, &move_absolute(100.0 + f64::from(place))))
        .collect();
    let last = jobs.pop().expect("seventeen");
    run(&mut axis, 1);
    assert_eq!(axis.progress(last), CommandState::Active);
    assert_eq!(axis.progress(done), CommandState::Done);
    let reported: Vec<_> = core::iter::from_fn(|| axis.take_ended()).collect();
    assert_eq!(reported[0].job, done);
    let aborted: Vec<_> = reported[1..].iter().map(|ended| ended.job).collect();
    assert_eq!(aborted, jobs);
}

/// Wide schedules 606458 and 605685: the set position left the drive by what the skipped cycles admit.
#[test]
fn with_power_after_skipped_cycles_a_motion_begins_in_that_scan() {
    let skipped = Seconds(0.07);
    let master = |t: f64| Kinematics {
        position: 300.0 * t,
        velocity: 300.0,
        acceleration: 0.0,
    };
    for command in [
        move_absolute(100.0),
        Command::MoveSuperimposed {
            distance: 100.0,
            velocity: None,
            dynamics: OWN,
        },
        Command::GearIn(GearIn::of(1.0)),
    ] {
        let mut axis = axis(&PARAMETERS);
        axis.update(Some(&master(0.0)), CYCLE);
        start(&mut axis, &Command::Power(true));
        start(&mut axis, &command);
        let mut differences = Differences::of(&axis);
        axis.update(Some(&master(skipped.0)), skipped);
        differences.keep(&axis, &PARAMETERS);
        // A cycle of the jerk: j·T³.
        assert!(axis.set().position.abs() <= 1.001e-4, "{:?}", axis.set());
        for cycle in 1..500 {
            let t = skipped.0 + f64::from(cycle) * CYCLE.0;
            axis.update(Some(&master(t)), CYCLE);
            differences.keep(&axis, &PARAMETERS);
        }
    }
}
