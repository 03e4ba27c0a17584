//! `FB_AxisSync`: a far axis made local, from one axis structure and one cycle index per cycle.
//!
//! TS5066, chapter 3.1. [`TimeSync`] finds the correction time, [`AxisExtrapolate`] applies it; this
//! block chooses the mode. An error of either latches: `synced` drops and the fallback mode is in
//! force until the block is enabled anew, or restarts itself (`automatic_re_init`).

use coaxle_clock::time_sync::{
    SyncError, SyncWarning, TimeSync, TimeSyncDiagnostic, TimeSyncOutput, TimeSyncParameters,
    TimeSyncState, WrongParameter,
};
use coaxle_clock::{CycleIndex, Seconds, Span};

use super::extrapolate::{
    AxisExtrapolate, CorrectionTimes, ExtrapolateDiagnostic, ExtrapolateMode, ExtrapolateOutput,
    ExtrapolateParameters, FallBackMode,
};
use coaxle_axis::NcToPlcAxis;

/// `FB_AxisSync`.
#[doc(alias = "FB_AxisSync")]
#[derive(Clone, Debug)]
pub struct AxisSync {
    task_cycle_time: Span,
    parameters: AxisSyncParameters,
    /// None while disabled.
    enabled: Option<Enabled>,
}

#[derive(Clone, Debug)]
struct Enabled {
    time_sync: TimeSync,
    extrapolate: AxisExtrapolate,
    /// A position error latches here; errors of the time sync latch there.
    position_error: Option<SyncError>,
    silence: Silence,
}

/// How long the index has not changed.
#[derive(Clone, Copy, Debug, Default)]
struct Silence {
    index: Option<CycleIndex>,
    cycles: u32,
}

impl Silence {
    fn count(&mut self, index: CycleIndex, elapsed: u32) {
        self.cycles = match self.index.replace(index) {
            Some(last) if last == index => self.cycles.saturating_add(elapsed),
            _ => 0,
        };
    }
}

/// `ST_AxisSyncParameters` with the manual's defaults, TS5066 chapter 3.4.
#[doc(alias = "ST_AxisSyncParameters")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct AxisSyncParameters {
    /// What automatic mode does until the drift is known.
    #[doc(alias = "eStartUpMode")]
    pub start_up_mode: StartUpMode,
    /// What it does when synchronisation is lost, or the position strays too far.
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

/// `E_Sync_StartUpMode`, TS5066 chapter 3.9.
#[doc(alias = "E_Sync_StartUpMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// `E_Sync_FilterMode`: how the set values are to be calculated. TS5066 chapter 3.7.
#[doc(alias = "E_Sync_FilterMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum FilterMode {
    /// Start-up mode, then sync mode; the fallback when sync is lost.
    #[default]
    Auto = 0,
    /// As received.
    Bypass = 1,
    /// Through the PT1 filter.
    Pt1 = 2,
    /// Beats are hidden when they happen.
    Time = 4,
    /// By a phase observer's clock; time mode, or whatever the start-up mode is, bridges until that is
    /// sure. Not in the manual.
    Observer = 5,
}

/// `E_Sync_FilterState`: how the set values were calculated. TS5066 chapter 3.8.
#[doc(alias = "E_Sync_FilterState")]
pub type FilterState = ExtrapolateMode;

/// What one cycle of [`AxisSync`] gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSyncOutput {
    /// The far axis, corrected.
    #[doc(alias = "AxisOut")]
    pub axis: NcToPlcAxis,
    /// Whether the far clock's drift is known and corrected.
    #[doc(alias = "bSynced")]
    pub synced: bool,
    /// The error that is latched.
    #[doc(alias = "iErrorId")]
    pub error: Option<SyncError>,
    /// The time sync's warning.
    pub warning: Option<SyncWarning>,
    /// The mode that made the set values.
    #[doc(alias = "eFilterState")]
    pub state: FilterState,
    /// Beats since the block was enabled.
    pub beats: u32,
    /// The manual's diagnostic values.
    #[doc(alias = "stAxisSyncDiagnostic")]
    pub diagnostic: AxisSyncDiagnostic,
}

