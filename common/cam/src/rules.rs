//! Which activation mode goes with which operation.

use super::modes::ActivationMode;

/// Most points of a plate that can be replaced while a slave is on it: they are copied in the cycle.
pub const MOST_POINTS_REPLACED_IN_USE: usize = 4096;

/// What a change does, as TF5050 chapter 8.3 divides them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// A plate becomes active where none was: first coupling, and adding to a multi cam.
    Couple,
    /// A plate takes the place of another, or is removed from a multi cam.
    Switch,
    /// A plate is scaled or offset.
    Scale,
    /// Points of a motion function in use change.
    OnlineChange,
}

impl Operation {
    /// Whether TF5050 chapter 8.3 has the mode for this operation.
    ///
    /// `NextCycleOnce` is not implemented in the original; here it goes wherever `NextCycle` does.
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
            Mode::Off => matches!(self, Self::Scale | Self::OnlineChange),
            Mode::DeleteQueuedData => matches!(self, Self::Switch | Self::OnlineChange),
        }
    }
}
