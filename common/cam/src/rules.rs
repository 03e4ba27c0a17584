//! Activation modes allowed for each operation.

use super::modes::ActivationMode;

/// Greatest number of points of a plate that can be replaced while a slave is on it: they are copied in
/// the cycle.
pub const MOST_POINTS_REPLACED_IN_USE: usize = 4096;

/// Operation of a change, as TF5050 chapter 8.3 divides them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// Activation of a plate in an empty place: first coupling, and adding to a multi cam.
    Couple,
    /// Exchange of a plate for another, or removal from a multi cam.
    Switch,
    /// Scaling or offset of a plate.
    Scale,
    /// Change of points of a motion function in use.
    OnlineChange,
}

impl Operation {
    /// True if TF5050 chapter 8.3 has the mode for this operation.
    ///
    /// `NextCycleOnce` is not implemented in the original; here it is allowed wherever `NextCycle` is.
    #[must_use]
    pub const fn allows(self, mode: ActivationMode) -> bool {
        use ActivationMode as Mode;
        match mode {
            Mode::Instantaneous
            | Mode::AtMasterCamPos
            | Mode::AtMasterAxisPos
            | Mode::NextCycle
            | Mode::NextCycleOnce => true,
            Mode::AtMasterAxisPosPositiveDirection | Mode::AtMasterAxisPosNegativeDirection => {
                matches!(self, Self::Couple | Self::Switch)
            }
            Mode::AsSoonAsPossible => matches!(self, Self::OnlineChange),
            // Off keeps what there is: a coupling that does so would never begin.
            Mode::Off => matches!(self, Self::Scale | Self::OnlineChange),
            Mode::DeleteQueuedData => matches!(self, Self::Switch | Self::OnlineChange),
        }
    }
}
