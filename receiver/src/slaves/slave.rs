//! A slave: program, commands, coupling and life cycle, drive.

use coaxle_axis::drive::DriveKind;
use coaxle_axis::{
    AxisStatus, CommandState, CoupleState, Job, Modulo, NcToPlcAxis, Origin, StateWord,
};
use coaxle_cam::Tables;
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_node::CommandOutcome;
use coaxle_node::command::{SawAttempt, SawView, SlaveOrder, SlaveView};
use coaxle_slave::{
    Change, Command, CoupledStart, CouplingPhase, CouplingRefusal, EndedJob, JobError,
    OnMasterLoss, Refusal, SlaveAxis, SlaveError,
};

use super::Master;
use super::for_program::{end_of, situation};
use super::masters::SlaveMasters;
use super::tool::Tool;
use crate::config::MasterRef;
use crate::program::{BlockedProgram, Due, Program};
use crate::signals::SlaveSignals;
use crate::snapshot::{RefusedCommand, SlaveFaults};

/// A slave.
#[derive(Debug)]
pub(super) struct Slave {
    id: u32,
    /// Masters, at least one.
    sources: Box<[MasterRef]>,
    /// Modulo period of the first master.
    master_modulo: Option<Modulo>,
    /// Position of the first master in this cycle; none before its first data.
    master_position: Option<f64>,
    pub(super) axis: Box<SlaveAxis>,
    /// Coupling from the start, pending until there is a master.
    start: Option<CoupledStart>,
    /// True if it continues to follow a master that is lost or in error, whose error it forwards.
    follows: bool,
    error_of_master: u32,
    drive_kind: DriveKind,
    tool: Tool,
    program: Option<Program>,
    /// The command that was refused last.
    refusal: Option<RefusedCommand>,
    /// True if the coupling from the start was refused.
    start_refused: bool,
    /// Times that it was set back to what its drive was shown, and true if it was in the newest cycle.
    set_backs: u32,
    was_set_back: bool,
}

/// The parts of a slave.
pub(super) struct SlaveParts {
    pub(super) id: u32,
    pub(super) sources: Box<[MasterRef]>,
    pub(super) master_modulo: Option<Modulo>,
    pub(super) axis: Box<SlaveAxis>,
    pub(super) start: Option<CoupledStart>,
    pub(super) on_master_loss: OnMasterLoss,
    pub(super) tool: Tool,
    pub(super) program: Option<Program>,
}

impl Slave {
    pub(super) fn new(parts: SlaveParts) -> Self {
        Self {
            id: parts.id,
            sources: parts.sources,
            master_modulo: parts.master_modulo,
            master_position: None,
            drive_kind: parts.axis.drive().kind(),
            axis: parts.axis,
            start: parts.start,
            follows: parts.on_master_loss == OnMasterLoss::Follow,
            error_of_master: 0,
            tool: parts.tool,
            program: parts.program,
            refusal: None,
            start_refused: false,
            set_backs: 0,
            was_set_back: false,
        }
    }

    /// Runs one cycle.
    pub(super) fn cycle(
        &mut self,
        plates: &mut Tables,
        masters: &SlaveMasters<'_>,
        elapsed: Seconds,
    ) {
        self.follow(plates, masters, elapsed);
        self.watch_tool();
        let set_backs = self.axis.set_back_count();
        self.was_set_back = std::mem::replace(&mut self.set_backs, set_backs) != set_backs;
    }

    /// True if it was set back in the newest cycle to what its drive is shown.
    pub(super) const fn was_set_back(&self) -> bool {
        self.was_set_back
    }

    /// True if neither it nor its drive moves.
    pub(super) fn rests(&self) -> bool {
        self.start.is_some() || self.axis.rests()
    }

    fn follow(&mut self, plates: &mut Tables, masters: &SlaveMasters<'_>, elapsed: Seconds) {
        self.master_position = masters.first().map(|master| master.set.position);
        // Before the axis moves, so that a step takes effect in the cycle in which its conditions hold.
        self.run_program(plates, masters, elapsed);
        // Of every master that counts: a sum is as wrong by its second part as by its first.
        self.error_of_master = if self.follows {
            masters.error_code(|number| self.axis.follows_master(number))
        } else {
            0
        };
        // The start has placed the axis for this cycle. A second update would move it by a cycle.
        if self.start(plates, masters) {
            return;
        }
        self.axis
            .update(plates, *masters.as_couplings_see(), elapsed);
        self.take_ended_jobs();
    }

