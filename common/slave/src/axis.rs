//! The slave axis itself.

mod added;
mod apply;
mod cycle;
mod plan;
mod plates;
mod start;
mod sync_positions;

use alloc::boxed::Box;

use coaxle_clock::{CycleTime, Seconds};

use coaxle_axis::drive::{Actual, Drive, DriveState};
use coaxle_axis::guard::Guard;
use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
use coaxle_axis::{
    AxisStatus, CommandState, CouplingPhase, Job, Masters, StateMachine, StateWord, SyncPositions,
    Transition, WindowMonitor,
};
use coaxle_curve::profile::Kinematics;
use coaxle_saw::{CouplingMoment, SawPlan};

use super::circle::CircleState;
use super::couplings::{Couplings, Kind};
use super::error::SlaveError;
use super::job::{EndedJob, JobError, JobState, Jobs};
use super::motion::{Motion, Planned};
use super::parameters::{OnMasterLoss, SlaveParameters, WrongSlaveParameter};
use super::port::DrivePort;
use super::refusal::Refusal;
use super::shift::Shift;

pub use start::CoupledStart;
use sync_positions::Turns;

/// A slave axis with its drive.
#[derive(Debug)]
pub struct SlaveAxis {
    /// What motions are checked against before they begin.
    guard: Guard,
    /// The last stage: what keeps the limits on the set positions, whatever moves the axis.
    last_stage: SetValueGuard,
    /// How the axis followed what moves it in the newest cycle, and how far it is from there, u.
    tracking: GuardState,
    distance: f64,
    window: WindowMonitor,
    /// How far it may be from there and be in sync, u, and where it was left behind by more in the newest cycle, without
    /// what is added to the motion.
    in_sync_window: f64,
    left_behind: Option<Kinematics>,
    /// The motion under way has limits of its own: a stop that is to be instant, or without regard to jerk.
    exempt: bool,
    on_master_loss: OnMasterLoss,
    cycle_time: f64,
    drive: DrivePort,
    /// The axis's position where the drive's is 0: homing shifts it.
    drive_zero: f64,
    state: StateMachine,
    /// What `MC_Power` asks for.
    powered: bool,
    homed: bool,
    /// `MC_Stop` is still executed: the axis stays in `Stopping`.
    stop_held: bool,
    set: Kinematics,
    /// Its mean velocity in the newest cycle, u/s: a motion that has ended within that has not stood for a cycle yet.
    mean_velocity: f64,
    motion: Motion,
    couplings: Couplings,
    /// What is added to the first master as the coupling sees it.
    phasing: Shift,
    /// What is added to the motion.
    superimposed: Shift,
    jobs: Jobs,
    /// The masters at the last update: of the same moment as the set values.
    masters: Masters,
    /// The modulo turns of the axis and its first master.
    turns: Turns,
    /// Its id, where its plates were selected.
    axis_id: u32,
    /// The [`Tables::selections`](coaxle_cam::Tables::selections) that its flying saw knows of.
    selections: Option<u32>,
    error: Option<SlaveError>,
    /// The circle that it and its masters form.
    circle: CircleState,
    /// How often the set position was set anew.
    set_anew: u32,
    /// Counts whatever happens to the axis, so that no change is applied that was planned before.
    revision: u32,
}

/// What becomes of the motion of an axis if nobody commands anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outlook {
    /// It stands, and stays there.
    AtRest,
    /// It keeps this velocity, u/s.
    ConstantVelocity(f64),
    /// A motion of its own is under way, to one of the above.
    UnderWay,
    /// A coupling leads it, or brings it to rest.
    Led,
}

impl SlaveAxis {
    /// An axis without power, where its drive is.
    ///
    /// # Errors
    /// [`WrongSlaveParameter`] names the parameter that no axis can have.
    pub fn new(
        parameters: &SlaveParameters,
        drive: Box<dyn Drive>,
        cycle_time: CycleTime,
    ) -> Result<Self, WrongSlaveParameter> {
        let guard = parameters.guard()?;
        let drive = DrivePort::new(drive);
        let here = Kinematics::at_rest(drive.actual().position);
        Ok(Self {
            guard,
            last_stage: parameters.set_value_guard(cycle_time, &here)?,
            tracking: GuardState::Tracking,
            distance: 0.0,
            window: parameters.window_monitor()?,
            in_sync_window: parameters.in_sync_window(cycle_time)?,
            left_behind: None,
            exempt: false,
            on_master_loss: parameters.on_master_loss,
            cycle_time: cycle_time.as_secs_f64(),
            drive,
            drive_zero: 0.0,
            state: StateMachine::default(),
            powered: false,
            homed: false,
            stop_held: false,
            set: here,
            mean_velocity: 0.0,
            motion: Motion::Own(Planned::rest(here.position, &guard)),
            couplings: Couplings::new(parameters.saw()?),
            phasing: Shift::NONE,
            superimposed: Shift::NONE,
            jobs: Jobs::default(),
            masters: Masters::default(),
            turns: Turns::default(),
            axis_id: 0,
            selections: None,
            error: None,
            circle: CircleState::None,
            set_anew: 0,
            revision: 0,
        })
    }

