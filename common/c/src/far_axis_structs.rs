//! Structs of a far axis.

use ::coaxle_axis::motion_plan::AwaitedPosition;
use ::coaxle_axis::{Modulo, TravelDirection};
use coaxle_clock::time_sync::TimeSyncParameters;
use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_remote::{
    AxisSyncParameters, ExtrapolateParameters, FallBackMode, FarAxisOutput, FilterMode, StartUpMode,
};

use crate::failure::Failure;
use crate::memory::{finite, growing};
use crate::phase::cycle_time;

/// Mode of a far axis: the start-up mode, then sync mode (`E_Sync_FilterMode`).
pub const COAXLE_MODE_AUTO: u32 = 0;
/// As received, beats included.
pub const COAXLE_MODE_BYPASS: u32 = 1;
/// Through the PT1 filter.
pub const COAXLE_MODE_PT1: u32 = 2;
/// By the drift that the beats show: a state only, reached in `COAXLE_MODE_AUTO`.
pub const COAXLE_MODE_SYNC: u32 = 3;
/// Beats are hidden when they happen.
pub const COAXLE_MODE_TIME: u32 = 4;
/// By the correction of a far clock; the start-up mode bridges until that is sure.
pub const COAXLE_MODE_OBSERVER: u32 = 5;

/// Set values are those of the master.
pub const COAXLE_FOLLOWING: u32 = 0;
/// Without a master: the axis is braked, or at rest.
pub const COAXLE_BRAKING: u32 = 1;
/// The axis is brought back to its master.
pub const COAXLE_REJOINING: u32 = 2;

/// An age limit that is left to the library: 7 own cycles; in mode observer as many as 100 ms take, and 7 of the far node.
pub const COAXLE_AGE_BY_DEFAULT: u32 = u32::MAX;

/// Parameters of a far axis: `ST_AxisSyncParameters`. `coaxle_far_axis_parameters_init` sets them to the manual's defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_far_axis_parameters {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_MODE_AUTO`, `_BYPASS`, `_PT1`, `_TIME` or `_OBSERVER` (`eFilterMode`).
    pub mode: u32,
    /// Own nominal cycle time, ns: 100 000 to 100 000 000.
    pub cycle_time_ns: i64,
    /// That of the far node, ns; 0: the own one. One is a whole multiple of the other (`fDataCycleTime`).
    pub data_cycle_time_ns: i64,
    /// Until the drift is known: `COAXLE_MODE_BYPASS`, `_PT1` or `_TIME` (`eStartUpMode`).
    pub start_up_mode: u32,
    /// After an error: `COAXLE_MODE_BYPASS` or `_PT1` (`eFallBackMode`).
    pub fall_back_mode: u32,
    /// Most own cycles in a row without a new sample, 1 to 65 535; 0: any number; or `COAXLE_AGE_BY_DEFAULT` (`iAgeOfDataLimit`).
    pub age_of_data_limit: u32,
    /// The drift is the mean over this many periods between beats, 1 to 64 (`iNoOfPeriodsForMeanDrift`).
    pub periods_for_mean_drift: u32,
    /// Cycles for which the offset must stay constant to make a plateau, at least 1 (`iEndOfTransitionLimit`).
    pub end_of_transition_limit: u32,
    /// Cycles over which old and new ramp are blended after a beat (`iNewDriftBendingCycles`).
    pub new_drift_bending_cycles: u32,
    /// Cycles over which time mode takes a beat's difference away (`iTimeModeBlendingCycles`).
    pub time_mode_blending_cycles: u32,
    /// Other than 0: stay in time mode (`bForceTimeMode`).
    pub force_time_mode: u32,
    /// Other than 0: start up again by itself, one cycle after a fault (`bAutomaticReInit`).
    pub automatic_re_init: u32,
    /// Other than 0: extrapolate with the acceleration, too (`bUseAccForExtrapolation`).
    pub use_acceleration: u32,
    /// Correction time, in own cycles, below which sync mode may begin; above 0 (`fThresholdForSync`).
    pub threshold_for_sync: f64,
    /// Largest difference between corrected and received index; 0: any (`fMaxCycleIndexDifference`).
    pub max_cycle_index_difference: f64,
    /// Added to the correction time, s; positive: further into the future (`fDelayTimeOffset`).
    pub delay_time_offset_s: f64,
    /// Part of a beat's correction in the first section after it, 0 to 1 (`fSlope1Numerator`).
    pub slope1_numerator: f64,
    /// Length of that section as a part of the time between beats, above 0, below 1 (`fSlope1Denominator`).
    pub slope1_denominator: f64,
    /// Largest difference between received and calculated position, u; 0: any (`fMaxPositionDiff`).
    pub max_position_diff: f64,
    /// Time constant of the PT1 filter of the position, own cycles; 0: none (`fT1factorPos`).
    pub t1_factor_pos: f64,
    /// That of the velocity (`fT1factorVelo`).
    pub t1_factor_velo: f64,
    /// Time over which a change of mode is blended, s (`fBlendingTime`).
    pub blending_time_s: f64,
    /// Other than 0: without steps. An axis whose node is silent is braked, and is brought back along a curve when that returns, restarts
    /// or is shown by another delay. 0: as `FB_AxisSync`, which blends changes of the mode and jumps to what it receives after a silence.
    pub is_continuous: u32,
    /// 0.
    pub reserved: u32,
}

