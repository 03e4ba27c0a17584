//! What brings a slave axis to an error stop.

use core::fmt;

use coaxle_axis::guard::GuardFault;

use super::couplings::CouplingFault;

/// Why a slave axis is in error stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlaveError {
    /// The drive tripped: its following error was too large for too long.
    FollowingError {
        /// The following error when it tripped, u.
        following_error: f64,
    },
    /// The axis was coupled and its master was lost or in error.
    MasterLost,
    /// The set values would have left the limits of the axis.
    Guard(GuardFault),
    /// The coupling broke off.
    Coupling(CouplingFault),
}

impl SlaveError {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::FollowingError { .. } => 0x4550,
            Self::MasterLost => 0x42a0,
            Self::Guard(fault) => fault.code(),
            Self::Coupling(fault) => fault.code(),
        }
    }
}

impl From<GuardFault> for SlaveError {
    fn from(fault: GuardFault) -> Self {
        Self::Guard(fault)
    }
}

impl From<CouplingFault> for SlaveError {
    fn from(fault: CouplingFault) -> Self {
        Self::Coupling(fault)
    }
}

impl fmt::Display for SlaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Guard(fault) => return fault.fmt(f),
            Self::Coupling(fault) => return fault.fmt(f),
            _ => write!(f, "{:#06x}: ", self.code())?,
        }
        match self {
            Self::Guard(_) | Self::Coupling(_) => Ok(()),
            Self::FollowingError { following_error } => write!(
                f,
                "following error of {following_error} for too long, the drive tripped"
            ),
            Self::MasterLost => f.write_str("the master of the coupled axis was lost or in error"),
        }
    }
}

impl core::error::Error for SlaveError {}
