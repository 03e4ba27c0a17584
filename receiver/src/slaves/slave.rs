//! One slave: program, commands, coupling and life cycle, drive.

use coaxle_clock::Seconds;
use coaxle_motion::axis::{AxisStatus, NcToPlcAxis};
use coaxle_motion::drive::Drive;
use coaxle_motion::profile::Kinematics;
use coaxle_motion::saw::CouplingMoment;
use coaxle_motion::slave::{
    Accepted, Command, CoupledStart, CouplingPhase, Refusal, SlaveAxis, SlaveError,
};
use coaxle_node::command::{NotTaken, SawView, SlaveView};
use coaxle_node::{CommandOrder, CommandOutcome};

use super::Master;
use super::follower::Follower;
use super::late::{Late, Origin};
use super::tool::Tool;
use crate::program::{Program, Situation};
use crate::snapshot::{DriveSnapshot, SlaveSnapshot};

/// A slave.
#[derive(Debug)]
pub(super) struct Slave {
    id: u32,
    source: Source,
    body: Body,
    tool: Tool,
    program: Option<Program>,
    late: Late,
    /// Why a command was refused last.
    refusal: Option<Refusal>,
    /// What was to couple it from the start could not.
    start_refused: bool,
}

/// Where its master comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The far axis.
    Far,
    /// The slave with this number.
    Slave(usize),
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
    /// Of the plate that couples it; 1 without one.
    fn master_scaling(&self) -> f64 {
        match self {
            Self::Follower(_) => 1.0,
            Self::Axis { axis, .. } => axis
                .cam_coupling()
                .info(axis.cam_tables(), 0, None)
                .map_or(1.0, |info| info.master_scaling),
        }
    }
}

impl Slave {
    pub(super) fn new(
        id: u32,
        source: Source,
        body: Body,
        tool: Tool,
        program: Option<Program>,
    ) -> Self {
        Self {
            id,
            source,
            body,
            tool,
            program,
            late: Late::default(),
            refusal: None,
            start_refused: false,
        }
    }

    /// One cycle.
    pub(super) fn cycle(&mut self, master: Option<&Master>, elapsed: Seconds) {
        self.run_program(master, elapsed);
        if self.start(master) {
            return;
        }
        match &mut self.body {
            Body::Follower(follower) => follower.update(master, elapsed),
            Body::Axis { axis, .. } => {
                let sound = master.filter(|master| master.is_sound);
                axis.update(sound.map(|master| &master.set), elapsed);
                if let Some((refusal, origin)) = self.late.refused(axis) {
                    self.refusal = Some(refusal);
                    if let (Origin::Program, Some(program)) = (origin, &mut self.program) {
                        program.refused_late();
                    }
                }
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
    pub(super) fn command(
        &mut self,
        command: &Command,
        origin: Origin,
    ) -> Result<Accepted, Refusal> {
        let answer = match &mut self.body {
            Body::Follower(_) => Err(no_limits(command)),
            Body::Axis { axis, start } => {
                let answer = axis.command(command);
                if answer.is_ok() {
                    *start = None;
                }
                answer
            }
        };
        match answer {
            Ok(accepted) => self.late.remember(accepted, origin),
            Err(refusal) => self.refusal = Some(refusal),
        }
        answer
    }

    fn run_program(&mut self, master: Option<&Master>, elapsed: Seconds) {
        let situation = self.situation(master);
        let Some(program) = &mut self.program else {
            return;
        };
        let ready = master.filter(|master| master.is_ready);
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

    fn situation(&self, master: Option<&Master>) -> Situation {
        Situation {
            status: self.status(),
            phase: self.phase(),
            set: self.set().unwrap_or_default(),
            master: master.map(|master| master.set.position),
            master_ready: master.is_some_and(|master| master.is_ready),
        }
    }

    /// Couples it from the start, once there is a master: then it is where it should be already.
    fn start(&mut self, master: Option<&Master>) -> bool {
        let Body::Axis { axis, start } = &mut self.body else {
            return false;
        };
        let Some(master) = master.filter(|master| master.is_ready) else {
            return false;
        };
        let Some(start) = start.take() else {
            return false;
        };
        if let Err(refusal) = axis.switch_on_coupled(&start, &master.set) {
            self.refusal = Some(refusal);
            self.start_refused = true;
        }
        !self.start_refused
    }

    pub(super) const fn source(&self) -> Source {
        self.source
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

    /// An order of somebody in the network.
    pub(super) fn execute(&mut self, order: &CommandOrder) -> CommandOutcome {
        let command = &order.command;
        let answer = if order.dry_run {
            match self.dry_run(command) {
                Some(answer) => answer,
                None => {
                    let command = command.name();
                    return CommandOutcome::NotTaken(NotTaken::NoDryRun { command });
                }
            }
        } else {
            self.command(command, Origin::Outside)
        };
        let slave = self.view();
        match answer {
            Ok(accepted) => CommandOutcome::Accepted {
                accepted,
                slave,
                saw: self.saw_view(order),
            },
            Err(refusal) => CommandOutcome::Refused {
                refusal,
                slave,
                moment: self.coupling_moment(&refusal),
            },
        }
    }

    fn dry_run(&mut self, command: &Command) -> Option<Result<Accepted, Refusal>> {
        match &mut self.body {
            Body::Follower(_) => Some(Err(no_limits(command))),
            Body::Axis { axis, .. } => axis.dry_run(command),
        }
    }

    /// The flying saw that an accepted order is about.
    fn saw_view(&self, order: &CommandOrder) -> Option<SawView> {
        let Body::Axis { axis, .. } = &self.body else {
            return None;
        };
        let plan = match (order.command.as_saw(), order.dry_run) {
            (Some(saw), true) => axis.foresee(saw).ok()?,
            (Some(_), false) => *axis.saw_plan()?,
            (None, _) if matches!(order.command, Command::ReadFlyingSawCharacteristics {}) => {
                *axis.saw_plan()?
            }
            _ => return None,
        };
        let axis_id = self.id;
        Some(SawView { plan, axis_id })
    }

    /// What a flying saw that is refused would have been planned from.
    fn coupling_moment(&self, refusal: &Refusal) -> Option<CouplingMoment> {
        match (&self.body, refusal) {
            (Body::Axis { axis, .. }, Refusal::Saw(_)) => axis.coupling_moment(),
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

    pub(super) fn snapshot(&self) -> SlaveSnapshot {
        let drive = self.drive();
        SlaveSnapshot {
            id: self.id,
            status: self.status(),
            phase: self.phase(),
            error: self.error(),
            refusal: self.refusal,
            set: self.set(),
            drive: DriveSnapshot {
                state: drive.state(),
                position: self.actual_position(),
                velocity: drive.velocity(),
                following_error: drive.following_error(),
            },
            program: self.program.as_ref().map(Program::snapshot),
            cuts: self.tool.cuts() + self.program.as_ref().map_or(0, Program::cuts),
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

    fn drive(&self) -> &Drive {
        match &self.body {
            Body::Follower(follower) => follower.drive(),
            Body::Axis { axis, .. } => axis.drive(),
        }
    }

    fn actual_position(&self) -> f64 {
        match &self.body {
            Body::Follower(follower) => follower.drive().position(),
            Body::Axis { axis, .. } => axis.actual_position(),
        }
    }
}

const fn no_limits(command: &Command) -> Refusal {
    Refusal::NoLimits {
        command: command.name(),
    }
}
