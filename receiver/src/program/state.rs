//! How far a program is, for whoever looks at it.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::outcome::{Outcome, Trouble};
use super::prospect::WaitsFor;

/// How far a program is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramSnapshot {
    /// Whether it goes on.
    pub state: ProgramState,
    /// The step that it waits for, or that it ended with, from 1.
    pub step: u16,
    /// What it waits for, if it does.
    pub waits_for: Option<WaitsFor>,
    /// What became of its last command; none while that is under way, and before there was one.
    pub outcome: Option<Outcome>,
}

/// Whether a program goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProgramState {
    /// It waits for its next step.
    Running,
    /// Its next step waits for something that comes once the master is there.
    WaitingForMaster,
    /// Its next step waits for something that only a command from outside can bring.
    WaitingForOrder,
    /// The same, for its own command did not come to its end; or nothing at all can bring it.
    Blocked,
    /// Its last step was taken.
    Finished,
    /// A command was refused.
    Refused,
    /// A command was accepted that should have been refused, or refused for another reason.
    NotAsExpected,
    /// A step waited for longer than it may.
    TimedOut,
}

impl ProgramState {
    pub(super) const fn is_end(self) -> bool {
        match self {
            Self::Running | Self::WaitingForMaster | Self::WaitingForOrder | Self::Blocked => false,
            Self::Finished | Self::Refused | Self::NotAsExpected | Self::TimedOut => true,
        }
    }
}

/// A program that waits for what cannot come, or has waited for too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockedProgram {
    /// The step that it waits for, from 1.
    pub step: u16,
    /// What that waits for.
    pub waits_for: WaitsFor,
    /// Why that does not come.
    pub trouble: Trouble,
}

impl BlockedProgram {
    /// NC error code: 0x4b07, a timeout; what can never come is taken for one.
    pub const CODE: u32 = 0x4b07;
}

impl fmt::Display for BlockedProgram {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            step,
            waits_for,
            trouble,
        } = self;
        let ends = match trouble {
            Trouble::TimedOut => "",
            _ => ", which cannot come by itself",
        };
        write!(
            f,
            "step {step} of the program waits for {waits_for}{ends}: {trouble}"
        )
    }
}
