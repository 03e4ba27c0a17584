//! A flying saw in a custom loop: a conveyor in, set values for a drive out, cut after cut.
//!
//! `cargo run -p coaxle-slave --example saw_in_your_loop`
//!
//! The loop is complete: it takes masters and the elapsed time once per cycle, and returns the set
//! values. It does not allocate, wait or read a clock, so that it can run in any cycle.

use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_axis::{CommandState, Job, Origin};
use coaxle_cam::Tables;
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_saw::{GearInPos, Ratio, SyncLimits, SyncMode};
use coaxle_slave::{Command, Dynamics, Refusal, SlaveAxis, SlaveParameters};

/// Length of the pieces, mm.
const LENGTH: f64 = 1_000.0;
/// Waiting position of the saw, mm, and its synchronous position.
const HOME: f64 = 0.0;
const SYNCHRONOUS: f64 = 150.0;
/// Duration of the cut.
const CUT: Seconds = Seconds(0.4);

/// Current task of the saw.
enum Task {
    Synchronise,
    WaitUntilSynchronous(Job),
    Cut { left: f64 },
    Return(Job),
}

/// Result of a cut.
pub(crate) struct Cut {
    /// Position of the material under the blade during the cut, mm of the conveyor.
    pub(crate) place: f64,
    /// Slip of the blade along the material during the cut, mm.
    pub(crate) slip: f64,
}

/// A saw with its conveyor.
pub(crate) struct Station {
    axis: SlaveAxis,
    /// Store of cam plates: this axis needs none.
    plates: Tables,
    task: Task,
    next_cut: f64,
    began: f64,
}

impl Station {
    /// Creates a powered saw with its limits.
    ///
    /// # Errors
    /// Invalid parameters.
    pub(crate) fn new(cycle: CycleTime) -> Result<Self, Box<dyn std::error::Error>> {
        let parameters = SlaveParameters {
            min_position: Some(-10.0),
            max_position: Some(900.0),
            ..SlaveParameters::new(2_000.0, 10_000.0, 500_000.0)
        };
        let drive = Box::new(SimulatedDrive::new(DriveParameters::default())?);
        let mut axis = SlaveAxis::new(&parameters, drive, cycle)?;
        let mut plates = Tables::new(0);
        axis.command(&mut plates, &Command::Power(true))?;
        Ok(Self {
            axis,
            plates,
            task: Task::Synchronise,
            next_cut: LENGTH,
            began: 0.0,
        })
    }

    /// Runs one cycle: takes the conveyor, returns the set values for the drive, and a cut when one
    /// is done.
    ///
    /// # Errors
    /// A command that the axis refuses.
    pub(crate) fn cycle(
        &mut self,
        conveyor: &Kinematics,
        elapsed: Seconds,
    ) -> Result<(Kinematics, Option<Cut>), Refusal> {
        let set = self.axis.update(&mut self.plates, Some(conveyor), elapsed);
        Ok((set, self.work(conveyor, elapsed)?))
    }

    fn work(&mut self, conveyor: &Kinematics, elapsed: Seconds) -> Result<Option<Cut>, Refusal> {
        // Position of the blade on the conveyor, relative to the material.
        let blade = conveyor.position - (self.axis.set().position - SYNCHRONOUS);
        match &mut self.task {
            Task::Synchronise => {
                let saw = Command::from(GearInPos {
                    ratio: Ratio::of(1.0),
                    master_sync_position: self.next_cut,
                    slave_sync_position: SYNCHRONOUS,
                    // At this distance the ramp is symmetric, and the saw never runs backwards.
                    master_start_distance: Some(2.0 * SYNCHRONOUS - HOME),
                    strategy: None,
                    sync_mode: SyncMode::default(),
                    limits: SyncLimits::default(),
                });
                // Plan, then apply: a plan that is dropped was a dry run.
                let change = self.axis.plan(&self.plates, &saw)?;
                let job = self.axis.apply(&mut self.plates, change, Origin::Program);
                self.task = Task::WaitUntilSynchronous(job);
            }
            Task::WaitUntilSynchronous(job) => {
                if self.axis.progress(*job) == CommandState::InSync {
                    self.began = blade;
                    self.task = Task::Cut { left: CUT.0 };
                }
            }
            Task::Cut { left } => {
                *left -= elapsed.0;
                if *left <= 0.0 {
                    let home = Command::MoveAbsolute {
                        position: HOME,
                        velocity: None,
                        dynamics: Dynamics::default(),
                    };
                    self.task = Task::Return(self.axis.command(&mut self.plates, &home)?);
                    self.next_cut += LENGTH;
                    let slip = blade - self.began;
                    return Ok(Some(Cut { place: blade, slip }));
                }
            }
            Task::Return(job) => {
                if self.axis.progress(*job) == CommandState::Done {
                    self.task = Task::Synchronise;
                }
            }
        }
        Ok(None)
    }
}

/// Cuts for this number of seconds; the conveyor runs at 500 mm/s.
///
/// # Errors
/// The errors of the station.
pub(crate) fn run(seconds: f64) -> Result<Vec<Cut>, Box<dyn std::error::Error>> {
    let (cycle, elapsed) = (CycleTime::new(Span::from_millis(1))?, Seconds(0.001));
    let mut station = Station::new(cycle)?;
    let mut conveyor = Kinematics {
        position: 0.0,
        velocity: 500.0,
        acceleration: 0.0,
    };
    let mut cuts = Vec::new();
    for _ in 0..(seconds / elapsed.0) as u64 {
        conveyor.position += conveyor.velocity * elapsed.0;
        let (_set_values, cut) = station.cycle(&conveyor, elapsed)?;
        cuts.extend(cut);
    }
    Ok(cuts)
}

#[allow(dead_code, reason = "a test runs the station without it")]
#[allow(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for cut in run(20.0)? {
        println!("cut at {:.6} mm, slip {:.1e} mm", cut.place, cut.slip);
    }
    Ok(())
}
