//! Why a command is refused.

use core::fmt;

use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::{AxisStatus, NotPlanned, Transition};

use super::couplings::CouplingRefusal;

/// Why a command is refused. Nothing has changed by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The axis takes no such command in its state.
    Status {
        /// The command, by its PLC name.
        command: &'static str,
        /// Its arrow in the state diagram.
        transition: Transition,
        /// The state of the axis.
        status: AxisStatus,
    },
    /// The axis has to be at rest first.
    NotAtRest {
        /// Its set velocity, u/s.
        velocity: f64,
    },
    /// The axis cannot, or may not, do that much.
    Guard(GuardRefusal),
    /// There is no master to couple to, or it is in error.
    NoMaster,
    /// The coupling, or the change to it, is not possible.
    Coupling(CouplingRefusal),
    /// A value that this command needs here.
    NotGiven {
        /// Which one.
        field: &'static str,
    },
    /// The slave has had no flying saw yet, and so no characteristic values.
    NoCharacteristics,
    /// The slave has no limits: it follows its gear, and nothing else.
    NoLimits {
        /// The command, by its PLC name.
        command: &'static str,
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
                (AxisStatus::Disabled, _) => 0x422a,
                (AxisStatus::Stopping, _) => 0x42ef,
                (AxisStatus::ErrorStop, _) => 0x4b09,
                (_, Transition::Uncouple | Transition::Phase) => 0x424d,
                _ => 0x4b05,
            },
            Self::NotAtRest { .. } => 0x425a,
            Self::Guard(refusal) => refusal.code(),
            Self::NoMaster => 0x4b09,
            Self::Coupling(refusal) => refusal.code(),
            Self::NotGiven { .. } => 0x4b06,
            Self::NoCharacteristics => 0x4216,
            Self::NoLimits { .. } => 0x4b05,
        }
    }
}

impl From<GuardRefusal> for Refusal {
    fn from(refusal: GuardRefusal) -> Self {
        Self::Guard(refusal)
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

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Guard(refusal) => return refusal.fmt(f),
            Self::Coupling(refusal) => return refusal.fmt(f),
            _ => write!(f, "{:#06x}: ", self.code())?,
        }
        match self {
            Self::Guard(_) | Self::Coupling(_) => Ok(()),
            Self::NotGiven { field } => write!(
                f,
                "{field}: received none, expected one: the coupling has no constant ratio"
            ),
            Self::NoCharacteristics => {
                f.write_str("the slave has had no flying saw, expected one before")
            }
            Self::NoLimits { command } => write!(
                f,
                "{command}: the slave has no limits, expected some: it follows its gear only"
            ),
            Self::Status {
                command,
                transition,
                status,
            } => {
                write!(f, "{command}: the axis is in {status}, expected")?;
                AxisStatus::ALL
                    .into_iter()
                    .filter(|from| from.after(*transition).is_some())
                    .enumerate()
                    .try_for_each(|(k, from)| {
                        write!(f, "{} {from}", if k == 0 { "" } else { " or" })
                    })
            }
            Self::NotAtRest { velocity } => {
                write!(f, "velocity of the axis: received {velocity}, expected 0")
            }
            Self::NoMaster => f.write_str("no master to couple to"),
        }
    }
}

impl core::error::Error for Refusal {}
