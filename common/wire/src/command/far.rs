//! Orders to a node about one of the nodes that it follows: the inputs of `FB_AxisSync`.

use coaxle_clock::time_sync::WrongParameter;
use coaxle_remote::{AxisSyncChanges, FilterMode};
use serde::{Deserialize, Serialize};

use super::name::FarName;

/// What a node is told about a node that it follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarOrder {
    /// Which of the nodes that it follows.
    pub far: FarName,
    /// What it shall do.
    pub command: FarCommand,
    /// Whether it shall only say what would come of it.
    pub dry_run: bool,
}

/// An input of `FB_AxisSync`, for all axes of a far node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FarCommand {
    /// `bEnable` = TRUE: what was disabled starts anew.
    #[doc(alias = "bEnable")]
    Enable {},
    /// `bEnable` = FALSE: the axes pass through as they come.
    Disable {},
    /// `eFilterMode`: how the set values are calculated.
    #[doc(alias = "eFilterMode")]
    FilterMode(FilterMode),
    /// FALSE and TRUE again at `bEnable`: what was learnt is forgotten, no error is latched any more.
    ReInitialise {},
    /// `stAxisSyncParameters`: what is left out stays as it is.
    #[doc(alias = "stAxisSyncParameters")]
    SetParameters(AxisSyncChanges),
    /// Where the constant part of the delay comes from, in observer mode.
    SetDelay(FarDelay),
}

/// Where the constant part of the delay comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum FarDelay {
    /// The far node is asked.
    Measured,
    /// It is this much, µs.
    FixedUs(f64),
    /// Nothing is done about it.
    Off,
}

impl FarCommand {
    /// The names of all on the wire.
    pub const NAMES: [&str; 6] = [
        "enable",
        "disable",
        "filter-mode",
        "re-initialise",
        "set-parameters",
        "set-delay",
    ];

    /// Its name on the wire.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Enable {} => "enable",
            Self::Disable {} => "disable",
            Self::FilterMode(_) => "filter-mode",
            Self::ReInitialise {} => "re-initialise",
            Self::SetParameters(_) => "set-parameters",
            Self::SetDelay(_) => "set-delay",
        }
    }
}

/// A far node as an answer shows it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct FarView {
    /// Whether it is enabled.
    pub enabled: bool,
    /// The mode that is in force while it is.
    pub mode: FilterMode,
    /// Whether its clock was known in the newest cycle.
    pub synced: bool,
    /// Where the constant part of the delay comes from, in observer mode.
    pub delay: FarDelay,
}

/// Why a far node does not do as it is told.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FarRefusal {
    /// A parameter would have a value that it must not have.
    #[error("{:#06x}: {}: received {}, expected {}", self.code(), self.field(), wrong.received, wrong.expected)]
    Parameter {
        /// The part of the parameters that it is in.
        part: ParameterPart,
        /// Which, and what it may be.
        wrong: WrongParameter,
    },
    /// The parameters to change are none.
    #[error("{:#06x}: {}: received no parameter, expected at least one to change", self.code(), self.field())]
    NothingToChange,
    /// The delay has a value that it must not have.
    #[error("{:#06x}: {}: received {received}, expected a number from -1000000 to 1000000", self.code(), self.field())]
    Delay {
        /// That value, µs.
        received: f64,
    },
    /// It is disabled: enabling it starts it anew.
    #[error("{:#06x}: {}: received false, expected true: enable it, which starts it anew", self.code(), self.field())]
    Disabled,
}

/// A part of the parameters of `FB_AxisSync`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterPart {
    /// `stTimeSyncParameters`.
    TimeSync,
    /// `stAxisExtrapolateParameters`.
    Extrapolate,
}

impl FarRefusal {
    /// An error code of TwinCAT's remote synchronisation: a parameter is wrong. The manual knows no
    /// other refusal.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x4b56
    }

    /// What it is about.
    #[must_use]
    pub fn field(&self) -> String {
        match self {
            Self::Parameter { part, wrong } => format!("{}.{}", part.name(), wrong.parameter),
            Self::NothingToChange => "set-parameters".to_owned(),
            Self::Delay { .. } => "fixed-us".to_owned(),
            Self::Disabled => "enabled".to_owned(),
        }
    }

    /// What that was, where it is a number.
    #[must_use]
    pub const fn received(&self) -> Option<f64> {
        match self {
            Self::Parameter { wrong, .. } => Some(wrong.received),
            Self::Delay { received } => Some(*received),
            Self::NothingToChange | Self::Disabled => None,
        }
    }
}

impl ParameterPart {
    const fn name(self) -> &'static str {
        match self {
            Self::TimeSync => "time-sync",
            Self::Extrapolate => "extrapolate",
        }
    }
}
