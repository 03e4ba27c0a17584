//! Progress of a program, for display.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::condition::WaitsFor;
use super::outcome::{Outcome, Trouble};

/// Progress of a program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProgramSnapshot {
    /// State of the program.
    pub state: ProgramState,
    /// The step that it waits for, or that it ended with, from 1.
    pub step: u16,
    /// Condition that it waits for, if any.
    pub waits_for: Option<WaitsFor>,
    /// Result of its last command; none while that is under way, and before there was one.
    pub outcome: Option<Outcome>,
}

/// State of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProgramState {
    /// Waiting for its next step.
    Running,
    /// Waiting for a condition that requires the master.
    WaitingForMaster,
    /// Waiting for a condition that only a command from outside can meet.
    WaitingForOrder,
    /// Waiting for a condition that cannot be met, because its own command did not complete or no
    /// cause exists.
    Blocked,
    /// Finished with its last step.
    Finished,
    /// Ended by a refused command.
    Refused,
    /// Ended by a command that was accepted instead of refused, or refused for another reason.
    NotAsExpected,
    /// Ended by a step that waited longer than allowed.
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

/// A program that waits for an impossible event, or has waited for too long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockedProgram {
    /// The step that it waits for, from 1.
    pub step: u16,
    /// Condition that the step waits for.
    pub waits_for: WaitsFor,
    /// Reason why the condition is not met.
    pub trouble: Trouble,
}

impl BlockedProgram {
    /// NC error code: 0x4b07, a timeout; an impossible wait counts as one.
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
