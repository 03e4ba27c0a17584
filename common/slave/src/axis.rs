//! The slave axis itself.

mod added;
mod apply;
mod coupled;
mod cycle;
mod held_back;
mod plan;
mod plates;
mod start;
mod sync_positions;

use alloc::boxed::Box;

use coaxle_clock::{CycleTime, Seconds, Span};

use coaxle_axis::drive::{Actual, Drive, DriveState};
use coaxle_axis::guard::Guard;
use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
use coaxle_axis::{
    AxisStatus, CommandState, Job, Masters, StateMachine, StateWord, Transition, WindowMonitor,
};
use coaxle_cam::Tables;
use coaxle_curve::profile::{Kinematics, Limits};
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
use sync_positions::SyncPeriods;

/// A slave axis with its drive.
#[derive(Debug)]
pub struct SlaveAxis {
    /// Guard that checks motions before they begin.
    guard: Guard,
    /// The last stage, which keeps the limits on the set positions, for every motion.
    last_stage: SetValueGuard,
    /// State of following the motion in the newest cycle, and the distance from it, u.
    tracking: GuardState,
    distance: f64,
    window: WindowMonitor,
    /// Greatest distance from it in sync, u, and the axis if it was left behind by more in the
    /// newest cycle, without the superimposed motion.
    in_sync_window: f64,
    left_behind: Option<Kinematics>,
    /// True if the current motion has limits of its own: an instant stop, or one without a jerk limit.
    exempt: bool,
    on_master_loss: OnMasterLoss,
    cycle_time: f64,
    drive: DrivePort,
    /// Time by which the drive is to be given the set values later than they are calculated.
    hold_back: Span,
    /// Number of times that the axis was set back to what its drive was shown.
    set_backs: u32,
    /// The axis's position where the drive's is 0: homing shifts it.
    drive_zero: f64,
    state: StateMachine,
    /// Request of `MC_Power`.
    powered: bool,
    homed: bool,
    /// True while `MC_Stop` is still executed: the axis stays in `Stopping`.
    stop_held: bool,
    set: Kinematics,
    /// Mean velocity in the newest cycle, u/s: a motion that ended within it has not stood for a
    /// cycle yet.
    mean_velocity: f64,
    /// Duration of the newest cycle, s.
    newest_cycle: f64,
    motion: Motion,
    couplings: Couplings,
    /// Shift of the first master as the coupling sees it.
    phasing: Shift,
    /// Superimposed motion.
    superimposed: Shift,
    jobs: Jobs,
    /// The masters at the last update, of the same instant as the set values.
    masters: Masters,
    /// The modulo periods of the axis and its first master.
    turns: SyncPeriods,
    /// Axis id, set when it is prepared for plates.
    axis_id: u32,
    error: Option<SlaveError>,
    /// The circle that it and its masters form.
    circle: CircleState,
    /// Number of presets of the set position.
    set_anew: u32,
    /// True if the position was preset since the newest cycle began.
    is_preset: bool,
    /// Counter of all changes to the axis, so that no outdated plan is applied.
    revision: u32,
}

/// Further course of an axis's motion without a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outlook {
    /// Standing, and staying there.
    AtRest,
    /// Constant velocity, u/s.
    ConstantVelocity(f64),
    /// Own motion under way, to one of the above.
    UnderWay,
    /// Led by a coupling, or brought to rest by it.
    Led,
}