    /// One cycle: the set values `elapsed` after the last ones, which the drive then follows.
    ///
    /// The masters are [`Masters`], or an `Option<&Kinematics>` where there is but one: none when it
    /// is lost or in error. An axis that is coupled to it stops then, and is in error stop until
    /// reset; one that is not does not mind.
    pub fn update(&mut self, masters: impl Into<Masters>, elapsed: Seconds) -> Kinematics {
        self.masters = masters.into();
        self.revision = self.revision.wrapping_add(1);
        if !(elapsed.0 > 0.0 && elapsed.0.is_finite()) {
            return self.set;
        }
        let (before, stood) = (self.set.position, self.stands());
        if let Err(error) = self.advance(elapsed) {
            self.fail(error);
            self.run_plan(elapsed);
        }
        self.mean_velocity = (self.set.position - before) / elapsed.0;
        self.finish(stood);
        self.move_drive(elapsed);
        self.wait_for_drive();
        self.set
    }

    /// Reports the circle that the axis and its masters form over other nodes. One that is known refuses couplings; one
    /// that is closed brings a coupled axis to an error stop.
    pub const fn set_circle(&mut self, circle: CircleState) {
        self.circle = circle;
        self.revision = self.revision.wrapping_add(1);
    }

    /// The circle that the axis and its masters form, as it was reported last.
    #[must_use]
    pub const fn circle(&self) -> CircleState {
        self.circle
    }

    /// Refuses what would couple an axis to a master that follows it.
    fn check_circle(&self, command: &'static str) -> Result<(), Refusal> {
        match self.circle {
            CircleState::None => Ok(()),
            CircleState::Open | CircleState::Closed => Err(Refusal::FollowsItself { command }),
        }
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
        self.drive.actual().state == DriveState::Following && self.error.is_none()
    }

    /// How far a job is. Of those that have ended the last ones are remembered; others are taken
    /// for aborted.
    #[must_use]
    pub fn progress(&self, job: Job) -> JobState {
        if let Some(state) = self.jobs.progress(job) {
            return state;
        }
        let added = self.phasing.progress(job);
        if let Some(state) = added.or_else(|| self.superimposed.progress(job)) {
            return state;
        }
        match self.couplings.state_of(job) {
            CommandState::Idle => CommandState::Aborted,
            state => state.map_error(|refusal| JobError::Refused(Refusal::Coupling(refusal))),
        }
    }

    /// Whether a job was aborted because the master of its flying saw ran back past the coupling
    /// position. Of such jobs the last one is remembered.
    #[must_use]
    pub const fn was_rolled_back(&self, job: Job) -> bool {
        self.jobs.was_rolled_back(job)
    }

    /// The next job that has come to its end, each of them once. Few are kept: ask in every cycle.
    pub fn take_ended(&mut self) -> Option<EndedJob> {
        self.jobs.take_ended().or_else(|| {
            let job = self.couplings.ended()?;
            let state = self.progress(job);
            Some(EndedJob { job, state })
        })
    }

    /// The job that moves the axis, or did so last, and how far it is.
    #[must_use]
    pub const fn job(&self) -> (Option<Job>, JobState) {
        self.jobs.motion()
    }

    /// What becomes of the motion if nobody commands anything.
    #[must_use]
    pub fn outlook(&self) -> Outlook {
        match &self.motion {
            Motion::Coupled(_) => Outlook::Led,
            Motion::Own(_) if !self.own_motion_is_over() => Outlook::UnderWay,
            Motion::Own(planned) => match planned.end().velocity {
                0.0 => Outlook::AtRest,
                velocity => Outlook::ConstantVelocity(velocity),
            },
        }
    }

    /// What `MC_Power` asks for; the axis has power once its drive follows.
    #[must_use]
    pub const fn is_power_on(&self) -> bool {
        self.powered
    }

    /// How far the coupling is; none without one. In sync is what the axis is, and not what the coupling leads to: beyond
    /// the window of its distance it is [behind](CouplingPhase::Behind).
    #[must_use]
    pub fn coupling_phase(&self) -> Option<CouplingPhase> {
        let phase = self.couplings.get(self.engaged()?).phase()?;
        let is_behind = phase.is_in_sync() && self.left_behind.is_some();
        Some(if is_behind {
            CouplingPhase::Behind
        } else {
            phase
        })
    }

    /// Whether a tool on it can cut now: not while the axis is led to its master or away from it, nor while it is behind.
    /// What no master leads cuts where it is.
    ///
    /// # Errors
    /// [`Refusal::CutNotInSync`].
    pub fn check_cut(&self) -> Result<(), Refusal> {
        match self.coupling_phase() {
            Some(
                phase @ (CouplingPhase::Behind
                | CouplingPhase::Synchronizing
                | CouplingPhase::SynchronizingAfterSyncPosition
                | CouplingPhase::Releasing),
            ) => Err(Refusal::CutNotInSync {
                phase,
                distance: self.distance,
                window: self.in_sync_window,
            }),
            _ => Ok(()),
        }
    }

