//! The program of a slave: a sequence of steps, each with a condition and a command, as a PLC has it.
//!
//! One step at most in a cycle. A step is taken when all of its condition holds; a command that is
//! refused ends the program, unless the step expects just that.

mod condition;
mod config;

use coaxle_clock::Seconds;
use coaxle_motion::slave::{Command, Refusal};
use serde::{Deserialize, Serialize};

pub(crate) use condition::Situation;
pub use config::{StepConfig, When, WrongStep};

/// A program, and how far it is.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    steps: Vec<Step>,
    /// The step that is waited for.
    at: usize,
    state: ProgramState,
    since_start: Seconds,
    since_step: Seconds,
}

/// A step as the scan needs it.
#[derive(Clone, Debug)]
struct Step {
    when: When,
    command: Option<Command>,
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
    /// The program of these steps; none without any.
    ///
    /// # Errors
    /// [`WrongStep`] names the step and the field.
    pub(crate) fn new(steps: &[StepConfig]) -> Result<Option<Self>, WrongStep> {
        if steps.is_empty() {
            return Ok(None);
        }
        Ok(Some(Self {
            steps: config::checked(steps)?,
            at: 0,
            state: ProgramState::Running,
            since_start: Seconds::ZERO,
            since_step: Seconds::ZERO,
        }))
    }

    /// The time since the last scan has passed.
    pub(crate) fn advance(&mut self, elapsed: Seconds) {
        self.since_start = self.since_start + elapsed;
        self.since_step = self.since_step + elapsed;
    }

    /// Whether the next step is to be taken now, and the command to give if it has one.
    pub(crate) fn due(&self, situation: &Situation) -> Option<Option<Command>> {
        if self.state != ProgramState::Running {
            return None;
        }
        let step = self.steps.get(self.at)?;
        step.when
            .holds(situation, self.since_start, self.since_step)
            .then_some(step.command)
    }

    /// The step was taken, and its command answered so.
    pub(crate) fn take(&mut self, answer: Result<(), Refusal>) {
        let Some(step) = self.steps.get(self.at) else {
            return;
        };
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

    pub(crate) const fn snapshot(&self) -> ProgramSnapshot {
        ProgramSnapshot {
            state: self.state,
            step: self.at as u16 + 1,
        }
    }
}

#[cfg(test)]
mod tests;
