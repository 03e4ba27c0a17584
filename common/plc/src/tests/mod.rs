//! Blocks as a PLC program calls them, on an axis beside a master.

mod axis;
mod cams;
mod multi_master;
mod saw;

use std::boxed::Box;

use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_axis::{Dynamics, Job};
use coaxle_cam::Tables;
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_slave::{Command, JobError, SlaveAxis, SlaveParameters};

const CYCLE: Seconds = Seconds(1e-3);

pub(crate) const PARAMETERS: SlaveParameters = SlaveParameters {
    deceleration: Some(4_000.0),
    ..SlaveParameters::new(1_000.0, 5_000.0, 100_000.0)
};

fn cycle_time() -> CycleTime {
    CycleTime::new(Span::from_millis(1)).expect("1 ms is a cycle time")
}

fn drive(window: f64) -> Box<SimulatedDrive> {
    let drive = SimulatedDrive::new(DriveParameters {
        following_error_window: window,
        ..DriveParameters::default()
    });
    Box::new(drive.expect("the constants are in range"))
}

fn axis(parameters: &SlaveParameters) -> SlaveAxis {
    SlaveAxis::new(parameters, drive(0.0), cycle_time()).expect("the parameters are in range")
}

/// Makes an axis at rest at 0, with power.
pub(crate) fn powered(parameters: &SlaveParameters) -> SlaveAxis {
    let mut axis = axis(parameters);
    start(&mut axis, &Command::Power(true));
    axis
}

/// Commands the axis and expects acceptance.
fn start(axis: &mut SlaveAxis, command: &Command) -> Job {
    match axis.command(&mut Tables::new(0), command) {
        Ok(job) => job,
        Err(refusal) => panic!("{command:?}: {refusal}"),
    }
}

fn run(axis: &mut SlaveAxis, cycles: u32) {
    for _ in 0..cycles {
        axis.update(&mut Tables::new(0), None, CYCLE);
    }
}

/// A master at constant velocity.
#[derive(Clone, Copy)]
pub(crate) struct Master(Kinematics);

impl Master {
    pub(crate) fn at(position: f64, velocity: f64) -> Self {
        Self(Kinematics {
            position,
            velocity,
            acceleration: 0.0,
        })
    }

    pub(crate) fn lead(&mut self, axis: &mut SlaveAxis, cycles: u32) {
        for _ in 0..cycles {
            self.0.position += self.0.velocity * CYCLE.0;
            axis.update(&mut Tables::new(0), Some(&self.0), CYCLE);
        }
    }
}

const fn move_absolute(position: f64) -> Command {
    Command::MoveAbsolute {
        position,
        velocity: None,
        dynamics: OWN,
    }
}

const fn move_velocity(velocity: f64) -> Command {
    Command::MoveVelocity {
        velocity,
        dynamics: OWN,
    }
}

/// The axis's own dynamics.
const OWN: Dynamics = Dynamics {
    acceleration: None,
    deceleration: None,
    jerk: None,
};

const STOP: Command = Command::Stop { dynamics: OWN };
