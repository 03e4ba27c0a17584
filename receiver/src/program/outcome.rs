//! Results of the commands of a program.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Result of a command of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// Completed.
    Done,
    /// Aborted by an order, or by the loss of power.
    Aborted,
    /// Failed by an error stop of the slave, while it was busy or afterwards.
    Failed,
    /// Refused at once, or when it was due.
    Refused,
    /// Rolled back: the master of its flying saw ran back past the coupling position.
    RolledBack,
}

/// Reason why a program is blocked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trouble {
    /// Command that did not complete.
    Outcome(Outcome),
    /// Completed command, after which a foreign one has taken over the slave.
    TakenOver,
    /// Waiting for the result of a command when none is under way.
    NothingUnderWay,
    /// Step that waited longer than allowed.
    TimedOut,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Outcome(Outcome::Done) => "its command is done",
            Self::Outcome(Outcome::Aborted) => "its command was aborted",
            Self::Outcome(Outcome::Failed) => "the slave came to an error stop",
            Self::Outcome(Outcome::Refused) => "its command was refused",
            Self::Outcome(Outcome::RolledBack) => "its flying saw was rolled back",
            Self::TakenOver => "another command has taken the slave over",
            Self::NothingUnderWay => "none of its commands is under way",
            Self::TimedOut => "it has waited for longer than it may",
        })
    }
}
