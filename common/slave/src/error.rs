//! Errors that bring a slave axis to an error stop.

use coaxle_axis::drive::DriveFault;
use coaxle_axis::guard::GuardFault;

use super::circle::CIRCLE_CODE;
use super::couplings::CouplingFault;

/// Error of a slave axis in error stop.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SlaveError {
    /// Drive tripped, or not ready.
    #[error("{code:#06x}: {0}", code = self.code())]
    Drive(DriveFault),
    /// Master lost or in error while the axis was coupled.
    #[error("{:#06x}: the master of the coupled axis was lost or in error", self.code())]
    MasterLost,
    /// Coupled axis that follows itself across nodes.
    #[error("{:#06x}: the coupled axis follows itself over other nodes: the circle was closed while it was coupled", self.code())]
    FollowsItself,
    /// Set values beyond the limits of the axis.
    #[error(transparent)]
    Guard(GuardFault),
    /// Failed coupling.
    #[error("{0}")]
    Coupling(CouplingFault),
}

impl SlaveError {
    /// Errors whose stop [`OnMasterLoss`](crate::OnMasterLoss) decides.
    pub const LOSSES_OF_MASTER: [Self; 2] = [Self::MasterLost, Self::FollowsItself];

    /// True for an error whose stop [`OnMasterLoss`](crate::OnMasterLoss) decides.
    #[must_use]
    pub fn is_loss_of_master(&self) -> bool {
        Self::LOSSES_OF_MASTER.contains(self)
    }

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
