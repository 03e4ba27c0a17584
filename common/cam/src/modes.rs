//! The enumerations of a coupling: activation and placement in the axes.

/// `MC_CamActivationMode`, TF5050 chapter 8.3: moment at which a change takes effect.
///
/// Modes allowed for each operation: [`Operation::allows`](super::Operation::allows).
#[doc(alias = "MC_CamActivationMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum ActivationMode {
    /// In the next cycle.
    #[doc(alias = "MC_CAMACTIVATION_INSTANTANEOUS")]
    #[default]
    Instantaneous = 0,
    /// Pass of the master over a position of the unscaled plate, in x, in either direction.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERCAMPOS")]
    AtMasterCamPos = 1,
    /// Pass of the master axis over a position in either direction.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERAXISPOS")]
    AtMasterAxisPos = 2,
    /// Transition of a cyclic plate to another cycle; for an exchange also the exit of the master from
    /// the range of a linear one.
    #[doc(alias = "MC_CAMACTIVATION_NEXTCYCLE")]
    NextCycle = 3,
    /// As `NextCycle`, with a return to the previous state after one cycle. The original does not have
    /// it.
    #[doc(alias = "MC_CAMACTIVATION_NEXTCYCLEONCE")]
    NextCycleOnce = 4,
    /// As soon as the slave is not in a segment that changes.
    #[doc(alias = "MC_CAMACTIVATION_ASSOONASPOSSIBLE")]
    AsSoonAsPossible = 5,
    /// Not at all.
    #[doc(alias = "MC_CAMACTIVATION_OFF")]
    Off = 6,
    /// Discards the queued change.
    #[doc(alias = "MC_CAMACTIVATION_DELETEQUEUEDDATA")]
    DeleteQueuedData = 7,
    /// Pass of the master axis over a position towards larger ones.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERAXISPOS_POSITVEDIRECTION")]
    AtMasterAxisPosPositiveDirection = 8,
    /// Pass of the master axis over a position towards smaller ones.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERAXISPOS_NEGATIVEDIRECTION")]
    AtMasterAxisPosNegativeDirection = 9,
}

impl ActivationMode {
    /// Modes by their codes.
    pub const ALL: [Self; 10] = [
        Self::Instantaneous,
        Self::AtMasterCamPos,
        Self::AtMasterAxisPos,
        Self::NextCycle,
        Self::NextCycleOnce,
        Self::AsSoonAsPossible,
        Self::Off,
        Self::DeleteQueuedData,
        Self::AtMasterAxisPosPositiveDirection,
        Self::AtMasterAxisPosNegativeDirection,
    ];

    /// Returns the PLC's number of the mode.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Returns the mode with that number, if there is one.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.code() == code)
    }

    /// True if it waits for the plate's transition to another cycle.
    pub(super) const fn is_next_cycle(self) -> bool {
        matches!(self, Self::NextCycle | Self::NextCycleOnce)
    }

    /// True if it depends on the position of the master on the plate.
    pub(super) const fn refers_to_plate(self) -> bool {
        // A position of the master's axis is the same whatever plate it moves.
        matches!(self, Self::AtMasterCamPos) || self.is_next_cycle()
    }
}

/// `MC_CamScalingMode`, TF5050 chapter 8.4: source of scaling and offset.
#[doc(alias = "MC_CamScalingMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum ScalingMode {
    /// Scaling and offset as given.
    #[doc(alias = "MC_CAMSCALING_USERDEFINED")]
    #[default]
    UserDefined = 0,
    /// The scaling as given; the offset such that nothing jumps. Of the master: the relative position
    /// within the cycle is kept. Of the slave: its position is kept.
    #[doc(alias = "MC_CAMSCALING_AUTOOFFSET")]
    AutoOffset = 1,
    /// Scaling and offset are kept.
    #[doc(alias = "MC_CAMSCALING_OFF")]
    Off = 2,
}

/// `MC_StartMode`, TF5050 chapter 8.15: whether a plate's positions are those of the axes, or relative to
/// the axes when it becomes active.
#[doc(alias = "MC_StartMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum StartMode {
    /// Absolute for both axes.
    #[doc(alias = "MC_STARTMODE_ABSOLUTE")]
    #[default]
    Absolute = 1,
    /// Relative for both axes.
    #[doc(alias = "MC_STARTMODE_RELATIVE")]
    Relative = 2,
    /// Absolute for the master, relative for the slave.
    #[doc(alias = "MC_STARTMODE_MASTERABS_SLAVEREL")]
    MasterAbsoluteSlaveRelative = 3,
    /// Relative for the master, absolute for the slave.
    #[doc(alias = "MC_STARTMODE_MASTERREL_SLAVEABS")]
    MasterRelativeSlaveAbsolute = 4,
}

impl StartMode {
    /// True if master positions are relative to the master's position.
    #[must_use]
    pub const fn master_relative(self) -> bool {
        matches!(self, Self::Relative | Self::MasterRelativeSlaveAbsolute)
    }

    /// True if slave positions are relative to the slave's position.
    #[must_use]
    pub const fn slave_relative(self) -> bool {
        matches!(self, Self::Relative | Self::MasterAbsoluteSlaveRelative)
    }
}

/// `MC_CamOperationMode`, TF5050 chapter 8.18: operation of `MC_CamIn_V2` with its plate.
#[doc(alias = "MC_CamOperationMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum OperationMode {
    /// Equal to `Additive`.
    #[doc(alias = "CAMOPERATIONMODE_DEFAULT")]
    #[default]
    Default = 0,
    /// Superposes it on the coupled plates.
    #[doc(alias = "CAMOPERATIONMODE_ADDITIVE")]
    Additive = 1,
    /// Puts it in place of a coupled plate.
    #[doc(alias = "CAMOPERATIONMODE_EXCHANGE")]
    Exchange = 2,
    /// Removes it.
    #[doc(alias = "CAMOPERATIONMODE_REMOVE")]
    Remove = 3,
}

/// Handling of a slave that does not have the position or the velocity of a change. Not in the manual:
/// the original always jumps.
///
/// Except for `Allow`, the slave must be able to follow its new course at the velocity of its master;
/// otherwise the change is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub enum JumpHandling {
    /// Refuses a jump of position or velocity beyond what the slave's acceleration and jerk permit in one
    /// cycle, in addition to its present motion.
    #[default]
    Refuse,
    /// Jumps, as the original does. If the slave cannot follow, its axis goes to error stop.
    Allow,
    /// Leads the slave to its new course over a distance of the master, without a step in position,
    /// velocity or acceleration.
    #[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
    RampIn {
        /// The distance of the master axis, in its units, above 0.
        master_length: f64,
    },
}
