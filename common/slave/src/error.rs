//! What brings a slave axis to an error stop.

use coaxle_axis::guard::GuardFault;

use super::couplings::CouplingFault;

/// Why a slave axis is in error stop.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SlaveError {
    /// The drive tripped: its following error was too large for too long.
    #[error("{:#06x}: following error of {following_error} for too long, the drive tripped", self.code())]
    FollowingError {
        /// The following error when it tripped, u.
        following_error: f64,
    },
    /// The axis was coupled and its master was lost or in error.
    #[error("{:#06x}: the master of the coupled axis was lost or in error", self.code())]
    MasterLost,
    /// The set values would have left the limits of the axis.
    #[error(transparent)]
    Guard(GuardFault),
    /// The coupling broke off.
    #[error("{0}")]
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
