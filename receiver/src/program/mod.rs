//! The program of a slave: a sequence of steps, each with a condition and a command, as in a PLC.
//!
//! At most one step per cycle. A step is taken when its whole condition holds. After trouble with a
//! command the program continues with the step named in `otherwise`. Without one, a refusal ends
//! the program, unless the step expects it; after other trouble the program keeps waiting for its
//! step, and reports when the step can no longer be taken.

mod at_mark;
mod branches;
mod commanded;
mod condition;
mod config;
mod due;
mod master_reaches;
mod outcome;
mod prospect;
mod sensor;
mod situation;
mod state;
mod step_command;

use coaxle_axis::Job;
use coaxle_cam::ReservedPlate;
use coaxle_clock::Seconds;
use coaxle_node::config::{Positive, Wrong};
use coaxle_slave::Refusal;

use crate::marks::MarksConfig;
use branches::Branches;
use commanded::Commanded;
use prospect::Prospect;
use sensor::{Sensor, SensorMark};
use situation::{Inputs, ProgramInputs};

pub use condition::{WaitsFor, When};
pub use config::{Otherwise, StepConfig};
pub(crate) use due::Due;
pub use master_reaches::{AwaitedPlace, InTurn, MasterReaches};
pub use outcome::{Outcome, Trouble};
pub(crate) use situation::Situation;
pub use state::{BlockedProgram, ProgramSnapshot, ProgramState};
pub use step_command::StepCommand;

/// A program and its progress.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    steps: Vec<Step>,
    /// Sensor of the marks; none without marks.
    sensor: Option<Sensor>,
    /// The step that is waited for.
    at: usize,
    state: ProgramState,
    /// The unmet condition that it waits for.
    waits_for: Option<WaitsFor>,
    commanded: Commanded,
    /// True if a step waited for too long, and no command was given since.
    timed_out: bool,
    since_start: Seconds,
    since_step: Seconds,
    /// Number of cuts done.
    cuts: u64,
}

/// A step as the scan needs it.
#[derive(Clone, Debug)]
struct Step {
    when: When,
    command: Option<Due>,
    /// True if the command's master positions count from a mark, which is used up.
    at_mark: bool,
    /// True if the tool cuts.
    cut: bool,
    /// The code of the refusal that is expected.
    expected: Option<u32>,
    /// The step to go on with.
    next: usize,
    /// Longest wait since the step before.
    timeout: Option<Positive>,
    /// The steps to go on with if it cannot be taken.
    otherwise: Branches,
}

impl Step {
    /// Unmet conditions, with their prospects.
    fn unmet(&self, inputs: Inputs<'_>) -> impl Iterator<Item = (WaitsFor, Prospect)> + use<> {
        let needs_mark = self.at_mark && !inputs.passed.mark_seen;
        let mark = needs_mark.then(|| (WaitsFor::AtMark, prospect::by_master(&inputs)));
        self.when.unmet(inputs).chain(mark)
    }

    /// The command, with its positions at the mark if required.
    fn placed(
        &self,
        mark: Option<&SensorMark>,
        master_scaling: impl FnOnce() -> f64,
    ) -> Option<Due> {
        match (mark, &self.command) {
            (Some(mark), Some(Due::Slave(command))) if self.at_mark => {
                Some(Due::Slave(at_mark::placed(command, mark, master_scaling())))
            }
            _ => self.command,
        }
    }
}

