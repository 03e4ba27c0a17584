//! A flying saw in a loop of your own: a conveyor in, set values for a drive out, cut after cut.
//!
//! `cargo run -p coaxle-slave --example saw_in_your_loop`
//!
//! The loop is all there is: masters and the elapsed time go in once per cycle, the set values come
//! out. Nothing here allocates, waits or asks a clock, so that it can run in any cycle.

use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_axis::{CommandState, Job, Origin};
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_saw::{GearInPos, Ratio, SyncLimits, SyncMode};
use coaxle_slave::{Command, Dynamics, Refusal, SlaveAxis, SlaveParameters};

/// The pieces are so long, mm.
const LENGTH: f64 = 1_000.0;
/// The saw stands here while it waits, mm, and is synchronous here.
const HOME: f64 = 0.0;
const SYNCHRONOUS: f64 = 150.0;
/// The cut takes so long.
const CUT: Seconds = Seconds(0.4);

/// What the saw is busy with.
enum Task {
    Synchronise,
    WaitUntilSynchronous(Job),
    Cut { left: f64 },
    Return(Job),
}

/// What comes of it.
pub(crate) struct Cut {
    /// Where the material is under the blade while it cuts, mm of the conveyor.
    pub(crate) place: f64,
    /// How far the blade slid along the material during the cut, mm.
    pub(crate) slip: f64,
}

/// A saw beside its conveyor.
pub(crate) struct Station {
    axis: SlaveAxis,
    task: Task,
    next_cut: f64,
    began: f64,
}

impl Station {
    /// A saw that can do so much, powered.
    ///
    /// # Errors
    /// What no axis can be.
    pub(crate) fn new(cycle: CycleTime) -> Result<Self, Box<dyn std::error::Error>> {
        let parameters = SlaveParameters {
            min_position: Some(-10.0),
            max_position: Some(900.0),
            ..SlaveParameters::new(2_000.0, 10_000.0, 500_000.0)
        };
        let drive = Box::new(SimulatedDrive::new(DriveParameters::default())?);
        let mut axis = SlaveAxis::new(&parameters, drive, cycle)?;
        axis.command(&Command::Power(true))?;
        Ok(Self {
            axis,
            task: Task::Synchronise,
            next_cut: LENGTH,
            began: 0.0,
        })
    }

    /// One cycle: the conveyor in, the set values for the drive out, and a cut when one is done.
    ///
    /// # Errors
    /// A command that the axis refuses.
    pub(crate) fn cycle(
        &mut self,
        conveyor: &Kinematics,
        elapsed: Seconds,
    ) -> Result<(Kinematics, Option<Cut>), Refusal> {
        let set = self.axis.update(Some(conveyor), elapsed);
        Ok((set, self.work(conveyor, elapsed)?))
    }

    fn work(&mut self, conveyor: &Kinematics, elapsed: Seconds) -> Result<Option<Cut>, Refusal> {
        // Where on the conveyor the blade is, seen from the material.
        let blade = conveyor.position - (self.axis.set().position - SYNCHRONOUS);
        match &mut self.task {
            Task::Synchronise => {
                let saw = Command::from(GearInPos {
                    ratio: Ratio::of(1.0),
                    master_sync_position: self.next_cut,
                    slave_sync_position: SYNCHRONOUS,
                    // So far ahead the ramp is symmetric, and the saw never runs backwards.
                    master_start_distance: Some(2.0 * SYNCHRONOUS - HOME),
                    strategy: None,
                    sync_mode: SyncMode::default(),
                    limits: SyncLimits::default(),
                });
                // Plan, then apply: a plan that is dropped was a dry run.
                let change = self.axis.plan(&saw)?;
                let job = self.axis.apply(change, Origin::Program);
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
                    self.task = Task::Return(self.axis.command(&home)?);
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

/// Cuts for so many seconds; the conveyor runs at 500 mm/s.
///
/// # Errors
/// What the station says.
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
