//! The enumerations of a coupling: when a change takes effect, and how it lies in the axes.

/// `MC_CamActivationMode`, TF5050 chapter 8.3: when a change takes effect.
///
/// Which mode goes with which operation: [`Operation::allows`](super::Operation::allows).
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
    /// When the master passes a position of the unscaled plate, in x, in either direction.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERCAMPOS")]
    AtMasterCamPos = 1,
    /// When the master axis passes a position in either direction.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERAXISPOS")]
    AtMasterAxisPos = 2,
    /// When a cyclic plate passes to another cycle; switching also when the master leaves the range
    /// of a linear one.
    #[doc(alias = "MC_CAMACTIVATION_NEXTCYCLE")]
    NextCycle = 3,
    /// As `NextCycle`, and everything returns to what it was after one cycle. The original does not
    /// have it.
    #[doc(alias = "MC_CAMACTIVATION_NEXTCYCLEONCE")]
    NextCycleOnce = 4,
    /// As soon as the slave is not in a segment that changes.
    #[doc(alias = "MC_CAMACTIVATION_ASSOONASPOSSIBLE")]
    AsSoonAsPossible = 5,
    /// Not at all.
    #[doc(alias = "MC_CAMACTIVATION_OFF")]
    Off = 6,
    /// Discards what is queued.
    #[doc(alias = "MC_CAMACTIVATION_DELETEQUEUEDDATA")]
    DeleteQueuedData = 7,
    /// When the master axis passes a position towards larger ones.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERAXISPOS_POSITVEDIRECTION")]
    AtMasterAxisPosPositiveDirection = 8,
    /// When the master axis passes a position towards smaller ones.
    #[doc(alias = "MC_CAMACTIVATION_ATMASTERAXISPOS_NEGATIVEDIRECTION")]
    AtMasterAxisPosNegativeDirection = 9,
}

impl ActivationMode {
    /// All modes, by their codes.
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

    /// The number the PLC has for it.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The mode of that number, if there is one.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.code() == code)
    }

    /// Whether it waits for the plate to pass to another cycle.
    pub(super) const fn is_next_cycle(self) -> bool {
        matches!(self, Self::NextCycle | Self::NextCycleOnce)
    }

    /// Whether it depends on where the master is on the plate.
    pub(super) const fn refers_to_plate(self) -> bool {
        matches!(self, Self::AtMasterCamPos) || self.is_next_cycle()
    }
}

/// `MC_CamScalingMode`, TF5050 chapter 8.4: where scaling and offset come from.
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
    /// The scaling as given; the offset so that nothing jumps. Of the master: the relative position
    /// within the cycle stays. Of the slave: its position stays.
    #[doc(alias = "MC_CAMSCALING_AUTOOFFSET")]
    AutoOffset = 1,
    /// Scaling and offset stay as they are.
    #[doc(alias = "MC_CAMSCALING_OFF")]
    Off = 2,
}

/// `MC_StartMode`, TF5050 chapter 8.15: whether a plate's positions are those of the axes, or count
/// from where the axes are when it becomes active.
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
    /// Whether master positions count from where the master is.
    #[must_use]
    pub const fn master_relative(self) -> bool {
        matches!(self, Self::Relative | Self::MasterRelativeSlaveAbsolute)
    }

    /// Whether slave positions count from where the slave is.
    #[must_use]
    pub const fn slave_relative(self) -> bool {
        matches!(self, Self::Relative | Self::MasterAbsoluteSlaveRelative)
    }
}

/// `MC_CamOperationMode`, TF5050 chapter 8.18: what `MC_CamIn_V2` does with its plate.
#[doc(alias = "MC_CamOperationMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum OperationMode {
    /// As `Additive`.
    #[doc(alias = "CAMOPERATIONMODE_DEFAULT")]
    #[default]
    Default = 0,
    /// Superposes it on those that are coupled.
    #[doc(alias = "CAMOPERATIONMODE_ADDITIVE")]
    Additive = 1,
    /// Puts it in the place of one that is coupled.
    #[doc(alias = "CAMOPERATIONMODE_EXCHANGE")]
    Exchange = 2,
    /// Takes it out.
    #[doc(alias = "CAMOPERATIONMODE_REMOVE")]
    Remove = 3,
}

/// What to do if the slave is not where a change would have it, or not as fast. Not in the manual: the
/// original always jumps.
///
/// Unless it may jump, the slave must be able to follow its new course at the velocity that its
/// master has; if not, the change is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub enum JumpHandling {
    /// Refuses a jump of position or velocity beyond what acceleration and jerk of the slave can do in
    /// one cycle, besides its motion as it is.
    #[default]
    Refuse,
    /// Jumps, as the original does. What the slave cannot follow then is an error stop of its axis.
    Allow,
    /// Leads the slave to its new course over a distance of the master, without a step in position,
    /// velocity or acceleration.
    #[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
    RampIn {
        /// The distance of the master axis, in its units, above 0.
        master_length: f64,
    },
}