impl Program {
    /// Creates the program of these steps, with the marks they may use and, for each step that
    /// loads a plate, that plate; none without steps.
    ///
    /// # Errors
    /// [`Wrong`] names the step and the field.
    pub(crate) fn new(
        steps: &[StepConfig],
        marks: Option<&MarksConfig>,
        plates: &[Option<ReservedPlate>],
    ) -> Result<Option<Self>, Wrong> {
        if steps.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self {
            steps: config::checked(steps, marks.is_some(), plates)?,
            sensor: marks.copied().map(Sensor::new),
            at: 0,
            state: ProgramState::Running,
            waits_for: None,
            commanded: Commanded::default(),
            timed_out: false,
            since_start: Seconds::ZERO,
            since_step: Seconds::ZERO,
            cuts: 0,
        }))
    }

    /// Advances the time since the last scan. The sensor of marks needs the master's position; none
    /// while the master is not ready.
    pub(crate) fn advance(&mut self, elapsed: Seconds, master: Option<f64>) {
        self.since_start = self.since_start + elapsed;
        self.since_step = self.since_step + elapsed;
        if let Some(sensor) = &mut self.sensor {
            sensor.look(master);
        }
    }

    /// Collects the results of its commands. `end_of` returns the end of a job, if it has ended.
    pub(crate) fn look(&mut self, now: &Situation<'_>, end_of: impl Fn(Job) -> Option<Outcome>) {
        let waited_for_order = self.state == ProgramState::WaitingForOrder;
        self.commanded.look(now, waited_for_order, end_of);
    }

    /// Returns the command of the next step if the step is to be taken now, which may be none.
    /// `master_scaling` returns the scaling of the plate that couples the slave.
    pub(crate) fn due(
        &mut self,
        now: &Situation<'_>,
        master_scaling: impl FnOnce() -> f64,
    ) -> Option<Option<Due>> {
        if self.state.is_end() || self.turns_off() {
            return None;
        }
        let step = self.steps.get(self.at)?;
        let mark = self.sensor.as_ref().and_then(Sensor::mark);
        let passed = self.passed(mark.as_ref());
        let unmet = step.unmet(Inputs {
            slave: now,
            passed: &passed,
            is_busy: self.commanded.is_busy(),
        });
        let Some((waits_for, prospect)) = condition::hardest(unmet) else {
            return Some(step.placed(mark.as_ref(), master_scaling));
        };
        self.wait(waits_for, prospect);
        None
    }

    /// Branches or ends, if there was trouble that the step handles.
    fn turns_off(&mut self) -> bool {
        let Some(trouble) = self.commanded.trouble() else {
            return false;
        };
        let Some(step) = self.steps.get(self.at) else {
            return false;
        };
        let is_refusal = trouble == Trouble::Outcome(Outcome::Refused);
        if let Some(to) = step.otherwise.of(trouble) {
            self.commanded.handled();
            self.go_on(to);
        } else if is_refusal && step.when.refused != Some(true) {
            self.end(ProgramState::Refused);
        } else {
            return false;
        }
        true
    }

    fn passed(&self, mark: Option<&SensorMark>) -> ProgramInputs {
        ProgramInputs {
            since_start: self.since_start,
            since_step: self.since_step,
            mark_seen: mark.is_some(),
            outcome: self.commanded.outcome(),
            timed_out: self.timed_out,
        }
    }

    /// The step cannot be taken yet.
    fn wait(&mut self, waits_for: WaitsFor, prospect: Prospect) {
        self.waits_for = Some(waits_for);
        let has_trouble = self.commanded.trouble().is_some();
        self.state = match prospect {
            Prospect::Spontaneous => ProgramState::Running,
            Prospect::ByMaster => ProgramState::WaitingForMaster,
            Prospect::ByOrder if !has_trouble => ProgramState::WaitingForOrder,
            Prospect::ByOrder | Prospect::Never => ProgramState::Blocked,
        };
        let Some(step) = self.steps.get(self.at) else {
            return;
        };
        let is_too_long = |timeout: Positive| self.since_step.0 >= timeout.get();
        if !step.timeout.is_some_and(is_too_long) {
            return;
        }
        match step.otherwise.of(Trouble::TimedOut) {
            Some(to) => {
                self.timed_out = true;
                self.go_on(to);
            }
            None => self.state = ProgramState::TimedOut,
        }
    }

    /// Notes that the step was taken, with the result of its command.
    pub(crate) fn take(&mut self, answer: Result<Option<Job>, Refusal>) {
        let Some(step) = self.steps.get(self.at) else {
            return;
        };
        if let (true, Some(sensor)) = (step.at_mark, &mut self.sensor) {
            sensor.use_up();
        }
        self.cuts += u64::from(step.cut && answer.is_ok());
        let next = match answer {
            Ok(job) => self.accepted(job),
            Err(refusal) => self.refused(&refusal),
        };
        match next {
            Ok(to) => self.go_on(to),
            Err(state) => self.end(state),
        }
    }

    /// The next step, or the end state of the program.
    fn accepted(&mut self, job: Option<Job>) -> Result<usize, ProgramState> {
        let step = &self.steps[self.at];
        if let (Some(Due::Slave(command)), Some(job)) = (&step.command, job) {
            self.commanded.accepted(command, job);
        }
        self.timed_out &= step.command.is_none();
        if step.when.handles_trouble() {
            self.commanded.handled();
        }
        match step.expected {
            None => Ok(step.next),
            Some(_) => Err(ProgramState::NotAsExpected),
        }
    }

    /// The next step after a refused command, or the end state of the program.
    fn refused(&mut self, refusal: &Refusal) -> Result<usize, ProgramState> {
        let step = &self.steps[self.at];
        match (step.expected, step.otherwise.refused) {
            (Some(code), _) if refusal.code() == code => Ok(step.next),
            (Some(_), _) => Err(ProgramState::NotAsExpected),
            (None, Some(to)) => {
                self.commanded.refused();
                self.commanded.handled();
                Ok(to)
            }
            (None, None) => Err(ProgramState::Refused),
        }
    }

    fn go_on(&mut self, to: usize) {
        self.waits_for = None;
        if to < self.steps.len() {
            self.at = to;
            self.since_step = Seconds::ZERO;
            self.state = ProgramState::Running;
        } else {
            self.state = ProgramState::Finished;
        }
    }

    const fn end(&mut self, state: ProgramState) {
        self.waits_for = None;
        self.state = state;
    }

    /// Notes the job that coupled the slave from the start.
    pub(crate) const fn started(&mut self, job: Job) {
        self.commanded.started(job);
    }

    /// Notes a command that was refused after it had been accepted.
    pub(crate) fn refused_late(&mut self) {
        match self.state {
            ProgramState::Finished => self.end(ProgramState::Refused),
            _ => self.commanded.refused(),
        }
    }

    /// True if it ended by a refusal, or by the lack of an expected one.
    pub(crate) const fn is_refused(&self) -> bool {
        matches!(
            self.state,
            ProgramState::Refused | ProgramState::NotAsExpected
        )
    }

    /// Reason why it is blocked, if none of its own commands can change that.
    pub(crate) fn blocked(&self) -> Option<BlockedProgram> {
        let trouble = match self.state {
            ProgramState::Blocked => (self.commanded.trouble()).unwrap_or(Trouble::NothingUnderWay),
            ProgramState::TimedOut => Trouble::TimedOut,
            _ => return None,
        };
        Some(BlockedProgram {
            step: self.step(),
            waits_for: self.waits_for?,
            trouble,
        })
    }

    /// True if the tool cuts with the step that is due.
    pub(crate) fn cuts_next(&self) -> bool {
        self.steps.get(self.at).is_some_and(|step| step.cut)
    }

    /// Number of cuts done by its steps.
    pub(crate) const fn cuts(&self) -> u64 {
        self.cuts
    }

    const fn step(&self) -> u16 {
        self.at as u16 + 1
    }

    pub(crate) const fn snapshot(&self) -> ProgramSnapshot {
        ProgramSnapshot {
            state: self.state,
            step: self.step(),
            waits_for: self.waits_for,
            outcome: self.commanded.outcome(),
        }
    }
}

#[cfg(test)]
mod tests;