    /// How far the set position may be from where the coupling has it while the axis is in sync, u.
    #[must_use]
    pub const fn in_sync_window(&self) -> f64 {
        self.in_sync_window
    }

    /// Where master and slave are synchronous, if the coupling leads to such a pair of positions.
    #[must_use]
    pub fn sync_positions(&self) -> Option<SyncPositions> {
        self.couplings.get(self.engaged()?).sync_positions()
    }

    /// What the coupling scales the positions of its master by: 1 where it does not.
    #[must_use]
    pub fn master_scaling(&self) -> f64 {
        let coupling = self.engaged().map(|kind| self.couplings.get(kind));
        coupling.map_or(1.0, |coupling| coupling.master_scaling())
    }

    /// The plan of the flying saw that couples the axis; while it waits, the plan foreseen. Without
    /// one, that of the last.
    #[must_use]
    pub const fn saw_plan(&self) -> Option<&SawPlan> {
        self.couplings.saw.plan_in_force()
    }

    /// What a flying saw would be planned from now; none without a master. Of a command that is
    /// refused, it tells what would have passed:
    /// [`SawCommand::remedy`](coaxle_saw::SawCommand::remedy).
    #[must_use]
    pub fn coupling_moment(&self) -> Option<CouplingMoment> {
        let inputs = self.plan_inputs(Kind::Saw);
        Some(self.couplings.saw.moment(inputs.masters.first()?, &inputs))
    }

    /// The set values.
    #[must_use]
    pub const fn set(&self) -> Kinematics {
        self.set
    }

    /// Whether the set values are what the motion under way asks for, or what the limits of the axis leave
    /// of that.
    #[must_use]
    pub const fn tracking(&self) -> GuardState {
        self.tracking
    }

    /// How far the set position is from what the motion under way asks for, u.
    #[must_use]
    pub const fn distance(&self) -> f64 {
        self.distance
    }

    /// How often the set position was set anew so far, wrapping around: where the drive is, where it was
    /// homed, or where the axis was switched on. It is no step of a motion then.
    #[must_use]
    pub const fn times_set_anew(&self) -> u32 {
        self.set_anew
    }

    /// The actual position, u.
    #[must_use]
    pub const fn actual_position(&self) -> f64 {
        self.drive.actual().position + self.drive_zero
    }

    /// What the drive said last, as far as it can be believed. Its positions count from where it was first
    /// switched on, those of the axis from where it was homed.
    #[must_use]
    pub const fn actual(&self) -> &Actual {
        self.drive.actual()
    }

    /// The drive.
    #[must_use]
    pub fn drive(&self) -> &dyn Drive {
        self.drive.drive()
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

    pub(super) fn has_job(&self) -> bool {
        self.jobs.is_busy() || self.superimposed.is_under_way()
    }

    pub(super) const fn guard(&self) -> &Guard {
        &self.guard
    }

    pub(super) const fn is_homed(&self) -> bool {
        self.homed
    }

    /// Where the motion under way ends, u; where the axis is, if that is nowhere.
    pub(super) fn target_position(&self) -> f64 {
        let target = match &self.motion {
            Motion::Own(planned) if planned.end().velocity == 0.0 => Some(planned.end().position),
            Motion::Own(_) => None,
            Motion::Coupled(kind) => self.couplings.get(*kind).target(),
        };
        target.map_or(self.set.position, |target| {
            target + self.superimposed.end().position
        })
    }

    /// The bits of `nStateDWord` for what waits in the coupling.
    pub(super) fn queued(&self) -> StateWord {
        let coupling = self.engaged().map(|kind| self.couplings.get(kind));
        coupling.map_or(StateWord::empty(), |coupling| coupling.queued())
    }

    /// The coupling that moves the axis.
    const fn engaged(&self) -> Option<Kind> {
        match self.motion {
            Motion::Coupled(kind) => Some(kind),
            Motion::Own(_) => None,
        }
    }

    /// The state that another motion starts from. The set values stay as they have left the axis.
    fn free(&self) -> Kinematics {
        match &self.motion {
            Motion::Own(planned) => planned.taken_over().unwrap_or(self.set),
            Motion::Coupled(_) => self.guard.taken_over(&self.last_stage.borne_out(&self.set)),
        }
    }

    /// Whether a motion of its own has come to its end, and the axis with it.
    fn own_motion_is_over(&self) -> bool {
        matches!(&self.motion, Motion::Own(planned) if planned.is_over())
            && self.tracking == GuardState::Tracking
            && !self.superimposed.is_under_way()
    }

    /// Whether it has stood for a cycle, as its positions say, too.
    #[must_use]
    pub fn stands(&self) -> bool {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = self.set;
        [velocity, acceleration, self.mean_velocity] == [0.0; 3]
    }
}
