//! `ST_TimeSyncParameters`, checked once.

use crate::instant::{Seconds, Span};

use super::SyncError;
use super::beats::MOST_PERIODS;
use super::line::Slopes;

/// `ST_TimeSyncParameters` with the manual's defaults, TS5066 chapter 3.10.
#[doc(alias = "ST_TimeSyncParameters")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct TimeSyncParameters {
    /// The sender's cycle time, s; 0: the same as the receiver's. One must be a whole multiple of
    /// the other.
    #[doc(alias = "fDataCycleTime")]
    #[cfg_attr(feature = "serde", serde(rename = "data-cycle-time-s"))]
    pub data_cycle_time: Seconds,
    /// The correction time, in receiver cycles, below which sync mode may begin. Above 0.
    #[doc(alias = "fThresholdForSync")]
    pub threshold_for_sync: f64,
    /// Largest difference between corrected and received index; 0: not watched. In a silence it grows with the age of
    /// the data. Raised to `task cycle / data cycle + 2` where the sender is the faster one.
    #[doc(alias = "fMaxCycleIndexDifference")]
    pub max_cycle_index_difference: f64,
    /// Most receiver cycles in a row without new data, at least 1; 0: not watched. 7 by default, in mode `observer` as many as 100 ms take, and 7 of
    /// the sender's cycles. Raised to the ratio of the cycle times + 2 where they differ.
    #[doc(alias = "iAgeOfDataLimit")]
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub age_of_data_limit: Option<u16>,
    /// The drift is the mean over this many periods between beats, 1 to 64.
    #[doc(alias = "iNoOfPeriodsForMeanDrift")]
    pub no_of_periods_for_mean_drift: u16,
    /// Added to the correction time, s. Positive: further into the future.
    #[doc(alias = "fDelayTimeOffset")]
    #[cfg_attr(feature = "serde", serde(rename = "delay-time-offset-s"))]
    pub delay_time_offset: Seconds,
    /// The part of a beat's correction that is made in the first section after it, 0 to 1.
    #[doc(alias = "fSlope1Numerator")]
    pub slope1_numerator: f64,
    /// The length of that section as a part of the time between beats, above 0, below 1.
    #[doc(alias = "fSlope1Denominator")]
    pub slope1_denominator: f64,
    /// Cycles for which the offset must stay constant to make a plateau, at least 1.
    #[doc(alias = "iEndOfTransitionLimit")]
    pub end_of_transition_limit: u16,
    /// Cycles over which old and new ramp are blended after a beat.
    #[doc(alias = "iNewDriftBendingCycles")]
    pub new_drift_bending_cycles: u16,
    /// Cycles over which time mode takes a beat's difference away. The manual's structure and its
    /// text name it differently.
    #[doc(alias = "iTimeModeBlendingCycles")]
    #[doc(alias = "iExtendedStartUpBlendingCycles")]
    pub time_mode_blending_cycles: u16,
    /// Stay in time mode.
    #[doc(alias = "bForceTimeMode")]
    pub force_time_mode: bool,
    /// Start up again by itself, one cycle after a fault.
    #[doc(alias = "bAutomaticReInit")]
    pub automatic_re_init: bool,
    /// Reserved; kept for completeness.
    #[doc(alias = "nSysCmd")]
    pub sys_cmd: u32,
}

/// The manual's default of `iAgeOfDataLimit`.
pub const AGE_LIMIT: u16 = 7;

impl Default for TimeSyncParameters {
    fn default() -> Self {
        Self {
            data_cycle_time: Seconds::ZERO,
            threshold_for_sync: 0.05,
            max_cycle_index_difference: 7.0,
            age_of_data_limit: None,
            no_of_periods_for_mean_drift: 1,
            delay_time_offset: Seconds::ZERO,
            slope1_numerator: 0.95,
            slope1_denominator: 0.5,
            end_of_transition_limit: 90,
            new_drift_bending_cycles: 90,
            time_mode_blending_cycles: 90,
            force_time_mode: false,
            automatic_re_init: false,
            sys_cmd: 1,
        }
    }
}

/// Parameters that are good, for a pair of cycle times.
#[derive(Clone, Copy, Debug)]
pub struct CheckedTimeSync {
    /// Parameters with the limits raised as the ratio of the cycle times requires.
    pub(super) parameters: TimeSyncParameters,
    pub(super) ticks: Ticks,
}

/// A parameter outside its range: error 0x4b56.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{:#06x}: {parameter} is {received}, expected {expected}", self.error().code())]
pub struct WrongParameter {
    /// The parameter, in this library's spelling.
    pub parameter: &'static str,
    /// Value received.
    pub received: f64,
    /// Range of valid values.
    pub expected: &'static str,
}

impl WrongParameter {
    /// The manual's error.
    #[must_use]
    pub const fn error(&self) -> SyncError {
        SyncError::WrongParameter
    }
}

