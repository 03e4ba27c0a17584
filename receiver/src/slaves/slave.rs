//! One slave: program, commands, coupling and life cycle, drive.

use coaxle_axis::drive::{Actual, DriveKind};
use coaxle_axis::{AxisStatus, CommandState, Job, NcToPlcAxis, Origin};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_node::CommandOutcome;
use coaxle_node::command::{SawView, SlaveOrder, SlaveView};
use coaxle_saw::CouplingMoment;
use coaxle_slave::{
    Change, Command, CoupledStart, CouplingPhase, CouplingRefusal, EndedJob, JobError, Refusal,
    SlaveAxis, SlaveError,
};

use super::Master;
use super::follower::Follower;
use super::masters::SlaveMasters;
use super::tool::Tool;
use crate::config::MasterRef;
use crate::program::{Program, Situation};
use crate::signals::SlaveSignals;
use crate::snapshot::{RefusedCommand, SlaveFaults};

/// A slave.
#[derive(Debug)]
pub(super) struct Slave {
    id: u32,
    /// Its masters, at least one.
    sources: Box<[MasterRef]>,
    body: Body,
    drive_kind: DriveKind,
    tool: Tool,
    program: Option<Program>,
    /// The command that was refused last.
    refusal: Option<RefusedCommand>,
    /// What was to couple it from the start could not.
    start_refused: bool,
}

/// What moves.
#[derive(Debug)]
pub(super) enum Body {
    Follower(Follower),
    Axis {
        axis: Box<SlaveAxis>,
        /// What couples it as soon as there is a master.
        start: Option<CoupledStart>,
    },
}

impl Body {
    fn drive_kind(&self) -> DriveKind {
        match self {
            Self::Follower(_) => DriveKind::Simulated,
            Self::Axis { axis, .. } => axis.drive().kind(),
        }
    }

    /// Of the plate that couples it; 1 without one.
    fn master_scaling(&self) -> f64 {
        match self {
            Self::Follower(_) => 1.0,
            Self::Axis { axis, .. } => axis.master_scaling(),
        }
    }
}

impl Slave {
    pub(super) fn new(
        id: u32,
        sources: Box<[MasterRef]>,
        body: Body,
        tool: Tool,
        program: Option<Program>,
    ) -> Self {
        Self {
            id,
            sources,
            drive_kind: body.drive_kind(),
            body,
            tool,
            program,
            refusal: None,
            start_refused: false,
        }
    }

    /// One cycle.
    pub(super) fn cycle(&mut self, masters: &SlaveMasters, elapsed: Seconds) {
        self.run_program(masters, elapsed);
        if self.start(masters) {
            return;
        }
        match &mut self.body {
            Body::Follower(follower) => follower.update(masters.first(), elapsed),
            Body::Axis { axis, .. } => {
                axis.update(masters.sound(), elapsed);
                self.take_ended_jobs();
            }
        }
    }

    /// What became of jobs that have come to their end: some are refused only when they are due.
    fn take_ended_jobs(&mut self) {
        let Body::Axis { axis, .. } = &mut self.body else {
            return;
        };
        while let Some(EndedJob { job, state }) = axis.take_ended() {
            let CommandState::Failed(JobError::Refused(refusal)) = state else {
                continue;
            };
            self.refusal = Some(RefusedCommand::when_due(refusal, job));
            if let (Origin::Program, Some(program)) = (job.origin, &mut self.program) {
                program.refused_late();
            }
        }
    }

    /// After each cycle: whether its tool cut.
    pub(super) fn watch_tool(&mut self) {
        let in_sync = self.phase() == Some(CouplingPhase::InSync);
        let set = self.set().filter(|_| in_sync);
        self.tool.is_at(set.map(|set| set.position));
    }

    /// The one way for commands, whoever gives them.
    pub(super) fn command(&mut self, command: &Command, origin: Origin) -> Result<Job, Refusal> {
        let change = self.plan(command);
        self.apply(change, origin)
    }

