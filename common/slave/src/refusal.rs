//! Refusals of commands.

use core::fmt;

use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::{AxisStatus, CouplingPhase, NotPlanned, Transition};
use coaxle_curve::figure::Rounded;

use super::circle::CIRCLE_CODE;
use super::couplings::CouplingRefusal;
use super::sync_position::WrongSyncPosition;

/// Reason why a command is refused. A refused command has no effect.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Command not permitted in the axis's state.
    #[error("{:#06x}: {command}: the axis is in {status}, expected{}", self.code(), Before(.transition))]
    Status {
        /// The command, by its PLC name.
        command: &'static str,
        /// Arrow in the state diagram.
        transition: Transition,
        /// The state of the axis.
        status: AxisStatus,
    },
    /// Stop that would not end earlier than the current one.
    #[error(
        "{:#06x}: MC_Stop: the stop would take {} s, expected less than the {} s that are left of the \
         one under way: give it more deceleration or jerk",
        self.code(), Rounded(*received), Rounded(*left)
    )]
    WeakerStop {
        /// Duration of the stop, s.
        received: f64,
        /// Remaining duration of the current one, s.
        left: f64,
    },
    /// Axis not at rest.
    #[error("{:#06x}: velocity of the axis: received {} u/s, expected 0", self.code(), Rounded(*velocity))]
    NotAtRest {
        /// Set velocity, u/s.
        velocity: f64,
    },
    /// Limit of the axis exceeded.
    #[error(transparent)]
    Guard(GuardRefusal),
    /// No master to couple to, or one in error.
    #[error("{:#06x}: no master to couple to", self.code())]
    NoMaster,
    /// Axis that would follow itself across nodes.
    #[error(
        "{:#06x}: {command}: the axis would follow itself over other nodes, expected a master that does not follow it",
        self.code()
    )]
    FollowsItself {
        /// The command, by its PLC name.
        command: &'static str,
    },
    /// Coupling, or change to it, that is not possible.
    #[error("{0}")]
    Coupling(CouplingRefusal),
    /// Current motion that leaves no part of the limits for an added one.
    #[error(
        "{:#06x}: {field}: the motion under way takes {taken}, expected at most {passes} for something to be added to it: \
         command that motion with less {field}, or add to it when it has come to its end",
        self.code()
    )]
    NothingLeft {
        /// Name of the limit.
        field: &'static str,
        /// Part of it used by the motion.
        taken: f64,
        /// Greatest part that it may use.
        passes: f64,
    },
    /// Missing value that this command needs here.
    #[error("{:#06x}: {field}: received none, expected one: the coupling has no constant ratio", self.code())]
    NotGiven {
        /// Name of the value.
        field: &'static str,
    },
    /// Position that does not exist within the axis's modulo period.
    #[error(transparent)]
    SyncPosition(WrongSyncPosition),
    /// No flying saw yet, and so no characteristic values.
    #[error("{:#06x}: the slave has had no flying saw, expected one before", self.code())]
    NoCharacteristics,
    /// Cut by a slave that is being led to its master or away from it, or that its limits have left
    /// behind: the cut would be at a wrong position.
    #[error(
        "{:#06x}: cut: the slave is {} its master, {} u from where its coupling has it; expected it in sync, at most \
         {window} u from there",
        self.code(), PhaseText(*.phase), Rounded(distance.abs())
    )]
    CutNotInSync {
        /// Phase of the coupling.
        phase: CouplingPhase,
        /// Distance of the set position from that of the coupling, u.
        distance: f64,
        /// Greatest distance allowed in sync, u.
        window: f64,
    },
    /// Coupling from the start with a drive at another position, or one that does not follow at once.
    #[error(
        "{:#06x}: the drive has the axis at {} u, expected it to follow at {} u at once, where the \
         coupling from the start has it: give it power first, and couple it then",
        self.code(), Rounded(*received), Rounded(*expected)
    )]
    DriveElsewhere {
        /// Position of the axis by its drive, u.
        received: f64,
        /// Position of the coupling, u.
        expected: f64,
    },
}

impl Refusal {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::Status {
                status, transition, ..
            } => match (status, transition) {
                // By the state first: without power no arrow matters.
                (AxisStatus::Disabled, _) => 0x422a,
                (AxisStatus::Stopping, _) => 0x42ef,
                (AxisStatus::ErrorStop, _) => 0x4b09,
                (_, Transition::Uncouple | Transition::Phase) => 0x424d,
                _ => 0x4b05,
            },
            Self::WeakerStop { .. } => 0x42ef,
            Self::NothingLeft { .. } => 0x42dd,
            Self::NotAtRest { .. } => 0x425a,
            Self::Guard(refusal) => refusal.code(),
            Self::NoMaster | Self::DriveElsewhere { .. } | Self::CutNotInSync { .. } => 0x4b09,
            Self::FollowsItself { .. } => CIRCLE_CODE,
            Self::Coupling(refusal) => refusal.code(),
            Self::NotGiven { .. } => 0x4b06,
            Self::SyncPosition(wrong) => wrong.code(),
            Self::NoCharacteristics => 0x4216,
        }
    }
}

impl From<GuardRefusal> for Refusal {
    fn from(refusal: GuardRefusal) -> Self {
        Self::Guard(refusal)
    }
}

impl From<WrongSyncPosition> for Refusal {
    fn from(wrong: WrongSyncPosition) -> Self {
        Self::SyncPosition(wrong)
    }
}

impl From<CouplingRefusal> for Refusal {
    fn from(refusal: CouplingRefusal) -> Self {
        Self::Coupling(refusal)
    }
}

impl From<NotPlanned<CouplingRefusal>> for Refusal {
    fn from(why: NotPlanned<CouplingRefusal>) -> Self {
        match why {
            NotPlanned::NoMaster => Self::NoMaster,
            NotPlanned::NotAtRest { velocity } => Self::NotAtRest { velocity },
            NotPlanned::Guard(refusal) => Self::Guard(refusal),
            NotPlanned::Own(refusal) => Self::Coupling(refusal),
        }
    }
}

/// The states in which an arrow of the state diagram begins, behind "expected".
struct Before<'a>(&'a Transition);

impl fmt::Display for Before<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        AxisStatus::ALL
            .into_iter()
            // From the diagram itself, so that the text cannot contradict it.
            .filter(|from| from.after(*self.0).is_some())
            .enumerate()
            .try_for_each(|(k, from)| write!(f, "{} {from}", if k == 0 { "" } else { " or" }))
    }
}

/// Relation of a slave to its master, in words.
struct PhaseText(CouplingPhase);

impl fmt::Display for PhaseText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            CouplingPhase::Behind => "behind",
            CouplingPhase::Releasing => "being released from",
            CouplingPhase::Synchronizing | CouplingPhase::SynchronizingAfterSyncPosition => {
                "on its way to"
            }
            CouplingPhase::Waiting | CouplingPhase::Released => "waiting for",
            CouplingPhase::InSync | CouplingPhase::InSyncBeforeSyncPosition => "in sync with",
        })
    }
}