/// The cycle times in ticks, the shorter of the two: one of them is 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ticks {
    pub(super) per_task_cycle: i64,
    pub(super) per_data_cycle: i64,
    pub(super) seconds: f64,
}

impl TimeSyncParameters {
    /// Checks every parameter. `task_cycle_time` is the receiver's nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn checked(self, task_cycle_time: Span) -> Result<CheckedTimeSync, WrongParameter> {
        let ticks = self.check(task_cycle_time)?;
        Ok(CheckedTimeSync {
            parameters: self.raised_for(&ticks),
            ticks,
        })
    }

    fn check(&self, task_cycle_time: Span) -> Result<Ticks, WrongParameter> {
        let finite_above_zero = |x: f64| x.is_finite() && x > 0.0;
        let data_cycle_time = self.data_cycle_time.0;
        let checks = [
            (
                "data-cycle-time-s",
                data_cycle_time,
                data_cycle_time.is_finite() && data_cycle_time >= 0.0,
                DATA_CYCLE_TIMES,
            ),
            (
                "threshold-for-sync",
                self.threshold_for_sync,
                finite_above_zero(self.threshold_for_sync),
                "a finite number above 0",
            ),
            (
                "max-cycle-index-difference",
                self.max_cycle_index_difference,
                self.max_cycle_index_difference >= 0.0
                    && self.max_cycle_index_difference.is_finite(),
                "0, or a finite number above",
            ),
            (
                "no-of-periods-for-mean-drift",
                f64::from(self.no_of_periods_for_mean_drift),
                (1..=MOST_PERIODS as u16).contains(&self.no_of_periods_for_mean_drift),
                "1 to 64",
            ),
            (
                "delay-time-offset-s",
                self.delay_time_offset.0,
                self.delay_time_offset.0.is_finite(),
                "a finite number of seconds",
            ),
            (
                "slope1-numerator",
                self.slope1_numerator,
                (0.0..=1.0).contains(&self.slope1_numerator),
                "0 to 1",
            ),
            (
                "slope1-denominator",
                self.slope1_denominator,
                self.slope1_denominator > 0.0 && self.slope1_denominator < 1.0,
                "above 0 and below 1",
            ),
            (
                "end-of-transition-limit",
                f64::from(self.end_of_transition_limit),
                self.end_of_transition_limit >= 1,
                "at least 1",
            ),
        ];
        for (parameter, received, fits, expected) in checks {
            if !fits {
                return Err(WrongParameter {
                    parameter,
                    received,
                    expected,
                });
            }
        }
        self.ticks(task_cycle_time)
    }

    /// Raises the limits that the manual wants larger where one cycle holds several of the other's.
    fn raised_for(mut self, ticks: &Ticks) -> Self {
        let ratio = ticks.per_task_cycle.max(ticks.per_data_cycle);
        let least = ratio + 2;
        if ticks.per_task_cycle > 1 && self.max_cycle_index_difference > 0.0 {
            self.max_cycle_index_difference = self.max_cycle_index_difference.max(least as f64);
        }
        let limit = self.age_limit();
        self.age_of_data_limit = Some(match ratio > 1 && limit > 0 {
            true => limit.max(u16::try_from(least).unwrap_or(u16::MAX)),
            false => limit,
        });
        self
    }

    /// `iAgeOfDataLimit`, with the manual's default.
    pub(super) const fn age_limit(&self) -> u16 {
        match self.age_of_data_limit {
            Some(limit) => limit,
            None => AGE_LIMIT,
        }
    }

    pub(super) const fn slopes(&self) -> Slopes {
        Slopes {
            part: self.slope1_numerator,
            section: self.slope1_denominator,
        }
    }

    fn ticks(&self, task_cycle_time: Span) -> Result<Ticks, WrongParameter> {
        if task_cycle_time <= Span::ZERO {
            return Err(WrongParameter {
                parameter: "task-cycle-time",
                received: task_cycle_time.as_secs_f64(),
                expected: "a cycle time above 0 s",
            });
        }
        let task = task_cycle_time.as_nanos();
        let data = match self.data_cycle_time.to_span().as_nanos() {
            0 => task,
            data => data,
        };
        let whole_ratio = data.max(task) % data.min(task) == 0;
        if !whole_ratio || data.max(task) / data.min(task) > MOST_TICKS {
            return Err(WrongParameter {
                parameter: "data-cycle-time-s",
                received: self.data_cycle_time.0,
                expected: DATA_CYCLE_TIMES,
            });
        }
        let tick = data.min(task);
        Ok(Ticks {
            per_task_cycle: task / tick,
            per_data_cycle: data / tick,
            seconds: tick as f64 * 1e-9,
        })
    }
}

const DATA_CYCLE_TIMES: &str =
    "0, or a whole multiple or a whole part (up to 1000) of the task cycle time";

/// From 100 µs to 100 ms.
const MOST_TICKS: i64 = 1000;