    /// Takes the results of jobs that have ended: some are refused only when they are due.
    fn take_ended_jobs(&mut self) {
        // Points that wait have no job that could end.
        if let Some(held_back) = self.axis.take_held_back() {
            self.note_refusal(held_back);
        }
        // All of them: a command that takes over ends several jobs in a cycle.
        while let Some(EndedJob { job, state }) = self.axis.take_ended() {
            let CommandState::Failed(JobError::Refused(refusal)) = state else {
                continue;
            };
            self.refusal = Some(RefusedCommand::when_due(refusal, job));
            if let (Origin::Program, Some(program)) = (job.origin, &mut self.program) {
                program.refused_late();
            }
        }
    }

    /// Counts the cuts of its tool, after each cycle.
    fn watch_tool(&mut self) {
        let in_sync = self.phase() == Some(CouplingPhase::InSync);
        self.tool.is_at(in_sync.then(|| self.axis.set().position));
    }

    /// Executes a command: the single path for commands of every origin.
    pub(super) fn command(
        &mut self,
        plates: &mut Tables,
        command: &Command,
        origin: Origin,
    ) -> Result<Job, Refusal> {
        let change = self.axis.plan(plates, command);
        self.apply(plates, change, origin)
    }

    fn apply(
        &mut self,
        plates: &mut Tables,
        change: Result<Change, Refusal>,
        origin: Origin,
    ) -> Result<Job, Refusal> {
        let applied = change.map(|change| {
            // A motion or the power by command replaces the coupling from the start, which would preset the position
            // later. A reset or points of a plate do not: without it the slave would never couple.
            if change.decides_motion() {
                self.start = None;
            }
            self.axis.apply(plates, change, origin)
        });
        self.refusal = match applied {
            // An accepted command leaves the last refusal visible: the next one of a program would hide it within a
            // cycle.
            Ok(_) => self.refusal,
            Err(refusal) => Some(refusal.into()),
        };
        applied
    }

    fn run_program(&mut self, plates: &mut Tables, masters: &SlaveMasters<'_>, elapsed: Seconds) {
        let (axis, Some(program)) = (&self.axis, &mut self.program) else {
            return;
        };
        // A copy of what the program may know, because the program is changed while the axis is only read.
        let situation = situation(
            axis,
            plates,
            self.start.is_some(),
            masters,
            self.master_modulo,
        );
        program.look(&situation, |job| end_of(axis, job));
        // A position by a clock that is not known yet may jump, and marks would pass that never came.
        let ready = masters.first().filter(|master| master.is_ready);
        program.advance(elapsed, ready.map(|master| master.set.position));
        let Some(command) = program.due(&situation, || axis.master_scaling(plates)) else {
            return;
        };
        // Before the step's command: a step that may not cut has no effect at all.
        let cut = if program.cuts_next() {
            axis.check_cut()
        } else {
            Ok(())
        };
        let answer = match (cut, command) {
            (Err(refusal), _) => {
                self.note_refusal(refusal);
                Err(refusal)
            }
            (Ok(()), Some(command)) => self.execute_step(plates, &command),
            (Ok(()), None) => Ok(None),
        };
        if let Some(program) = &mut self.program {
            program.take(answer);
        }
    }

    /// Executes a command of its program; those on the plates have no job.
    fn execute_step(&mut self, plates: &mut Tables, due: &Due) -> Result<Option<Job>, Refusal> {
        let done = match due {
            Due::Slave(command) => return self.command(plates, command, Origin::Program).map(Some),
            Due::SelectPlate { plate, replace } => plates.select_reserved(*plate, *replace),
            Due::DeletePlate { table } => plates.put_away(*table),
        };
        done.map(|()| None).map_err(|error| {
            let refusal = Refusal::Coupling(CouplingRefusal::Cam(error));
            self.note_refusal(refusal);
            refusal
        })
    }

    /// Couples it from the start, once there is its first master: it then starts at its coupled position.
    fn start(&mut self, plates: &mut Tables, masters: &SlaveMasters<'_>) -> bool {
        let is_there = |master: &Master| master.is_ready || self.follows;
        // Until then the coupling stays pending: it is tried only once.
        if !masters.first().is_some_and(is_there) {
            return false;
        }
        let Some(start) = self.start.take() else {
            return false;
        };
        let masters = *masters.as_couplings_see();
        match (
            self.axis.switch_on_coupled(plates, &start, masters),
            &mut self.program,
        ) {
            (Ok(job), Some(program)) => program.started(job),
            (Ok(_), None) => {}
            (Err(refusal), _) => {
                self.refusal = Some(refusal.into());
                self.start_refused = true;
            }
        }
        !self.start_refused
    }

