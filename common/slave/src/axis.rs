//! The slave axis itself.

mod commands;
mod cycle;
mod dry_run;
mod saw;
mod start;

use coaxle_clock::{CycleTime, Seconds};

use coaxle_axis::drive::{Drive, DriveState};
use coaxle_axis::{AxisStatus, CommandState, CouplingPhase, StateMachine, StateWord, Transition};
use coaxle_cam::{self as cam, CamCoupling, CouplingState, Tables, Ticket};
use coaxle_curve::profile::{Kinematics, Profile};
use coaxle_saw::{SawCommand, SawPlan, SawRefusal, saw_table_id};

use super::command::Command;
use super::coupling::Coupling;
use super::error::SlaveError;
use super::job::{Job, JobNumber};
use super::motion::{Motion, Planned};
use super::parameters::{MasterTraits, OnMasterLoss, SlaveParameters, WrongSlaveParameter};
use super::refusal::Refusal;
use coaxle_axis::guard::Guard;
use coaxle_cam::Cams;

pub use start::CoupledStart;

/// A slave axis with its drive.
#[derive(Debug)]
pub struct SlaveAxis {
    guard: Guard,
    on_master_loss: OnMasterLoss,
    cycle_time: f64,
    drive: Drive,
    /// The axis's position where the drive's is 0: homing shifts it.
    drive_zero: f64,
    state: StateMachine,
    /// What `MC_Power` asks for.
    powered: bool,
    homed: bool,
    /// `MC_Stop` is still executed: the axis stays in `Stopping`.
    stop_held: bool,
    set: Kinematics,
    motion: Motion,
    cams: Cams,
    /// What a flying saw has to know of the master.
    master_traits: MasterTraits,
    /// The flying saw before, for `MC_ReadFlyingSawCharacteristics`.
    last_saw: Option<SawPlan>,
    /// The table that a flying saw needs is one of the plates.
    saw_table_in_use: Option<u32>,
    job: Job,
    /// The master at the last update: of the same moment as the set values.
    master: Option<Kinematics>,
    error: Option<SlaveError>,
}

/// What an accepted command is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Accepted {
    /// Already done (`MC_Power`, `MC_Reset`).
    AtOnce,
    /// Under way; [`SlaveAxis::progress`] tells how far.
    Job(JobNumber),
    /// A change to the coupling by cam plates, which goes on;
    /// [`SlaveAxis::change_progress`] tells how far.
    Change(Ticket),
}

impl SlaveAxis {
    /// An axis without power, where its drive is.
    ///
    /// # Errors
    /// [`WrongSlaveParameter`] names the parameter that no axis can have.
    pub fn new(
        parameters: &SlaveParameters,
        drive: Drive,
        cycle_time: CycleTime,
    ) -> Result<Self, WrongSlaveParameter> {
        let guard = parameters.guard()?;
        let here = drive.position();
        let cycle_time = cycle_time.as_secs_f64();
        Ok(Self {
            guard,
            on_master_loss: parameters.on_master_loss,
            cycle_time,
            drive,
            drive_zero: 0.0,
            state: StateMachine::default(),
            powered: false,
            homed: false,
            stop_held: false,
            set: Kinematics::at_rest(here),
            motion: Motion::Planned(Planned::rest(here, &guard)),
            cams: Cams::none(guard.limits().velocity() * cycle_time),
            master_traits: parameters.master()?,
            last_saw: None,
            saw_table_in_use: None,
            job: Job::default(),
            master: None,
            error: None,
        })
    }