/// Sample of a far axis in a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_far_sample {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// Cycle count of the far node.
    pub count: u64,
    /// Time after its generation at which it is shown, ns, as the frame's header states it; 0: it is moved to now.
    pub present_after_ns: i64,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
}

/// Set values of a far axis, and how they came about.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_far_axis_state {
    /// `sizeof` this struct.
    pub struct_size: u32,
    /// `COAXLE_MODE_BYPASS` to `COAXLE_MODE_OBSERVER`: what calculated them (`eFilterState`).
    pub mode: u32,
    /// Other than 0 if the far clock is known and corrected, and nothing is wrong (`bSynced`).
    pub is_synced: u32,
    /// Other than 0 if samples have been missing for longer than the age limit.
    pub is_silent: u32,
    /// Other than 0 if they lie between two frames that are shown later.
    pub is_interpolated: u32,
    /// Other than 0 if they are those of the plan.
    pub is_planned: u32,
    /// Error, a code of TS5066; 0: none (`iErrorId`).
    pub error: u32,
    /// Warning, a code of TS5066; 0: none.
    pub warning: u32,
    /// Beats (`iCountBeats`).
    pub beats: u32,
    /// Samples that contradicted the plan.
    pub plan_contradictions: u32,
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
    /// Time by which the newest sample was moved, s; not a number in a mode without one (`fCorrectionTime`).
    pub correction_s: f64,
    /// Time by which the axis is shown later, s; 0: its newest sample is moved to now.
    pub shown_later_s: f64,
    /// Time from the instant shown to the end of the promise, s; not a number without one.
    pub promised_ahead_s: f64,
    /// Received minus calculated position, u (`fPositionDiff`).
    pub position_diff: f64,
    /// Received minus calculated velocity, u/s (`fVeloDiff`).
    pub velocity_diff: f64,
    /// `COAXLE_FOLLOWING`, `COAXLE_BRAKING` or `COAXLE_REJOINING`, of an axis without steps.
    pub continuity: u32,
    /// 0.
    pub reserved: u32,
}

/// A position that a planned axis comes to. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_awaited_position {
    /// The position, u.
    pub position: f64,
    /// Period in which it repeats, u, above 0; 0: that position alone.
    pub modulo: f64,
    /// 1 or -1: the direction in which the axis comes to it; 0: any.
    pub direction: i32,
    /// 0.
    pub reserved: u32,
}

growing! {
    coaxle_far_axis_parameters, 136;
    coaxle_far_sample, 48;
    coaxle_far_axis_state, 104;
}

