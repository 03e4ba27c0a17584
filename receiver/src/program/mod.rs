//! The program of a slave: a sequence of steps, each with a condition and a command, as a PLC has it.
//!
//! One step at most in a cycle. A step is taken when all of its condition holds; a command that is
//! refused ends the program, unless the step expects just that.

mod at_mark;
mod condition;
mod config;
mod sensor;

use coaxle_clock::Seconds;
use coaxle_slave::{Command, Refusal};
use serde::{Deserialize, Serialize};

use crate::marks::MarksConfig;
use sensor::Sensor;

use condition::Passed;
pub(crate) use condition::Situation;
pub use config::{StepConfig, When, WrongStep};

/// A program, and how far it is.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    steps: Vec<Step>,
    /// None without marks.
    sensor: Option<Sensor>,
    /// The step that is waited for.
    at: usize,
    state: ProgramState,
    since_start: Seconds,
    since_step: Seconds,
    /// Cuts done.
    cuts: u64,
}

/// A step as the scan needs it.
#[derive(Clone, Debug)]
struct Step {
    when: When,
    command: Option<Command>,
    /// The command's positions of the master count from a mark, which is used up.
    at_mark: bool,
    /// The tool cuts.
    cut: bool,
    /// The code of the refusal that is expected.
    expected: Option<u32>,
    /// The step to go on with.
    next: usize,
}

/// How far a program is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramSnapshot {
    /// Whether it goes on.
    pub state: ProgramState,
    /// The step that it waits for, or that it ended with, from 1.
    pub step: u16,
}

/// Whether a program goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProgramState {
    /// It waits for its next step.
    Running,
    /// Its last step was taken.
    Finished,
    /// A command was refused.
    Refused,
    /// A command was accepted that should have been refused, or refused for another reason.
    NotAsExpected,
}

impl Program {
    /// The program of these steps, with the marks they may ask for; none without any.
    ///
    /// # Errors
    /// [`WrongStep`] names the step and the field.
    pub(crate) fn new(
        steps: &[StepConfig],
        marks: Option<&MarksConfig>,
    ) -> Result<Option<Self>, WrongStep> {
        if steps.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self {
            steps: config::checked(steps, marks.is_some())?,
            sensor: marks.copied().map(Sensor::new),
            at: 0,
            state: ProgramState::Running,
            since_start: Seconds::ZERO,
            since_step: Seconds::ZERO,
            cuts: 0,
        }))
    }

    /// The time since the last scan has passed. The sensor of marks needs the master's position; none
    /// as long as the master is not ready.
    pub(crate) fn advance(&mut self, elapsed: Seconds, master: Option<f64>) {
        self.since_start = self.since_start + elapsed;
        self.since_step = self.since_step + elapsed;
        if let Some(sensor) = &mut self.sensor {
            sensor.look(master);
        }
    }

    /// Whether the next step is to be taken now, and the command to give if it has one.
    /// `master_scaling` is asked for the scaling of the plate that couples the slave.
    pub(crate) fn due(
        &self,
        situation: &Situation,
        master_scaling: impl FnOnce() -> f64,
    ) -> Option<Option<Command>> {
        if self.state != ProgramState::Running {
            return None;
        }
        let step = self.steps.get(self.at)?;
        let mark = self.sensor.as_ref().and_then(Sensor::mark);
        let passed = Passed {
            since_start: self.since_start,
            since_step: self.since_step,
            mark_seen: mark.is_some(),
        };
        if !step.when.holds(situation, &passed) {
            return None;
        }
        if step.at_mark {
            let mark = mark?;
            let place = |command| at_mark::placed(command, &mark, master_scaling());
            return Some(step.command.as_ref().map(place));
        }
        Some(step.command)
    }

    /// The step was taken, and its command answered so.
    pub(crate) fn take(&mut self, answer: Result<(), Refusal>) {
        let Some(step) = self.steps.get(self.at) else {
            return;
        };
        if let (true, Some(sensor)) = (step.at_mark, &mut self.sensor) {
            sensor.use_up();
        }
        self.cuts += u64::from(step.cut && answer.is_ok());
        self.state = match (answer, step.expected) {
            (Ok(()), None) => ProgramState::Running,
            (Err(refusal), Some(code)) if refusal.code() == code => ProgramState::Running,
            (Err(_), None) => ProgramState::Refused,
            (Ok(()), Some(_)) | (Err(_), Some(_)) => ProgramState::NotAsExpected,
        };
        if self.state != ProgramState::Running {
            return;
        }
        if step.next < self.steps.len() {
            self.at = step.next;
            self.since_step = Seconds::ZERO;
        } else {
            self.state = ProgramState::Finished;
        }
    }

    /// One of its commands was refused after it had been accepted.
    pub(crate) const fn refused_late(&mut self) {
        self.state = ProgramState::Refused;
    }

    /// Whether it ended otherwise than it should.
    pub(crate) const fn is_refused(&self) -> bool {
        matches!(
            self.state,
            ProgramState::Refused | ProgramState::NotAsExpected
        )
    }

    /// Cuts done by its steps.
    pub(crate) const fn cuts(&self) -> u64 {
        self.cuts
    }

    pub(crate) const fn snapshot(&self) -> ProgramSnapshot {
        ProgramSnapshot {
            state: self.state,
            step: self.at as u16 + 1,
        }
    }
}

#[cfg(test)]
mod tests;
