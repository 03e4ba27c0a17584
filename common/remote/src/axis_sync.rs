//! `FB_AxisSync`: a far axis made local, from one axis structure and one cycle index per cycle.
//!
//! TS5066, chapter 3.1. [`FarSync`] finds the correction time and the mode, [`FarAxis`] applies
//! them; this block is one of each. An error of either latches: `synced` drops and the fallback
//! mode is in force until the block is enabled again, or restarts itself (`automatic_re_init`).

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::time_sync::{
    SyncError, SyncWarning, TimeSyncDiagnostic, TimeSyncState, WrongParameter,
};
use coaxle_clock::{CycleIndex, Seconds, Span};

use super::extrapolate::{ExtrapolateDiagnostic, set_of, with_set};
use super::far_axis::FarAxis;
use super::far_sync::{FarCorrection, FarSync};
use super::parameters::{AxisSyncParameters, FilterMode, FilterState};
use super::planned::KnownMotion;

/// `FB_AxisSync`.
#[doc(alias = "FB_AxisSync")]
#[derive(Clone, Debug)]
pub struct AxisSync {
    task_cycle_time: Span,
    parameters: AxisSyncParameters,
    /// State while enabled.
    enabled: Option<Enabled>,
}

#[derive(Clone, Debug)]
struct Enabled {
    clock: FarSync,
    axis: FarAxis,
}

/// Output of one cycle of [`AxisSync`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSyncOutput {
    /// The far axis, corrected.
    #[doc(alias = "AxisOut")]
    pub axis: NcToPlcAxis,
    /// True if the far clock's drift is known and corrected.
    #[doc(alias = "bSynced")]
    pub synced: bool,
    /// The latched error.
    #[doc(alias = "iErrorId")]
    pub error: Option<SyncError>,
    /// The time sync's warning.
    pub warning: Option<SyncWarning>,
    /// The mode that calculated the set values.
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
    /// The correction that moved the set values, s: that of the mode in force; none if the mode
    /// needs none or has none.
    #[doc(alias = "fCorrectionTime")]
    pub correction_time: Option<Seconds>,
    /// True if the time sync is in time mode.
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
    /// Creates an enabled block. `task_cycle_time` is the receiver's nominal cycle time.
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

    /// The rising edge of `bEnable`: starts from the beginning.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56); the block is disabled then.
    pub fn enable(&mut self) -> Result<(), WrongParameter> {
        // Wrong parameters leave the block disabled instead of running with the previous ones.
        self.enabled = None;
        self.enabled = Some(Enabled {
            clock: FarSync::start(self.task_cycle_time, &self.parameters)?,
            axis: FarAxis::start(self.task_cycle_time, &self.parameters)?,
        });
        Ok(())
    }

    /// The falling edge of `bEnable`: from now on the axis passes through unmodified.
    pub fn disable(&mut self) {
        self.enabled = None;
    }

    /// Changes `fDelayTimeOffset` while running. The change acts at once: slew it.
    pub fn set_delay_time_offset(&mut self, offset: Seconds) {
        self.parameters.time_sync.delay_time_offset = offset;
        // A disabled block has no clock; the stored offset applies from the next rising edge.
        if let Some(enabled) = &mut self.enabled {
            enabled.clock.set_delay_time_offset(offset);
        }
    }

    /// Changes the parameters. In an enabled block the learned values are kept, and the set values
    /// continue from their current state; otherwise the parameters apply from the next rising edge
    /// of `bEnable`.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range; nothing is changed then.
    #[doc(alias = "stAxisSyncParameters")]
    pub fn set_parameters(&mut self, parameters: AxisSyncParameters) -> Result<(), WrongParameter> {
        // Everything is checked before anything changes: otherwise clock and axis would differ after a refusal.
        let checked = parameters.checked(self.task_cycle_time)?;
        if let Some(Enabled { clock, axis }) = &mut self.enabled {
            clock.set_parameters(&checked);
            axis.set_parameters(&checked);
        }
        self.parameters = parameters;
        Ok(())
    }

    /// Runs one cycle. `index` and `axis_in` are the current values of the input image; `elapsed`
    /// counts the own cycles since the previous call. Call it once per cycle and not before data
    /// have arrived.
    pub fn update(
        &mut self,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        filter_mode: FilterMode,
        elapsed: u32,
    ) -> AxisSyncOutput {
        match &mut self.enabled {
            Some(enabled) => {
                let correction = enabled.clock.update(index, filter_mode, elapsed);
                enabled.follow(index, axis_in, &correction, elapsed)
            }
            None => unmodified(axis_in),
        }
    }

    /// Runs one cycle in observer mode. `clock` is the correction of a phase observer, once it is
    /// sure of the far clock; without one the start-up mode bridges. The only errors here are data
    /// that are missing beyond the age limit and a position too far off; neither latches.
    pub fn update_by_clock(
        &mut self,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        clock: Option<Seconds>,
        elapsed: u32,
    ) -> AxisSyncOutput {
        match &mut self.enabled {
            Some(enabled) => {
                let correction = enabled.clock.update_by_clock(index, clock, elapsed);
                enabled.follow(index, axis_in, &correction, elapsed)
            }
            None => unmodified(axis_in),
        }
    }
}

impl Enabled {
    fn follow(
        &mut self,
        index: CycleIndex,
        axis_in: &NcToPlcAxis,
        correction: &FarCorrection,
        elapsed: u32,
    ) -> AxisSyncOutput {
        // The correction of this very cycle: one from the previous cycle is off by a cycle's drift and every beat.
        let known = KnownMotion::default();
        let moved = (self.axis).update(&set_of(axis_in), correction, known, elapsed);
        if moved.re_initialised {
            // The block is a unit: its clock restarts with its axis.
            self.clock.restart(index);
        }
        AxisSyncOutput {
            axis: with_set(axis_in, &moved.set),
            synced: moved.synced,
            error: moved.error,
            warning: correction.warning,
            state: moved.state,
            beats: correction.time_sync.beats,
            diagnostic: AxisSyncDiagnostic {
                correction_time: moved.correction_time,
                time_mode: correction.time_sync.state == TimeSyncState::StartUp,
                time_sync: correction.time_sync.diagnostic,
                extrapolate: moved.diagnostic,
            },
        }
    }
}

/// `bEnable = FALSE`: passes the input through.
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
