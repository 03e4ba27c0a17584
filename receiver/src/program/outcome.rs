//! What became of the commands of a program.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What became of a command of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It has come to its end.
    Done,
    /// Something else cut it short: an order, or the loss of power.
    Aborted,
    /// The slave came to an error stop, while it was busy or afterwards.
    Failed,
    /// It was refused: at once, or when it was due.
    Refused,
    /// The master of its flying saw ran back past the coupling position.
    RolledBack,
}

/// What keeps a program from going on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Trouble {
    /// Its command did not come to its end.
    Outcome(Outcome),
    /// Its command was done, and another one, which is not its own, has taken the slave over.
    TakenOver,
    /// It waits for what becomes of a command, and none of its own is under way.
    NothingUnderWay,
    /// The step waited for longer than it may.
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
