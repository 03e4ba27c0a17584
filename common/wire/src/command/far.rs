//! Orders to a node about one of the nodes that it follows: the inputs of `FB_AxisSync`.

use coaxle_clock::far_clock::DelaySource;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_remote::{AxisSyncChanges, FilterMode};
use coaxle_slave::commands;
use serde::{Deserialize, Serialize};

commands! {
    /// An input of `FB_AxisSync`, for all axes of a far node.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum FarCommand, each () = ();

    /// `bEnable` = TRUE: a disabled far node restarts.
    #[doc(alias = "bEnable")]
    "enable" Enable {},
    /// `bEnable` = FALSE: the axes pass through as they come.
    "disable" Disable {},
    /// `eFilterMode`: how the set values are calculated.
    #[doc(alias = "eFilterMode")]
    "filter-mode" FilterMode(FilterMode),
    /// FALSE and TRUE again at `bEnable`: learnt values are discarded and the latched error is reset.
    "re-initialise" ReInitialise {},
    /// `stAxisSyncParameters`: omitted fields keep their values.
    #[doc(alias = "stAxisSyncParameters")]
    "set-parameters" SetParameters(AxisSyncChanges),
    /// Source of the constant part of the delay, in observer mode.
    "set-delay" SetDelay(DelaySource),
}

/// State of a far node in a response.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct FarView {
    /// True while it is enabled.
    pub enabled: bool,
    /// Mode in force while it is enabled.
    pub mode: FilterMode,
    /// True if its clock was known in the newest cycle.
    pub synced: bool,
    /// Source of the constant part of the delay, in observer mode.
    pub delay: DelaySource,
}

/// Reason why a far node refuses a command.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FarRefusal {
    /// A parameter with a value out of its range.
    #[error("{:#06x}: {}: received {}, expected {}", self.code(), self.field(), wrong.received, wrong.expected)]
    Parameter {
        /// Part of the parameters.
        part: ParameterPart,
        /// Parameter and its permitted range.
        wrong: WrongParameter,
    },
    /// A change of parameters without any parameter.
    #[error("{:#06x}: {}: received no parameter, expected at least one to change", self.code(), self.field())]
    NothingToChange,
    /// A delay out of its range.
    #[error("{:#06x}: {}: received {received}, expected {}", self.code(), self.field(), Self::DELAYS)]
    Delay {
        /// Value received, µs.
        received: f64,
    },
    /// The far node is disabled: enabling it restarts it.
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
    /// Range of a fixed delay, in words.
    pub const DELAYS: &str = "a number from -1000000 to 1000000";

    /// Returns the error code of TwinCAT's remote synchronisation: a parameter is wrong. The manual knows
    /// no other refusal.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x4b56
    }

    /// Returns the field that is refused.
    #[must_use]
    pub fn field(&self) -> String {
        match self {
            Self::Parameter { part, wrong } => format!("{}.{}", part.name(), wrong.parameter),
            Self::NothingToChange => "set-parameters".to_owned(),
            Self::Delay { .. } => "fixed-us".to_owned(),
            Self::Disabled => "enabled".to_owned(),
        }
    }

    /// Returns the value received for the field, if it is a number.
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