    fn plan(&self, command: &Command) -> Result<Change, Refusal> {
        match &self.body {
            Body::Follower(_) => Err(no_limits(command)),
            Body::Axis { axis, .. } => axis.plan(command),
        }
    }

    fn apply(&mut self, change: Result<Change, Refusal>, origin: Origin) -> Result<Job, Refusal> {
        let applied = change.and_then(|change| match &mut self.body {
            Body::Follower(_) => Err(Refusal::NoMaster),
            Body::Axis { axis, start } => {
                *start = None;
                Ok(axis.apply(change, origin))
            }
        });
        self.refusal = match applied {
            Ok(_) => self.refusal,
            Err(refusal) => Some(refusal.into()),
        };
        applied
    }

    fn run_program(&mut self, masters: &SlaveMasters, elapsed: Seconds) {
        let situation = self.situation(masters);
        let Some(program) = &mut self.program else {
            return;
        };
        let ready = masters.first().filter(|master| master.is_ready);
        program.advance(elapsed, ready.map(|master| master.set.position));
        let body = &self.body;
        let Some(command) = program.due(&situation, || body.master_scaling()) else {
            return;
        };
        let answer = match command {
            Some(command) => self.command(&command, Origin::Program).map(drop),
            None => Ok(()),
        };
        if let Some(program) = &mut self.program {
            program.take(answer);
        }
    }

    fn situation(&self, masters: &SlaveMasters) -> Situation {
        Situation {
            status: self.status(),
            phase: self.phase(),
            set: self.set().unwrap_or_default(),
            master: masters.first().map(|master| master.set.position),
            master_ready: masters.are_ready(),
        }
    }

    /// Couples it from the start, once there is its first master: then it is where it should be
    /// already.
    fn start(&mut self, masters: &SlaveMasters) -> bool {
        let Body::Axis { axis, start } = &mut self.body else {
            return false;
        };
        if !masters.first().is_some_and(|master| master.is_ready) {
            return false;
        }
        let Some(start) = start.take() else {
            return false;
        };
        if let Err(refusal) = axis.switch_on_coupled(&start, masters.sound()) {
            self.refusal = Some(refusal.into());
            self.start_refused = true;
        }
        !self.start_refused
    }

    pub(super) const fn sources(&self) -> &[MasterRef] {
        &self.sources
    }

    /// As the master of another slave.
    pub(super) fn as_master(&self) -> Option<Master> {
        let error = self.error();
        let is_operational = match &self.body {
            Body::Follower(_) => error.is_none(),
            Body::Axis { axis, .. } => axis.is_operational(),
        };
        Some(Master {
            set: self.set()?,
            is_sound: error.is_none(),
            is_ready: is_operational,
            error_code: error.map_or(0, |error| error.code()),
        })
    }

    pub(super) fn axis_struct(&self) -> Option<NcToPlcAxis> {
        match &self.body {
            Body::Follower(follower) => follower.axis_struct(self.id),
            Body::Axis { axis, .. } => Some(axis.axis_struct(self.id)),
        }
    }

    pub(super) fn error(&self) -> Option<SlaveError> {
        match &self.body {
            Body::Follower(follower) => follower.error(),
            Body::Axis { axis, .. } => axis.error(),
        }
    }

    /// Whether what its config has it do was refused.
    pub(super) fn is_refused(&self) -> bool {
        self.start_refused || self.program.as_ref().is_some_and(Program::is_refused)
    }

