//! What brings a slave axis to an error stop.

use coaxle_axis::drive::DriveFault;
use coaxle_axis::guard::GuardFault;

use super::circle::CIRCLE_CODE;
use super::couplings::CouplingFault;

/// Why a slave axis is in error stop.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SlaveError {
    /// The drive tripped, or is not ready.
    #[error("{code:#06x}: {0}", code = self.code())]
    Drive(DriveFault),
    /// The axis was coupled and its master was lost or in error.
    #[error("{:#06x}: the master of the coupled axis was lost or in error", self.code())]
    MasterLost,
    /// The coupled axis follows itself over other nodes.
    #[error("{:#06x}: the coupled axis follows itself over other nodes: the circle was closed while it was coupled", self.code())]
    FollowsItself,
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
            Self::Drive(fault) => fault.code(),
            Self::MasterLost => 0x42a0,
            Self::FollowsItself => CIRCLE_CODE,
            Self::Guard(fault) => fault.code(),
            Self::Coupling(fault) => fault.code(),
        }
    }
}

impl From<DriveFault> for SlaveError {
    fn from(fault: DriveFault) -> Self {
        Self::Drive(fault)
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
