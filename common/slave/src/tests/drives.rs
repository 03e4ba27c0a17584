//! Drives of any kind: they take time to switch on, fail, and report arbitrary values.

use std::string::ToString;
use std::sync::{Arc, Mutex};
use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::{CoupledStart, Refusal, SlaveError};
use coaxle_axis::drive::{Actual, Drive, DriveFault, DriveState};
use coaxle_axis::{AxisStatus, CommandState};
use coaxle_gear::LinearGear;

/// A drive that reports the values set by a test, and records its commands.
#[derive(Clone, Debug, Default)]
struct Puppet(Arc<Mutex<Said>>);

#[derive(Debug, Default)]
struct Said {
    actual: Actual,
    powered: bool,
    resets: u32,
    set: Kinematics,
}

impl Drive for Puppet {
    fn power_on(&mut self, _: f64, _: f64) {
        self.0.lock().unwrap().powered = true;
    }

    fn reset(&mut self) {
        let mut said = self.0.lock().unwrap();
        said.powered = false;
        said.resets += 1;
    }

    fn step(&mut self, set: &Kinematics, _: Seconds) {
        self.0.lock().unwrap().set = *set;
    }

    fn actual(&self) -> Actual {
        self.0.lock().unwrap().actual
    }
}

impl Puppet {
    fn says(&self, state: DriveState, position: f64) {
        let mut said = self.0.lock().unwrap();
        (said.actual.state, said.actual.position) = (state, position);
    }

    fn is_powered(&self) -> bool {
        self.0.lock().unwrap().powered
    }
}

fn with_puppet(parameters: &SlaveParameters) -> (AxisWithPlates, Puppet) {
    let puppet = Puppet::default();
    let drive = Box::new(puppet.clone());
    let axis = AxisWithPlates::new(parameters, drive, cycle_time()).expect("in range");
    (axis, puppet)
}

/// An axis at standstill at 7.
fn standing() -> (AxisWithPlates, Puppet) {
    let (mut axis, puppet) = with_puppet(&PARAMETERS);
    puppet.says(DriveState::Following, 7.0);
    start(&mut axis, &Command::Power(true));
    run(&mut axis, 1);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    (axis, puppet)
}

#[test]
fn an_axis_has_power_when_its_drive_follows() {
    let (mut axis, puppet) = with_puppet(&PARAMETERS);
    puppet.says(DriveState::Off, 5.0);
    run(&mut axis, 1);
    start(&mut axis, &Command::Power(true));
    assert!(puppet.is_powered());
    puppet.says(DriveState::SwitchingOn, 6.0);
    run(&mut axis, 3);
    assert_eq!(axis.status(), AxisStatus::Disabled);
    assert!(!axis.is_operational());
    assert_eq!(axis.set(), Kinematics::at_rest(6.0), "where the drive is");
    assert_eq!(
        axis.command(&move_absolute(9.0)).unwrap_err().code(),
        0x422a
    );
    puppet.says(DriveState::Following, 6.5);
    run(&mut axis, 1);
    assert_eq!(axis.status(), AxisStatus::Standstill);
    assert!(axis.is_operational());
    assert_eq!(axis.set(), Kinematics::at_rest(6.5));
    start(&mut axis, &move_absolute(9.0));
}

#[test]
fn power_can_be_taken_back_while_the_drive_switches_on() {
    let (mut axis, puppet) = with_puppet(&PARAMETERS);
    start(&mut axis, &Command::Power(true));
    puppet.says(DriveState::SwitchingOn, 0.0);
    run(&mut axis, 3);
    start(&mut axis, &Command::Power(false));
    assert!(!puppet.is_powered());
    puppet.says(DriveState::Off, 0.0);
    run(&mut axis, 3);
    assert_eq!((axis.status(), axis.error()), (AxisStatus::Disabled, None));
}

#[test]
fn a_drive_that_fails_in_motion_is_an_error_stop_within_the_limits() {
    let fault = DriveFault::Silent { cycles: 6, most: 5 };
    for (state, expected) in [
        (DriveState::Tripped, fault),
        (DriveState::Off, DriveFault::PowerLost),
        (DriveState::SwitchingOn, DriveFault::PowerLost),
    ] {
        let (mut axis, puppet) = standing();
        let job = start(&mut axis, &move_velocity(500.0));
        run(&mut axis, 500);
        puppet.says(state, 100.0);
        if state == DriveState::Tripped {
            puppet.0.lock().unwrap().actual.fault = Some(fault);
        }
        let mut differences = Differences::of(&axis);
        for _ in 0..1_000 {
            run(&mut axis, 1);
            differences.keep(&axis, &PARAMETERS);
        }
        assert_eq!(axis.status(), AxisStatus::ErrorStop);
        assert_eq!(axis.error(), Some(SlaveError::Drive(expected)));
        assert_eq!(axis.axis_struct(1).error_code, expected.code());
        assert!(matches!(axis.progress(job), CommandState::Failed(_)));
        assert_eq!(axis.set().velocity, 0.0);
        // The drive is back: the axis waits for the reset, and then for the drive.
        puppet.0.lock().unwrap().actual.fault = None;
        puppet.says(DriveState::Off, 100.0);
        run(&mut axis, 10);
        assert_eq!(axis.status(), AxisStatus::ErrorStop);
        start(&mut axis, &Command::Reset {});
        assert!(puppet.is_powered());
        puppet.says(DriveState::SwitchingOn, 100.0);
        run(&mut axis, 2);
        assert_eq!((axis.status(), axis.error()), (AxisStatus::Disabled, None));
        puppet.says(DriveState::Following, 100.0);
        run(&mut axis, 1);
        assert_eq!(axis.status(), AxisStatus::Standstill);
        assert_eq!(axis.set(), Kinematics::at_rest(100.0));
    }
}