    /// An order of somebody in the network. A dry run is a plan that is not applied.
    pub(super) fn execute(&mut self, order: &SlaveOrder) -> CommandOutcome {
        let planned = self.plan(&order.command);
        let (job, planned) = match planned {
            Ok(change) if !order.dry_run => {
                let at_once = change.is_done_at_once();
                let planned = Ok(change);
                match self.apply(Ok(change), Origin::Order) {
                    Ok(job) => (Some(job.number).filter(|_| !at_once), planned),
                    Err(refusal) => (None, Err(refusal)),
                }
            }
            Err(refusal) if !order.dry_run => {
                self.refusal = Some(refusal.into());
                (None, Err(refusal))
            }
            planned => (None, planned),
        };
        let slave = self.view();
        match planned {
            Ok(change) => CommandOutcome::Accepted {
                job,
                awaits: change.awaits(),
                slave,
                saw: change.saw_plan().map(|plan| SawView {
                    plan: *plan,
                    axis_id: self.id,
                }),
            },
            Err(refusal) => CommandOutcome::Refused {
                refusal,
                slave,
                moment: self.coupling_moment(&refusal),
            },
        }
    }

    /// What a flying saw that is refused would have been planned from.
    fn coupling_moment(&self, refusal: &Refusal) -> Option<CouplingMoment> {
        match (&self.body, refusal) {
            (Body::Axis { axis, .. }, Refusal::Coupling(CouplingRefusal::Saw(_))) => {
                axis.coupling_moment()
            }
            _ => None,
        }
    }

    /// As the answer to a command shows it.
    fn view(&self) -> SlaveView {
        let here = || Kinematics::at_rest(self.actual_position());
        let set = self.set().unwrap_or_else(here);
        SlaveView {
            status: self.status(),
            coupling: self.phase(),
            position: set.position,
            velocity: set.velocity,
        }
    }

    pub(super) fn faults(&self) -> SlaveFaults {
        SlaveFaults {
            error: self.error(),
            refusal: self.refusal,
        }
    }

    pub(super) fn signals(&self, faults: &SlaveFaults) -> SlaveSignals {
        let (drive, set) = (self.actual(), self.set());
        let attachment = drive.attachment;
        let program = self.program.as_ref().map(Program::snapshot);
        SlaveSignals {
            position: set.map(|set| set.position),
            velocity: set.map(|set| set.velocity),
            acceleration: set.map(|set| set.acceleration),
            state: self.status(),
            phase: self.phase(),
            error: faults.error.map_or(0, |error| error.code()),
            refusal: faults.refusal.map_or(0, |refusal| refusal.code()),
            program: program.map(|program| program.state),
            program_step: program.map(|program| program.step),
            cuts: self.tool.cuts() + self.program.as_ref().map_or(0, Program::cuts),
            drive_kind: self.drive_kind.into(),
            drive_attached: attachment.map(|attachment| attachment.attached),
            drive_heartbeat_age: attachment.and_then(|attachment| attachment.heartbeat_age),
            drive_state: drive.state.into(),
            drive_position: self.actual_position(),
            drive_velocity: drive.velocity,
            following_error: drive.following_error,
        }
    }

    fn status(&self) -> AxisStatus {
        match &self.body {
            Body::Follower(follower) => follower.status(),
            Body::Axis { axis, .. } => axis.status(),
        }
    }

    fn phase(&self) -> Option<CouplingPhase> {
        match &self.body {
            Body::Follower(follower) => follower.set().map(|_| CouplingPhase::InSync),
            Body::Axis { axis, .. } => axis.coupling_phase(),
        }
    }

    fn set(&self) -> Option<Kinematics> {
        match &self.body {
            Body::Follower(follower) => follower.set(),
            Body::Axis { axis, .. } => Some(axis.set()),
        }
    }

    fn actual(&self) -> &Actual {
        match &self.body {
            Body::Follower(follower) => follower.actual(),
            Body::Axis { axis, .. } => axis.actual(),
        }
    }

    fn actual_position(&self) -> f64 {
        match &self.body {
            Body::Follower(follower) => follower.actual().position,
            Body::Axis { axis, .. } => axis.actual_position(),
        }
    }
}

const fn no_limits(command: &Command) -> Refusal {
    Refusal::NoLimits {
        command: command.name(),
    }
}