    /// Axis id.
    pub(super) const fn id(&self) -> u32 {
        self.id
    }

    /// True if it runs a program.
    pub(super) const fn has_program(&self) -> bool {
        self.program.is_some()
    }

    pub(super) const fn sources(&self) -> &[MasterRef] {
        &self.sources
    }

    /// True if it continues to follow a master that is lost or in error.
    pub(super) const fn follows(&self) -> bool {
        self.follows
    }

    /// The slave as a master of another; none before coupling, if coupled from the start.
    pub(super) fn as_master(&self) -> Option<Master> {
        let error = self.error();
        Some(Master {
            set: self.set()?,
            travel: None,
            is_sound: error.is_none(),
            is_ready: self.axis.is_operational(),
            // Its own error goes before the one that it forwards.
            error_code: error.map_or(self.error_of_master, |error| error.code()),
        })
    }

    /// Writes its published axis structure; `leads` is true if it leads another. Before coupling,
    /// if coupled from the start, it writes none and returns false.
    pub(super) fn write_axis(&self, plates: &Tables, leads: bool, axis: &mut NcToPlcAxis) -> bool {
        if self.set().is_none() {
            return false;
        }
        self.axis.write_axis_struct(plates, self.id, axis);
        if leads {
            axis.couple_state = match axis.couple_state {
                CoupleState::Slave => CoupleState::MasterSlave,
                _ => CoupleState::Master,
            };
        }
        // Only without an error of its own, which names the nearer cause.
        if axis.error_code == 0 && self.error_of_master != 0 {
            axis.error_code = self.error_of_master;
            axis.state_word.insert(StateWord::ERROR);
        }
        true
    }

    pub(super) const fn error(&self) -> Option<SlaveError> {
        self.axis.error()
    }

    /// True if it moves with its masters, at the position of its coupling.
    pub(super) fn is_in_sync(&self) -> bool {
        let phase = self.phase().filter(|_| self.start.is_none());
        phase.is_some_and(CouplingPhase::is_in_sync)
    }

    /// True if its limits hold it away from the position of its coupling.
    pub(super) fn is_behind(&self) -> bool {
        self.phase() == Some(CouplingPhase::Behind)
    }

    /// True if a coupling or command from its config was refused.
    pub(super) fn is_refused(&self) -> bool {
        self.start_refused || self.program.as_ref().is_some_and(Program::is_refused)
    }

    /// The slave's program, if it waits for an impossible event or has waited for too long.
    pub(super) fn blocked_program(&self) -> Option<BlockedProgram> {
        self.program.as_ref()?.blocked()
    }

    /// Executes an order from the network. A dry run is a plan that is not applied.
    pub(super) fn execute(&mut self, plates: &mut Tables, order: &SlaveOrder) -> CommandOutcome {
        let planned = self.axis.plan(plates, &order.command);
        let saw = (planned.as_ref().err()).and_then(|refusal| self.attempt(order, refusal));
        // After the attempt of a saw was noted, whose figures belong to the axis before the command.
        let (job, planned) = match planned {
            Ok(change) if !order.dry_run => {
                let at_once = change.is_done_at_once();
                let planned = Ok(change);
                match self.apply(plates, Ok(change), Origin::Order) {
                    // Commands that are done at once share the number 0, which nobody can ask for.
                    Ok(job) => (Some(job.number).filter(|_| !at_once), planned),
                    Err(refusal) => (None, Err(refusal)),
                }
            }
            Err(refusal) if !order.dry_run => {
                self.note_refusal(refusal);
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
                sync_positions: change.sync_positions(),
                saw: change.saw_plan().map(|plan| SawView {
                    plan: *plan,
                    axis_id: self.id,
                }),
            },
            Err(refusal) => CommandOutcome::Refused {
                refusal,
                slave,
                saw,
            },
        }
    }

    /// Notes the last refusal, for status and signals.
    pub(super) fn note_refusal(&mut self, refusal: Refusal) {
        self.refusal = Some(refusal.into());
    }

