//! Parameters and modes of a synchronised far axis.

use core::fmt;

use coaxle_clock::Span;
use coaxle_clock::time_sync::{CheckedTimeSync, TimeSyncParameters, WrongParameter};

use super::extrapolate::{ExtrapolateMode, ExtrapolateParameters, FallBackMode};

/// `ST_AxisSyncParameters` with the manual's defaults, TS5066 chapter 3.4.
#[doc(alias = "ST_AxisSyncParameters")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct AxisSyncParameters {
    /// Mode of automatic mode until the drift is known.
    #[doc(alias = "eStartUpMode")]
    pub start_up_mode: StartUpMode,
    /// Mode if synchronisation is lost, or the position deviates too far.
    #[doc(alias = "eFallBackMode")]
    pub fall_back_mode: FallBackMode,
    /// Parameters of the extrapolation.
    #[doc(alias = "stExtrapolateParameters")]
    #[doc(alias = "stAxisExtrapolateParameters")]
    pub extrapolate: ExtrapolateParameters,
    /// Parameters of the time sync.
    #[doc(alias = "stTimeSyncParameters")]
    pub time_sync: TimeSyncParameters,
}

/// Valid parameters for a pair of cycle times: a running block can take them over.
#[derive(Clone, Copy, Debug)]
pub struct CheckedParameters {
    pub(super) whole: AxisSyncParameters,
    pub(super) time_sync: CheckedTimeSync,
}

impl CheckedParameters {
    /// Parameters of the extrapolation.
    #[must_use]
    pub const fn extrapolate(&self) -> &ExtrapolateParameters {
        &self.whole.extrapolate
    }
}

impl AxisSyncParameters {
    /// Checks every parameter. `task_cycle_time` is the receiver's nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn checked(self, task_cycle_time: Span) -> Result<CheckedParameters, WrongParameter> {
        self.extrapolate.check()?;
        Ok(CheckedParameters {
            whole: self,
            // Limits in cycles depend on the ratio of both cycle times, which only this check knows.
            time_sync: self.time_sync.checked(task_cycle_time)?,
        })
    }
}

/// `E_Sync_StartUpMode`, TS5066 chapter 3.9.
#[doc(alias = "E_Sync_StartUpMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum StartUpMode {
    /// As received.
    Bypass = 1,
    /// Through the PT1 filter.
    Pt1 = 2,
    /// Beats are hidden when they happen.
    #[default]
    Time = 4,
}

impl From<StartUpMode> for ExtrapolateMode {
    fn from(mode: StartUpMode) -> Self {
        match mode {
            StartUpMode::Bypass => Self::Bypass,
            StartUpMode::Pt1 => Self::Pt1,
            StartUpMode::Time => Self::Time,
        }
    }
}

/// `E_Sync_FilterMode`: method selected for calculating the set values. TS5066 chapter 3.7.
#[doc(alias = "E_Sync_FilterMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum FilterMode {
    /// Start-up mode, then sync mode; the fallback when sync is lost.
    #[default]
    #[cfg_attr(feature = "serde", serde(rename = "sync"))]
    Auto = 0,
    /// As received.
    Bypass = 1,
    /// Through the PT1 filter.
    Pt1 = 2,
    /// Beats are hidden when they happen.
    Time = 4,
    /// By a phase observer's clock; the start-up mode, by default time mode, bridges until the
    /// clock is sure. Not in the manual.
    Observer = 5,
}

impl FilterMode {
    /// Name in config, commands, status and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "sync",
            Self::Bypass => "bypass",
            Self::Pt1 => "pt1",
            Self::Time => "time",
            Self::Observer => "observer",
        }
    }

    /// True if the mode ever synchronises: sync mode does not if time mode is forced.
    #[must_use]
    pub const fn synchronises(self, sync: &AxisSyncParameters) -> bool {
        match self {
            Self::Observer => true,
            Self::Auto => !sync.time_sync.force_time_mode,
            Self::Bypass | Self::Pt1 | Self::Time => false,
        }
    }
}

impl fmt::Display for FilterMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// `E_Sync_FilterState`: method that calculated the set values. TS5066 chapter 3.8.
#[doc(alias = "E_Sync_FilterState")]
pub type FilterState = ExtrapolateMode;