/// `ST_AxisSyncDiagnostic`, TS5066 chapter 3.5.
#[doc(alias = "ST_AxisSyncDiagnostic")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisSyncDiagnostic {
    /// The correction that moved the set values, s: that of the mode in force, none where it needs
    /// none or has none.
    #[doc(alias = "fCorrectionTime")]
    pub correction_time: Option<Seconds>,
    /// Whether the time sync is in time mode.
    #[doc(alias = "bTimeMode")]
    pub time_mode: bool,
    /// The time sync's values.
    #[doc(alias = "stTimeSyncDiagnostic")]
    pub time_sync: TimeSyncDiagnostic,
    /// The extrapolation's values: received minus calculated.
    #[doc(alias = "stAxisExtrapolateDiagnostic")]
    #[doc(alias = "fPositionDiff")]
    #[doc(alias = "fVeloDiff")]
    pub extrapolate: ExtrapolateDiagnostic,
}

impl AxisSync {
    /// A block that is enabled. `task_cycle_time` is the receiver's nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn start(
        task_cycle_time: Span,
        parameters: AxisSyncParameters,
    ) -> Result<Self, WrongParameter> {
        let mut block = Self {
            task_cycle_time,
            parameters,
            enabled: None,
        };
        block.enable()?;
        Ok(block)
    }

    /// The rising edge of `bEnable`: starts anew, whatever went before.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56); the block is disabled then.
    pub fn enable(&mut self) -> Result<(), WrongParameter> {
        self.enabled = None;
        self.enabled = Some(Enabled {
            time_sync: TimeSync::start(self.task_cycle_time, self.parameters.time_sync)?,
            extrapolate: AxisExtrapolate::start(self.task_cycle_time, self.parameters.extrapolate)?,
            position_error: None,
            silence: Silence::default(),
        });
        Ok(())
    }

    /// The falling edge of `bEnable`: from now on the axis passes through unmodified.
    pub fn disable(&mut self) {
        self.enabled = None;
    }

    /// Changes `fDelayTimeOffset` while running. It acts at once: slew it.
    pub fn set_delay_time_offset(&mut self, offset: Seconds) {
        self.parameters.time_sync.delay_time_offset = offset;
        if let Some(enabled) = &mut self.enabled {
            enabled.time_sync.set_delay_time_offset(offset);
        }
    }

    /// One cycle. `index` and `axis_in` are what the input image holds now; `elapsed` counts the own
    /// cycles since the previous call. Call it once per cycle and not before data have come.
    pub fn update(
        &mut self,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        filter_mode: FilterMode,
        elapsed: u32,
    ) -> AxisSyncOutput {
        match &mut self.enabled {
            Some(enabled) => enabled.update(&self.parameters, index, axis_in, filter_mode, elapsed),
            None => unmodified(axis_in),
        }
    }

    /// One cycle in observer mode. `clock` is the correction a phase observer asks for, once it is
    /// sure of the far clock; without one the start-up mode bridges. Here the only errors are data
    /// that stay away beyond the age limit and a position too far off; neither latches.
    pub fn update_by_clock(
        &mut self,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        clock: Option<Seconds>,
        elapsed: u32,
    ) -> AxisSyncOutput {
        match &mut self.enabled {
            Some(enabled) => {
                enabled.update_by_clock(&self.parameters, index, axis_in, clock, elapsed)
            }
            None => unmodified(axis_in),
        }
    }
}

impl Enabled {
    fn update(
        &mut self,
        parameters: &AxisSyncParameters,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        filter_mode: FilterMode,
        elapsed: u32,
    ) -> AxisSyncOutput {
        let time = self.time_sync.update(index, elapsed);
        let corrections = CorrectionTimes {
            sync: time.correction_time,
            time: time.time_mode_correction,
            observer: None,
        };
        let mode = self.mode(parameters, filter_mode, &time);
        let fall_back = parameters.fall_back_mode;
        let moved = self
            .extrapolate
            .update_with(axis_in, corrections, mode, fall_back, elapsed);
        let was_latched = self.position_error.is_some();
        self.position_error = self.position_error.or(moved.error);
        let error = match time.state {
            TimeSyncState::Failed(error) => Some(error),
            _ => self.position_error,
        };
        if was_latched && parameters.time_sync.automatic_re_init {
            self.re_initialise(index);
        }
        let synced = time.state == TimeSyncState::Synced && error.is_none();
        output(&time, &moved, &corrections, synced, error)
    }