    /// The attempted command of a refused flying saw, and its coupling moment.
    fn attempt(&self, order: &SlaveOrder, refusal: &Refusal) -> Option<SawAttempt> {
        if !matches!(refusal, Refusal::Coupling(CouplingRefusal::Saw(_))) {
            return None;
        }
        Some(SawAttempt {
            command: self.axis.saw_command(&order.command)?,
            moment: self.axis.coupling_moment()?,
        })
    }

    /// The slave's state for the response to a command.
    pub(super) fn view(&self) -> SlaveView {
        let set = self.axis.set();
        SlaveView {
            status: self.status(),
            coupling: self.phase(),
            position: set.position,
            velocity: set.velocity,
        }
    }

    /// Writes its faults. Called in every cycle, so absent ones are not copied.
    pub(super) fn show_faults(&self, faults: &mut SlaveFaults) {
        match self.error() {
            None => faults.error = None,
            error => faults.error = error,
        }
        match self.refusal {
            None => faults.refusal = None,
            refusal => faults.refusal = refusal,
        }
        match self.blocked_program() {
            None => faults.blocked = None,
            blocked => faults.blocked = blocked,
        }
    }

    /// Writes its signals.
    pub(super) fn show(&self, plates: &Tables, faults: &SlaveFaults, signals: &mut SlaveSignals) {
        let (drive, set) = (self.axis.actual(), self.set());
        let attachment = drive.attachment;
        let program = self.program.as_ref().map(Program::snapshot);
        let sync = self.axis.sync_positions();
        let phase = self.phase();
        let cam = phase.and_then(|_| self.axis.cam_state(plates));
        let queued = self.axis.cam_queued(plates);
        *signals = SlaveSignals {
            position: set.map(|set| set.position),
            modulo_position: position_within_period(
                set.map(|set| set.position),
                self.axis.modulo(),
            ),
            master_position: self.master_position,
            master_modulo_position: position_within_period(
                self.master_position,
                self.master_modulo,
            ),
            slave_sync_position: sync.map(|sync| sync.slave),
            master_sync_position: sync.map(|sync| sync.master),
            velocity: set.map(|set| set.velocity),
            acceleration: set.map(|set| set.acceleration),
            guard: self.axis.tracking(),
            distance: self.axis.distance(),
            set_anew: self.axis.preset_count(),
            state: self.status(),
            phase,
            cam_table: cam.map(|cam| cam.table),
            cam_master_position: cam.map(|cam| cam.master_cam_position),
            cam_slave_position: cam.map(|cam| cam.slave_cam_position),
            cam_table_queued: queued.contains(StateWord::CAM_TABLE_QUEUED),
            cam_data_queued: queued.contains(StateWord::CAM_DATA_QUEUED),
            cam_scaling_pending: queued.contains(StateWord::CAM_SCALING_PENDING),
            error: faults.error.map_or(0, |error| error.code()),
            refusal: faults.refusal.map_or(0, |refusal| refusal.code()),
            program: program.map(|program| program.state),
            program_step: program.map(|program| program.step),
            program_waits_for: program.and_then(|program| program.waits_for),
            program_outcome: program.and_then(|program| program.outcome),
            cuts: self.tool.cuts() + self.program.as_ref().map_or(0, Program::cuts),
            drive_kind: self.drive_kind,
            drive_attached: attachment.map(|attachment| attachment.attached),
            drive_heartbeat_age: attachment.and_then(|attachment| attachment.heartbeat_age),
            held_back_us: self.axis.held_back_by().as_micros_f64(),
            shown_position: set.map(|_| self.axis.shown().position),
            set_back: self.axis.set_back_count(),
            drive_state: drive.state,
            drive_position: self.axis.actual_position(),
            drive_velocity: drive.velocity,
            following_error: drive.following_error,
        };
    }

    /// Set values; none before coupling, if coupled from the start, because its position is known
    /// only then.
    fn set(&self) -> Option<Kinematics> {
        // Published, the position of the idle drive would look like a jump once the coupling begins.
        self.start.is_none().then(|| self.axis.set())
    }

    const fn status(&self) -> AxisStatus {
        self.axis.status()
    }

    fn phase(&self) -> Option<CouplingPhase> {
        self.axis.coupling_phase()
    }
}

/// A position within its modulo period; none without one.
fn position_within_period(position: Option<f64>, modulo: Option<Modulo>) -> Option<f64> {
    Some(modulo?.of(position?).within)
}