#[test]
fn values_that_cannot_be_are_a_fault_and_change_nothing() {
    let (mut axis, puppet) = standing();
    puppet.says(DriveState::Following, f64::NAN);
    run(&mut axis, 1);
    assert_eq!(axis.status(), AxisStatus::ErrorStop);
    assert_eq!(
        axis.error().unwrap().to_string(),
        "0x4655: actual position of the drive: received NaN, expected a number from -1e12 to 1e12"
    );
    assert_eq!(axis.actual_position(), 7.0, "the last one that could be");
    puppet.says(DriveState::Following, 7.0);
    start(&mut axis, &Command::Reset {});
    run(&mut axis, 1);
    assert_eq!(axis.status(), AxisStatus::Standstill);
}

#[test]
fn no_coupling_from_the_start_has_a_drive_jump() {
    let gear = CoupledStart::Gear(LinearGear::new(1.0, 0.0).expect("a gear"));
    let master = Master::at(50.0, 100.0).0;
    let (mut axis, puppet) = with_puppet(&PARAMETERS);
    for (state, position) in [
        (DriveState::SwitchingOn, 50.0),
        (DriveState::Following, 0.0),
    ] {
        puppet.says(state, position);
        let refused = axis.switch_on_coupled(&gear, Some(&master)).unwrap_err();
        let Refusal::DriveElsewhere { expected, .. } = refused else {
            panic!("{refused}");
        };
        assert_eq!((expected, axis.status()), (50.0, AxisStatus::Disabled));
        assert!(!puppet.is_powered());
    }
    puppet.says(DriveState::Following, 50.5);
    axis.switch_on_coupled(&gear, Some(&master)).unwrap();
    assert_eq!(axis.status(), AxisStatus::SynchronizedMotion);
}

fn states() -> impl Strategy<Value = DriveState> {
    prop_oneof![
        4 => Just(DriveState::Following),
        1 => Just(DriveState::SwitchingOn),
        1 => Just(DriveState::Off),
        1 => Just(DriveState::Tripped),
    ]
}

fn values() -> impl Strategy<Value = f64> {
    prop_oneof![3 => -2e3..2e3_f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(1e300)]
}

fn commands() -> impl Strategy<Value = Option<Command>> {
    prop_oneof![
        20 => Just(None),
        2 => Just(Some(Command::Power(true))),
        1 => Just(Some(Command::Power(false))),
        2 => Just(Some(Command::Reset {})),
        2 => (-200.0..1_200.0_f64).prop_map(|position| Some(move_absolute(position))),
        2 => (-900.0..900.0_f64).prop_map(|velocity| Some(move_velocity(velocity))),
        1 => Just(Some(HALT)),
    ]
}

proptest! {
    /// For any values of a drive, the set values of an axis with power keep its limits.
    #[test]
    fn whatever_the_drive_says(
        life in proptest::collection::vec((states(), values(), values(), commands(), 1_u32..40), 1..80)
    ) {
        let (mut axis, puppet) = with_puppet(&LIMITED);
        let mut told: Vec<Kinematics> = Vec::new();
        for (state, position, velocity, command, cycles) in life {
            {
                let mut said = puppet.0.lock().unwrap();
                (said.actual.state, said.actual.position) = (state, position);
                (said.actual.velocity, said.actual.following_error) = (velocity, -velocity);
            }
            if let Some(command) = command {
                let _ = axis.command(&command);
            }
            for _ in 0..cycles {
                let (before, status) = (axis.set(), axis.status());
                let was_powered = puppet.is_powered();
                run(&mut axis, 1);
                let set = axis.set();
                told.push(puppet.0.lock().unwrap().set);
                prop_assert!(set.position.is_finite() && set.velocity.is_finite());
                prop_assert!((-100.0..=1_000.0).contains(&set.position), "{}", set.position);
                // Without power the set position is the actual one.
                if status != AxisStatus::Disabled && was_powered && puppet.is_powered() {
                    let step = (set.position - before.position).abs();
                    prop_assert!(step <= 1_000.0 * CYCLE.0 * (1.0 + 1e-6), "{step}");
                    let change = (set.velocity - before.velocity).abs();
                    prop_assert!(change <= 5_000.0 * CYCLE.0 * (1.0 + 1e-6) + 1e-9, "{change}");
                }
            }
        }
        prop_assert!(told.iter().all(|set| set.position.is_finite()));
    }
}
