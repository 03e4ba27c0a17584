//! The command that a slave axis is busy with.

use coaxle_axis::CommandState;

use super::error::SlaveError;

/// Names an accepted command, until 65,535 others have been accepted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct JobNumber(pub u16);

/// The command under way, or the last one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Job {
    number: JobNumber,
    state: CommandState<SlaveError>,
    /// The one before, if it was done: who asked for it may not have seen that yet.
    done_before: Option<JobNumber>,
}

impl Job {
    /// A new command takes over.
    pub(super) fn replace(&mut self, state: CommandState<SlaveError>) -> JobNumber {
        self.done_before = (self.state == CommandState::Done).then_some(self.number);
        // 0 is no command.
        self.number = JobNumber(self.number.0.checked_add(1).unwrap_or(1));
        self.state = state;
        self.number
    }

    /// The command is as far as that, unless it has already ended.
    pub(super) fn set(&mut self, state: CommandState<SlaveError>) {
        if self.is_busy() {
            self.state = state;
        }
    }

    pub(super) const fn is_busy(&self) -> bool {
        matches!(
            self.state,
            CommandState::Waiting | CommandState::Active | CommandState::InSync
        )
    }

    pub(super) const fn number(&self) -> JobNumber {
        self.number
    }

    pub(super) const fn state(&self) -> CommandState<SlaveError> {
        self.state
    }

    /// How far a command is.
    pub(super) fn progress(&self, number: JobNumber) -> CommandState<SlaveError> {
        if number == self.number {
            self.state
        } else if Some(number) == self.done_before {
            CommandState::Done
        } else {
            CommandState::Aborted
        }
    }
}
