//! Behaviour of a slave axis, and its guarantees.

mod cam_in_turn;
mod cam_limits;
mod cam_select;
mod cam_start_modes;
mod cams;
mod circle;
mod coupled;
mod decades;
mod differences;
mod drives;
mod dry_run;
mod hand_over;
mod hand_over_random;
mod held_back;
mod invariants;
mod life_cycle;
mod moves;
mod multi_master;
mod own_plates;
mod phasing;
mod ripple;
mod saw_rollback;
mod saws;
mod shared_cams;
mod stops;
mod stops_random;
mod strategies;
mod superimposed;
mod sync_positions;

use std::boxed::Box;

use coaxle_clock::{CycleTime, Seconds, Span};

use self::differences::Differences;
use self::own_plates::AxisWithPlates;
use super::{Command, Dynamics, OnMasterLoss, SlaveParameters};
use coaxle_axis::Job;
use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_curve::profile::Kinematics;
use coaxle_gear::GearIn;

const CYCLE: Seconds = Seconds(1e-3);

const PARAMETERS: SlaveParameters = SlaveParameters {
    deceleration: Some(4_000.0),
    ..SlaveParameters::new(1_000.0, 5_000.0, 100_000.0)
};

const LIMITED: SlaveParameters = SlaveParameters {
    min_position: Some(-100.0),
    max_position: Some(1_000.0),
    ..PARAMETERS
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

fn axis(parameters: &SlaveParameters) -> AxisWithPlates {
    AxisWithPlates::new(parameters, drive(0.0), cycle_time()).expect("the parameters are in range")
}

/// An axis at rest at 0, with power.
fn powered(parameters: &SlaveParameters) -> AxisWithPlates {
    let mut axis = axis(parameters);
    start(&mut axis, &Command::Power(true));
    axis
}

/// Sends a command that must be accepted.
fn start(axis: &mut AxisWithPlates, command: &Command) -> Job {
    match axis.command(command) {
        Ok(job) => job,
        Err(refusal) => panic!("{command:?}: {refusal}"),
    }
}

fn run(axis: &mut AxisWithPlates, cycles: u32) {
    for _ in 0..cycles {
        axis.update(None, CYCLE);
    }
}

/// A master at constant velocity.
#[derive(Clone, Copy)]
struct Master(Kinematics);

impl Master {
    fn at(position: f64, velocity: f64) -> Self {
        Self(Kinematics {
            position,
            velocity,
            acceleration: 0.0,
        })
    }

    fn lead(&mut self, axis: &mut AxisWithPlates, cycles: u32) {
        for _ in 0..cycles {
            self.0.position += self.0.velocity * CYCLE.0;
            axis.update(Some(&self.0), CYCLE);
        }
    }

    /// Runs one cycle in which it is led towards an acceleration with at most this jerk.
    fn accelerate(&mut self, axis: &mut AxisWithPlates, acceleration: f64, jerk: f64) {
        let (dt, before) = (CYCLE.0, self.0);
        let most = jerk * dt;
        let change = (acceleration - before.acceleration).clamp(-most, most);
        self.0 = Kinematics {
            position: before.position
                + dt * (before.velocity + dt * (before.acceleration / 2.0 + change / 6.0)),
            velocity: before.velocity + dt * (before.acceleration + change / 2.0),
            acceleration: before.acceleration + change,
        };
        axis.update(Some(&self.0), CYCLE);
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

const HALT: Command = Command::Halt { dynamics: OWN };
const STOP: Command = Command::Stop { dynamics: OWN };