    fn update_by_clock(
        &mut self,
        parameters: &AxisSyncParameters,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        clock: Option<Seconds>,
        elapsed: u32,
    ) -> AxisSyncOutput {
        self.silence.count(index, elapsed);
        let time = self.time_sync.update(index, elapsed);
        if let TimeSyncState::Failed(_) = time.state {
            // It only bridges: whatever it lost, it starts over.
            self.time_sync.restart(index);
        }
        let limit = u32::from(self.time_sync.parameters().age_of_data_limit);
        let silent = limit > 0 && self.silence.cycles > limit;
        let corrections = CorrectionTimes {
            sync: None,
            time: time.time_mode_correction,
            observer: clock.map(|clock| clock + parameters.time_sync.delay_time_offset),
        };
        let mode = match clock {
            _ if silent => parameters.fall_back_mode.into(),
            Some(_) => ExtrapolateMode::Observer,
            None => parameters.start_up_mode.into(),
        };
        let fall_back = parameters.fall_back_mode;
        let moved = self
            .extrapolate
            .update_with(axis_in, corrections, mode, fall_back, elapsed);
        let error = silent
            .then_some(SyncError::MaxDataAgeExceeded)
            .or(moved.error);
        let synced = clock.is_some() && error.is_none();
        AxisSyncOutput {
            // What the beats say of the drift is nothing new to who knows it better.
            warning: time.warning.filter(|_| clock.is_none()),
            ..output(&time, &moved, &corrections, synced, error)
        }
    }

    fn mode(
        &self,
        parameters: &AxisSyncParameters,
        filter_mode: FilterMode,
        time: &TimeSyncOutput,
    ) -> ExtrapolateMode {
        match (filter_mode, time.state) {
            (FilterMode::Bypass, _) => ExtrapolateMode::Bypass,
            (FilterMode::Pt1, _) => ExtrapolateMode::Pt1,
            (_, TimeSyncState::Failed(_)) => parameters.fall_back_mode.into(),
            _ if self.position_error.is_some() => parameters.fall_back_mode.into(),
            (FilterMode::Time, _) => ExtrapolateMode::Time,
            (FilterMode::Observer, _) => ExtrapolateMode::Observer,
            (FilterMode::Auto, TimeSyncState::Synced) => ExtrapolateMode::Sync,
            (FilterMode::Auto, TimeSyncState::StartUp) => parameters.start_up_mode.into(),
        }
    }

    /// One cycle after a position error: start up again.
    fn re_initialise(&mut self, index: CycleIndex) {
        self.position_error = None;
        self.time_sync.restart(index);
    }
}

fn output(
    time: &TimeSyncOutput,
    moved: &ExtrapolateOutput,
    corrections: &CorrectionTimes,
    synced: bool,
    error: Option<SyncError>,
) -> AxisSyncOutput {
    AxisSyncOutput {
        axis: moved.axis,
        synced,
        error,
        warning: time.warning,
        state: moved.state,
        beats: time.beats,
        diagnostic: AxisSyncDiagnostic {
            correction_time: match moved.state {
                FilterState::Sync => corrections.sync,
                FilterState::Time => corrections.time,
                FilterState::Observer => corrections.observer,
                FilterState::Bypass | FilterState::Pt1 => None,
            },
            time_mode: time.state == TimeSyncState::StartUp,
            time_sync: time.diagnostic,
            extrapolate: moved.diagnostic,
        },
    }
}

/// `bEnable = FALSE`: what comes in goes out.
fn unmodified(axis_in: &NcToPlcAxis) -> AxisSyncOutput {
    AxisSyncOutput {
        axis: *axis_in,
        synced: false,
        error: None,
        warning: None,
        state: FilterState::Bypass,
        beats: 0,
        diagnostic: AxisSyncDiagnostic::default(),
    }
}

#[cfg(test)]
mod tests;