    /// `MC_CamTableSelect`: the plates that the axis can be coupled by. The ids are those of its
    /// master and its own, for `MC_CamInfo`. A coupling by the plates before must have ended.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select_cams(&mut self, tables: Tables, master_axis_id: u32, slave_axis_id: u32) {
        let jump_limit = self.guard.limits().velocity() * self.cycle_time;
        let in_use = |table| tables.plate(table).is_ok();
        self.saw_table_in_use = match saw_table_id(slave_axis_id, in_use) {
            Err(SawRefusal::TableInUse { table }) => Some(table),
            _ => None,
        };
        self.cams
            .select(tables, [master_axis_id, slave_axis_id], jump_limit);
    }

    /// Tells the axis what to do from now on. What couples it relates the set values to the master
    /// of the last [`update`](Self::update): they belong to the same moment.
    ///
    /// # Errors
    /// [`Refusal`] says what stands against it; the axis goes on with what it was doing.
    pub fn command(&mut self, command: &Command) -> Result<Accepted, Refusal> {
        let transition = command.transition(self.powered);
        if let Some(transition) = transition {
            self.check_state(command.name(), transition)?;
        }
        match *command {
            Command::Power(on) => {
                self.power(on);
                return Ok(Accepted::AtOnce);
            }
            Command::Reset {} => {
                self.reset()?;
                return Ok(Accepted::AtOnce);
            }
            Command::Home { position } => self.home(position)?,
            Command::MoveAbsolute {
                position,
                velocity,
                ref dynamics,
            } => self.move_to("position", position, velocity, dynamics)?,
            Command::MoveRelative {
                distance,
                velocity,
                ref dynamics,
            } => {
                self.move_by(distance, velocity, dynamics)?;
            }
            Command::MoveVelocity {
                velocity,
                ref dynamics,
            } => self.move_at(velocity, dynamics)?,
            Command::Halt { ref dynamics } | Command::Stop { ref dynamics } => {
                self.stop(dynamics)?;
            }
            Command::GearIn { ratio } => self.gear_in(ratio)?,
            Command::GearOut {} | Command::CamOut {} => {
                return Ok(Accepted::Job(self.gear_out()));
            }
            Command::FlyingGear(ref parameters) => self.flying_gear(parameters)?,
            Command::GearInPos(command) => self.saw(SawCommand::GearInPos(command))?,
            Command::GearInVelo(command) => self.saw(SawCommand::GearInVelo(command))?,
            Command::ReadFlyingSawCharacteristics {} => {
                self.saw_plan().ok_or(Refusal::NoCharacteristics)?;
                return Ok(Accepted::AtOnce);
            }
            Command::SetCamOnlineChangeMode { table, mode } => {
                self.cams.set_mode(table, mode)?;
                return Ok(Accepted::AtOnce);
            }
            Command::WriteMotionFunction { table, ref points } => {
                self.cams.write(table, points)?;
                return Ok(Accepted::AtOnce);
            }
            Command::CamIn(command) => return self.cam(&cam::Command::CamIn(command)),
            Command::CamScaling(command) => {
                return self.cam(&cam::Command::CamScaling(command));
            }
            Command::CamInV2(command) => return self.cam(&cam::Command::CamInV2(command)),
            Command::CamAdd(command) => return self.cam(&cam::Command::CamAdd(command)),
            Command::CamExchange(command) => {
                return self.cam(&cam::Command::CamExchange(command));
            }
            Command::CamRemove(command) => {
                return self.cam(&cam::Command::CamRemove(command));
            }
            Command::CamScalingV2(command) => {
                return self.cam(&cam::Command::CamScalingV2(command));
            }
        }
        if let Some(transition) = transition {
            self.state.follow(transition);
        }
        Ok(Accepted::Job(self.job.replace(self.job_state())))
    }

    /// One cycle: the set values `elapsed` after the last ones, which the drive then follows.
    ///
    /// `master` is none when it is lost or in error. A coupled axis stops then, and is in error
    /// stop until reset; one that is not coupled does not mind.
    pub fn update(&mut self, master: Option<&Kinematics>, elapsed: Seconds) -> Kinematics {
        self.master = master.copied();
        if !(elapsed.0 > 0.0 && elapsed.0.is_finite()) {
            return self.set;
        }
        if let Err(error) = self.advance(elapsed) {
            self.fail(error);
            self.run_plan(elapsed);
        }
        self.finish();
        self.move_drive(elapsed);
        self.set
    }

    /// Keeps an axis that `MC_Stop` has stopped in `Stopping` for as long as that is executed.
    pub const fn hold_stop(&mut self, held: bool) {
        self.stop_held = held;
    }

    /// The state of the axis.
    #[must_use]
    pub const fn status(&self) -> AxisStatus {
        self.state.status()
    }

    /// Why it is in error stop; none if it is not.
    #[must_use]
    pub const fn error(&self) -> Option<SlaveError> {
        self.error
    }

    /// Whether it has power and no error.
    #[must_use]
    pub fn is_operational(&self) -> bool {
        self.drive.state() == DriveState::Following && self.error.is_none()
    }

    /// How far an accepted command is.
    #[must_use]
    pub fn progress(&self, job: JobNumber) -> CommandState<SlaveError> {
        self.job.progress(job)
    }

    /// The newest accepted command, and how far it is.
    #[must_use]
    pub const fn job(&self) -> (JobNumber, CommandState<SlaveError>) {
        (self.job.number(), self.job.state())
    }

    /// How far a change to the coupling by cam plates is. One that is refused when it is due, for a
    /// jump say, is `Failed`; the axis goes on without it.
    #[must_use]
    pub fn change_progress(&self, change: Ticket) -> CouplingState {
        self.cams.state_of(change)
    }

    /// How far the coupling is; none without one.
    #[must_use]
    pub fn coupling_phase(&self) -> Option<CouplingPhase> {
        self.motion.coupling_phase(&self.cams)
    }

    /// The plates of the axis.
    #[must_use]
    pub const fn cam_tables(&self) -> &Tables {
        self.cams.tables()
    }

    /// The coupling by cam plates, for `MC_CamInfo`: after an error, as it was.
    #[must_use]
    pub const fn cam_coupling(&self) -> &CamCoupling {
        self.cams.coupling()
    }

    /// The set values.
    #[must_use]
    pub const fn set(&self) -> Kinematics {
        self.set
    }

    /// The actual position, u.
    #[must_use]
    pub const fn actual_position(&self) -> f64 {
        self.drive.position() + self.drive_zero
    }

    /// The drive. Its positions count from where it was first switched on, those of the axis from
    /// where it was homed.
    #[must_use]
    pub const fn drive(&self) -> &Drive {
        &self.drive
    }

    /// Whether the diagram has the arrow.
    fn check_state(&self, command: &'static str, transition: Transition) -> Result<(), Refusal> {
        let status = self.status();
        match status.after(transition) {
            Some(_) => Ok(()),
            None => Err(Refusal::Status {
                command,
                transition,
                status,
            }),
        }
    }

    pub(super) const fn has_job(&self) -> bool {
        self.job.is_busy()
    }

    pub(super) const fn guard(&self) -> &Guard {
        &self.guard
    }

    pub(super) const fn is_homed(&self) -> bool {
        self.homed
    }

    /// Where the motion under way ends, u; where the axis is, if that is nowhere.
    pub(super) fn target_position(&self) -> f64 {
        match &self.motion {
            Motion::Planned(planned) if planned.end().velocity == 0.0 => planned.end().position,
            Motion::RollingBack(stop) => stop.end(),
            _ => self.set.position,
        }
    }

    /// The state that a motion of the axis's own starts from.
    fn free(&self) -> Kinematics {
        match self.motion {
            Motion::Planned(_) => self.set,
            Motion::Coupled(_) | Motion::RollingBack(_) => self.guard.settled(&self.set),
        }
    }

    fn run(&mut self, profile: Profile) {
        self.set = self.free();
        self.move_by_motion(Motion::Planned(Planned::new(profile)));
    }

    /// From now on this moves the axis, and nothing else does.
    fn move_by_motion(&mut self, motion: Motion) {
        if self.is_on_cams() && self.error.is_none() {
            self.cams.end();
        }
        if let Motion::Coupled(Coupling::Saw(saw)) = &self.motion {
            self.last_saw = Some(*saw.plan());
        }
        self.motion = motion;
    }

    /// Whether cam plates couple the axis.
    fn is_on_cams(&self) -> bool {
        matches!(self.motion, Motion::Coupled(Coupling::Cam))
    }

    /// The bits of `nStateDWord` for what waits in the coupling by cam plates.
    pub(super) fn queued_in_cams(&self) -> StateWord {
        if self.is_on_cams() {
            self.cams.state_word()
        } else {
            StateWord::empty()
        }
    }

    fn is_at_rest(&self) -> bool {
        self.set.velocity == 0.0 && self.set.acceleration == 0.0
    }
}