impl coaxle_far_axis_parameters {
    pub(crate) fn defaults(cycle_time_ns: i64, data_cycle_time_ns: i64) -> Self {
        let AxisSyncParameters {
            start_up_mode,
            fall_back_mode,
            extrapolate,
            time_sync,
        } = AxisSyncParameters::default();
        Self {
            struct_size: 0,
            mode: COAXLE_MODE_OBSERVER,
            cycle_time_ns,
            data_cycle_time_ns,
            start_up_mode: start_up_mode as u32,
            fall_back_mode: fall_back_mode as u32,
            age_of_data_limit: time_sync
                .age_of_data_limit
                .map_or(COAXLE_AGE_BY_DEFAULT, u32::from),
            periods_for_mean_drift: time_sync.no_of_periods_for_mean_drift.into(),
            end_of_transition_limit: time_sync.end_of_transition_limit.into(),
            new_drift_bending_cycles: time_sync.new_drift_bending_cycles.into(),
            time_mode_blending_cycles: time_sync.time_mode_blending_cycles.into(),
            force_time_mode: time_sync.force_time_mode.into(),
            automatic_re_init: time_sync.automatic_re_init.into(),
            use_acceleration: extrapolate.use_acc_for_extrapolation.into(),
            threshold_for_sync: time_sync.threshold_for_sync,
            max_cycle_index_difference: time_sync.max_cycle_index_difference,
            delay_time_offset_s: time_sync.delay_time_offset.0,
            slope1_numerator: time_sync.slope1_numerator,
            slope1_denominator: time_sync.slope1_denominator,
            max_position_diff: extrapolate.max_position_diff,
            t1_factor_pos: extrapolate.t1_factor_pos,
            t1_factor_velo: extrapolate.t1_factor_velo,
            blending_time_s: extrapolate.blending_time.0,
            is_continuous: 1,
            reserved: 0,
        }
    }

    pub(crate) fn mode(&self) -> Result<FilterMode, Failure> {
        Ok(match self.mode {
            COAXLE_MODE_AUTO => FilterMode::Auto,
            COAXLE_MODE_BYPASS => FilterMode::Bypass,
            COAXLE_MODE_PT1 => FilterMode::Pt1,
            COAXLE_MODE_TIME => FilterMode::Time,
            COAXLE_MODE_OBSERVER => FilterMode::Observer,
            other => return Err(Failure::range("mode", other, "0, 1, 2, 4 or 5")),
        })
    }

    /// Cycle time of the far node, with this own one.
    pub(crate) fn data_cycle_time(&self, own: CycleTime) -> Result<Span, Failure> {
        if self.data_cycle_time_ns == 0 {
            return Ok(own.span());
        }
        cycle_time(self.data_cycle_time_ns)
            .map(CycleTime::span)
            .map_err(|_| {
                let expected = "0, or 100000 to 100000000";
                Failure::range("data_cycle_time_ns", self.data_cycle_time_ns, expected)
            })
    }

    pub(crate) fn checked(&self, data_cycle: Span) -> Result<AxisSyncParameters, Failure> {
        let age_of_data_limit = match self.age_of_data_limit {
            COAXLE_AGE_BY_DEFAULT => None,
            limit => Some(cycles("age_of_data_limit", limit)?),
        };
        Ok(AxisSyncParameters {
            start_up_mode: self.start_up_mode()?,
            fall_back_mode: self.fall_back_mode()?,
            extrapolate: ExtrapolateParameters {
                max_position_diff: self.max_position_diff,
                use_acc_for_extrapolation: self.use_acceleration != 0,
                t1_factor_pos: self.t1_factor_pos,
                t1_factor_velo: self.t1_factor_velo,
                blending_time: Seconds(self.blending_time_s),
                ..ExtrapolateParameters::default()
            },
            time_sync: TimeSyncParameters {
                data_cycle_time: Seconds(data_cycle.as_secs_f64()),
                threshold_for_sync: self.threshold_for_sync,
                max_cycle_index_difference: self.max_cycle_index_difference,
                age_of_data_limit,
                no_of_periods_for_mean_drift: cycles(
                    "periods_for_mean_drift",
                    self.periods_for_mean_drift,
                )?,
                delay_time_offset: Seconds(self.delay_time_offset_s),
                slope1_numerator: self.slope1_numerator,
                slope1_denominator: self.slope1_denominator,
                end_of_transition_limit: cycles(
                    "end_of_transition_limit",
                    self.end_of_transition_limit,
                )?,
                new_drift_bending_cycles: cycles(
                    "new_drift_bending_cycles",
                    self.new_drift_bending_cycles,
                )?,
                time_mode_blending_cycles: cycles(
                    "time_mode_blending_cycles",
                    self.time_mode_blending_cycles,
                )?,
                force_time_mode: self.force_time_mode != 0,
                automatic_re_init: self.automatic_re_init != 0,
                ..TimeSyncParameters::default()
            },
        })
    }

