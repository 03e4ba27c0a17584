//! Parameters and modes of a synchronised far axis.

use core::fmt;

use coaxle_clock::Span;
use coaxle_clock::time_sync::{AGE_LIMIT, CheckedTimeSync, TimeSyncParameters, WrongParameter};

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

    /// Returns the own cycles without new data after which they are too old, before it is raised for different cycle times; none if they are not monitored.
    /// `task_cycle_time` is the receiver's.
    #[must_use]
    pub fn age_limit(&self, mode: FilterMode, task_cycle_time: Span) -> Option<u32> {
        let cycles = match (self.time_sync.age_of_data_limit, mode) {
            (Some(cycles), _) => cycles,
            (None, FilterMode::Observer) => self.bridged(task_cycle_time),
            (None, _) => AGE_LIMIT,
        };
        (cycles > 0).then_some(cycles.into())
    }

    /// Own cycles without new data that mode `observer` bridges by default.
    pub(super) fn bridged(&self, task_cycle_time: Span) -> u16 {
        let own = task_cycle_time.as_nanos().max(1);
        let slower = own.max(self.data_cycle_time(task_cycle_time).as_nanos());
        let bridged = BRIDGED.as_nanos().max(BRIDGED_CYCLES * slower);
        u16::try_from(bridged / own).unwrap_or(u16::MAX)
    }

    /// Cycle time of the sender: that of the receiver, if it is not configured.
    pub(super) fn data_cycle_time(&self, task_cycle_time: Span) -> Span {
        match self.time_sync.data_cycle_time.to_span() {
            Span::ZERO => task_cycle_time,
            data => data,
        }
    }
}

/// Silence that mode `observer` bridges by default: threads of a PC without real-time priority stand still for some tens of milliseconds now and then.
/// A master that begins to accelerate by 5 m/s² is 25 mm elsewhere then, and its slaves keep their limits on the way back.
const BRIDGED: Span = Span::from_millis(100);
/// Least number of cycles of the slower node in that: the default of the manual.
const BRIDGED_CYCLES: i64 = AGE_LIMIT as i64;

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

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::Seconds;

    #[test]
    fn an_observer_bridges_what_an_ordinary_pc_does() {
        let parameters = |data: f64, limit| AxisSyncParameters {
            time_sync: TimeSyncParameters {
                data_cycle_time: Seconds(data),
                age_of_data_limit: limit,
                ..TimeSyncParameters::default()
            },
            ..AxisSyncParameters::default()
        };
        use FilterMode::{Auto, Observer};
        for (own_us, data, limit, mode, expected) in [
            (1_000, 0.0, None, Auto, Some(7)),
            (1_000, 0.0, None, Observer, Some(100)),
            (1_000, 0.001, None, Observer, Some(100)),
            (250, 0.001, None, Observer, Some(400)),
            // Seven cycles of the slower node.
            (1_000, 0.05, None, Observer, Some(350)),
            (50_000, 0.001, None, Observer, Some(7)),
            // A configured one counts in each mode.
            (1_000, 0.05, Some(20), Observer, Some(20)),
            (1_000, 0.05, Some(20), Auto, Some(20)),
            (1_000, 0.0, Some(0), Observer, None),
        ] {
            let own = Span::from_micros(own_us);
            let limit = parameters(data, limit).age_limit(mode, own);
            assert_eq!(limit, expected, "{own_us} µs, {data} s, {mode:?}");
        }
    }
}