impl SlaveAxis {
    /// Creates an axis without power, at its drive's position.
    ///
    /// # Errors
    /// [`WrongSlaveParameter`] names the invalid parameter.
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
            hold_back: Span::ZERO,
            set_backs: 0,
            drive_zero: 0.0,
            state: StateMachine::default(),
            powered: false,
            homed: false,
            stop_held: false,
            set: here,
            mean_velocity: 0.0,
            newest_cycle: 0.0,
            motion: Motion::Own(Planned::rest(here.position, &guard)),
            couplings: Couplings::new(parameters.saw()?),
            phasing: Shift::NONE,
            superimposed: Shift::NONE,
            jobs: Jobs::default(),
            masters: Masters::default(),
            turns: SyncPeriods::default(),
            axis_id: 0,
            error: None,
            circle: CircleState::None,
            set_anew: 0,
            is_preset: false,
            revision: 0,
        })
    }

    /// Runs one cycle: returns the set values `elapsed` after the last ones, which the drive then
    /// follows.
    ///
    /// The masters are [`Masters`], or an `Option<&Kinematics>` for a single one: none when it is
    /// lost or in error. An axis that is coupled to it then stops, and is in error stop until
    /// reset; any other is not affected.
    ///
    /// `plates` are those of its node, always the same ones.
    pub fn update(
        &mut self,
        plates: &mut Tables,
        masters: impl Into<Masters>,
        elapsed: Seconds,
    ) -> Kinematics {
        self.masters = masters.into();
        self.revision = self.revision.wrapping_add(1);
        // Velocities below are quotients by it. A NaN compares as false.
        if !(elapsed.0 > 0.0 && elapsed.0.is_finite()) {
            return self.set;
        }
        // Before the cycle: power is switched off only after two cycles at rest.
        let (mut before, stood) = (self.set.position, self.stands());
        let (moving, set_backs) = (self.moving_time(elapsed), self.set_backs);
        if let Err(error) = self.advance(plates, elapsed, moving) {
            self.fail(plates, error);
            if self.set_backs != set_backs {
                // The way back to what its drive is shown is no motion of the axis.
                before = self.set.position;
            }
            // The failed cycle is the first one of the brake. Otherwise the axis would stand for it, with a velocity.
            self.run_plan(moving);
        }
        self.mean_velocity = (self.set.position - before) / moving.0;
        self.newest_cycle = moving.0;
        self.finish(plates, stood);
        // After the end of the motion: power that is switched off here presets the position to that of the drive.
        self.move_drive(plates, elapsed);
        self.wait_for_drive(plates);
        self.set
    }

    /// Reports the circle that the axis and its masters form across nodes. Couplings are refused
    /// while a circle is known; a closed one brings a coupled axis to an error stop.
    pub const fn set_circle(&mut self, circle: CircleState) {
        // A plan from before could couple the axis into the circle, so the revision changes, too.
        self.circle = circle;
        self.revision = self.revision.wrapping_add(1);
    }

    /// The circle that the axis and its masters form, as last reported.
    #[must_use]
    pub const fn circle(&self) -> CircleState {
        self.circle
    }

    /// Refuses a coupling of an axis to a master that follows it.
    fn check_circle(&self, command: &'static str) -> Result<(), Refusal> {
        match self.circle {
            CircleState::None => Ok(()),
            CircleState::Open | CircleState::Closed => Err(Refusal::FollowsItself { command }),
        }
    }

    /// Keeps an axis that `MC_Stop` has stopped in `Stopping` while that command is executed.
    pub const fn hold_stop(&mut self, held: bool) {
        self.stop_held = held;
    }

    /// The state of the axis.
    #[must_use]
    pub const fn status(&self) -> AxisStatus {
        self.state.status()
    }

    /// Error of its error stop; none otherwise.
    #[must_use]
    pub const fn error(&self) -> Option<SlaveError> {
        self.error
    }

    /// True if it has power and no error.
    #[must_use]
    pub fn is_operational(&self) -> bool {
        self.drive.actual().state == DriveState::Following && self.error.is_none()
    }

    /// State of a job. The last ended ones are kept; others count as aborted.
    #[must_use]
    pub fn progress(&self, job: Job) -> JobState {
        // Each keeper of jobs in turn: numbers are unique, so that at most one of them knows it.
        if let Some(state) = self.jobs.progress(job) {
            return state;
        }
        let added = self.phasing.progress(job);
        if let Some(state) = added.or_else(|| self.superimposed.progress(job)) {
            return state;
        }
        match self.couplings.state_of(job) {
            // Nobody knows the job any more: it ended too long ago.
            CommandState::Idle => CommandState::Aborted,
            state => state.map_error(|refusal| JobError::Refused(Refusal::Coupling(refusal))),
        }
    }

    /// True if a job was aborted because the master of its flying saw ran back past the coupling
    /// position. Only the last such job is kept.
    #[must_use]
    pub const fn was_rolled_back(&self, job: Job) -> bool {
        self.jobs.was_rolled_back(job)
    }

    /// Takes the next job that has ended, each once. Few are kept, so this has to be called in
    /// every cycle.
    pub fn take_ended(&mut self) -> Option<EndedJob> {
        self.jobs.take_ended().or_else(|| {
            let job = self.couplings.ended()?;
            let state = self.progress(job);
            Some(EndedJob { job, state })
        })
    }

    /// The current or last job of motion, and its state.
    #[must_use]
    pub const fn job(&self) -> (Option<Job>, JobState) {
        self.jobs.motion()
    }

    /// Returns true if its motion depends on the master of this number, from 0. One that is not coupled is to be led by the first.
    #[must_use]
    pub fn follows_master(&self, number: usize) -> bool {
        match self.motion {
            Motion::Coupled(Kind::MultiMasterGear) => {
                self.couplings.multi_master_gear.follows(number)
            }
            // All other couplings have a single master.
            Motion::Coupled(_) | Motion::Own(_) => number == 0,
        }
    }

    /// Further course of the motion without a command.
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

    /// Request of `MC_Power`; the axis has power once its drive follows.
    #[must_use]
    pub const fn is_power_on(&self) -> bool {
        self.powered
    }

    /// Limits of the axis.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        self.guard.limits()
    }

    /// The plan of the flying saw that couples the axis; while it waits, the expected plan. Without
    /// a saw, that of the last one.
    #[must_use]
    pub const fn saw_plan(&self) -> Option<&SawPlan> {
        self.couplings.saw.plan_in_force()
    }

    /// Moment from which a flying saw would be planned now; none without a master. For a refused
    /// command, [`SawCommand::remedy`](coaxle_saw::SawCommand::remedy) derives a valid one from it.
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

    /// State of the guard: set values as requested by the current motion, or limited.
    #[must_use]
    pub const fn tracking(&self) -> GuardState {
        self.tracking
    }

    /// Distance of the set position from the requested one, u.
    #[must_use]
    pub const fn distance(&self) -> f64 {
        self.distance
    }

    /// Number of presets of the set position, wrapping around: to the drive's position, by homing,
    /// or at power on. A preset is not a step of a motion.
    #[must_use]
    pub const fn preset_count(&self) -> u32 {
        self.set_anew
    }

    /// The actual position, u.
    #[must_use]
    pub const fn actual_position(&self) -> f64 {
        self.drive.actual().position + self.drive_zero
    }

    /// The last actual values of the drive, as far as plausible. Its positions count from its first
    /// power on, those of the axis from homing.
    #[must_use]
    pub const fn actual(&self) -> &Actual {
        self.drive.actual()
    }

    /// The drive.
    #[must_use]
    pub fn drive(&self) -> &dyn Drive {
        self.drive.drive()
    }

    /// Checks that the diagram has the arrow.
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

    /// End position of the current motion, u; the current position if there is none.
    pub(super) fn target_position(&self) -> f64 {
        // A velocity without an end has no target.
        let target = match &self.motion {
            Motion::Own(planned) if planned.end().velocity == 0.0 => Some(planned.end().position),
            Motion::Own(_) => None,
            Motion::Coupled(kind) => self.couplings.get(*kind).target(),
        };
        // The offset at its end: a target is where the axis comes to rest.
        target.map_or(self.set.position, |target| {
            target + self.superimposed.end().position
        })
    }

    /// The bits of `nStateDWord` for pending changes of the coupling.
    pub(super) fn queued(&self, plates: &Tables) -> StateWord {
        let queued = |kind| self.couplings.queued(kind, plates);
        self.engaged().map_or(StateWord::empty(), queued)
    }

    /// The coupling that moves the axis.
    const fn engaged(&self) -> Option<Kind> {
        match self.motion {
            Motion::Coupled(kind) => Some(kind),
            Motion::Own(_) => None,
        }
    }

    /// The start state of another motion. The set values stay as they have left the axis.
    fn free(&self) -> Kinematics {
        match &self.motion {
            // Before its first cycle a motion is replaced from where it began: two commands in one cycle count as the
            // last one.
            Motion::Own(planned) => planned.taken_over().unwrap_or(self.set),
            // Stated values of a coupling may contradict its positions. A motion of the axis's own must begin with
            // what they bear out.
            Motion::Coupled(_) => self.guard.taken_over(&self.last_stage.borne_out(&self.set)),
        }
    }

    /// True if its own motion has ended, and the axis has arrived.
    fn own_motion_is_over(&self) -> bool {
        matches!(&self.motion, Motion::Own(planned) if planned.is_over())
            // The plan has ended, but the last stage may still be on its way to the end.
            && self.tracking == GuardState::Tracking
            && !self.superimposed.is_under_way()
    }

    /// True if it has stood for a cycle, by its positions, too.
    #[must_use]
    pub fn stands(&self) -> bool {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = self.set;
        // Exact zeros: plans end with them, and a preset from a crawl would be a step.
        [velocity, acceleration, self.mean_velocity] == [0.0; 3]
    }
}