    fn start_up_mode(&self) -> Result<StartUpMode, Failure> {
        Ok(match self.start_up_mode {
            COAXLE_MODE_BYPASS => StartUpMode::Bypass,
            COAXLE_MODE_PT1 => StartUpMode::Pt1,
            COAXLE_MODE_TIME => StartUpMode::Time,
            other => return Err(Failure::range("start_up_mode", other, "1, 2 or 4")),
        })
    }

    fn fall_back_mode(&self) -> Result<FallBackMode, Failure> {
        Ok(match self.fall_back_mode {
            COAXLE_MODE_BYPASS => FallBackMode::Bypass,
            COAXLE_MODE_PT1 => FallBackMode::Pt1,
            other => return Err(Failure::range("fall_back_mode", other, "1 or 2")),
        })
    }
}

/// A number of cycles.
fn cycles(field: &str, received: u32) -> Result<u16, Failure> {
    u16::try_from(received).map_err(|_| Failure::range(field, received, "at most 65535"))
}

impl coaxle_far_sample {
    pub(crate) fn set(&self) -> Result<Kinematics, Failure> {
        Ok(Kinematics {
            position: finite("position", self.position)?,
            velocity: finite("velocity", self.velocity)?,
            acceleration: finite("acceleration", self.acceleration)?,
        })
    }
}

impl coaxle_far_axis_state {
    /// Makes it of the output of an axis; what that does not say is 0.
    pub(crate) fn of(moved: &FarAxisOutput) -> Self {
        Self {
            struct_size: 0,
            mode: moved.state as u32,
            is_synced: moved.synced.into(),
            is_silent: 0,
            is_interpolated: moved.is_interpolated.into(),
            is_planned: moved.is_planned.into(),
            error: moved.error.map_or(0, |error| error.code().into()),
            warning: 0,
            beats: 0,
            plan_contradictions: 0,
            position: moved.set.position,
            velocity: moved.set.velocity,
            acceleration: moved.set.acceleration,
            correction_s: moved.correction_time.map_or(f64::NAN, |time| time.0),
            shown_later_s: 0.0,
            promised_ahead_s: f64::NAN,
            position_diff: moved.diagnostic.position_diff,
            velocity_diff: moved.diagnostic.velocity_diff,
            continuity: COAXLE_FOLLOWING,
            reserved: 0,
        }
    }
}

impl coaxle_awaited_position {
    pub(crate) fn checked(&self) -> Result<AwaitedPosition, Failure> {
        let modulo =
            match self.modulo {
                0.0 => None,
                period => Some(Modulo::new(period).map_err(|_| {
                    Failure::range("modulo", period, "0, or a finite number above it")
                })?),
            };
        let direction = match self.direction {
            0 => None,
            1 => Some(TravelDirection::Forward),
            -1 => Some(TravelDirection::Backward),
            other => return Err(Failure::range("direction", other, "1, -1 or 0")),
        };
        Ok(AwaitedPosition {
            position: finite("position", self.position)?,
            modulo,
            direction,
        })
    }
}
