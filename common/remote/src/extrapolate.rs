//! `FB_AxisExtrapolateValues`: set values moved in time by a correction.
//!
//! TS5066, chapter 3.3. Details that the manual leaves open:
//!
//! * The largest position difference is in user units (the manual's velocity · s), despite its name
//!   in the text.
//! * Every change of mode is blended over `blending_time`, not only that between PT1 and sync, so
//!   that no change of mode is a step. A blend that is overtaken by another change continues from
//!   its current state: the rest of it is added to the difference between the two modes, and never
//!   to itself. So the set values stay between those of the modes at any number of changes.
//! * Beyond 20 ms of correction the acceleration fades: old values accelerate no axis for long.
//! * The velocity during a blend is that of its positions.
//! * Sync, time and observer mode differ only in the source of their correction; all extrapolate.

mod blend;
mod candidates;

use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{Seconds, Span};

use super::planned::KnownMotion;
use super::prediction::moved_on;
use super::pt1::Pt1;
use blend::Blend;
pub(super) use candidates::CorrectionTimes;
use candidates::{Aim, Candidates};
use coaxle_axis::NcToPlcAxis;
use coaxle_curve::profile::Kinematics;

/// `FB_AxisExtrapolateValues`.
#[doc(alias = "FB_AxisExtrapolateValues")]
#[derive(Clone, Debug)]
pub struct AxisExtrapolate {
    parameters: ExtrapolateParameters,
    task_cycle_time: f64,
    pt1: Pt1,
    mode: Option<ExtrapolateMode>,
    /// Set values of the newest mode, before a blend is added.
    aim: SetValues,
    blend: Blend,
    /// True if the next cycle continues from the last one's state despite all changes.
    carries_on: bool,
}

/// `ST_AxisExtrapolateParameters` with the manual's defaults, TS5066 chapter 3.13.
#[doc(alias = "ST_AxisExtrapolateParameters")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct ExtrapolateParameters {
    /// Largest difference between received and calculated set position, u; 0: not monitored.
    #[doc(alias = "fMaxPositionDiff")]
    #[doc(alias = "fMaxPositionDiffFactor")]
    pub max_position_diff: f64,
    /// Extrapolate with the set acceleration too. Switch off for encoder and interpolated axes.
    #[doc(alias = "bUseAccForExtrapolation")]
    pub use_acc_for_extrapolation: bool,
    /// Time constant of the PT1 filter of the position, in receiver cycles; 0: no filter.
    #[doc(alias = "fT1factorPos")]
    pub t1_factor_pos: f64,
    /// Time constant of the PT1 filter of the velocity, in receiver cycles; 0: no filter.
    #[doc(alias = "fT1factorVelo")]
    pub t1_factor_velo: f64,
    /// Time over which a change of mode is blended, s.
    #[doc(alias = "fBlendingTime")]
    #[cfg_attr(feature = "serde", serde(rename = "blending-time-s"))]
    pub blending_time: Seconds,
    /// Reserved; kept for completeness.
    #[doc(alias = "nSysCmd")]
    pub sys_cmd: u32,
}

impl ExtrapolateParameters {
    /// Checks every parameter.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn check(&self) -> Result<(), WrongParameter> {
        let checks = [
            ("max-position-diff", self.max_position_diff),
            ("t1-factor-pos", self.t1_factor_pos),
            ("t1-factor-velo", self.t1_factor_velo),
            ("blending-time-s", self.blending_time.0),
        ];
        for (parameter, received) in checks {
            // NaN compares false with everything: the negated form refuses it.
            if !(received.is_finite() && received >= 0.0) {
                return Err(WrongParameter {
                    parameter,
                    received,
                    expected: "a finite number of at least 0",
                });
            }
        }
        Ok(())
    }
}

impl Default for ExtrapolateParameters {
    fn default() -> Self {
        Self {
            max_position_diff: 0.0,
            use_acc_for_extrapolation: true,
            t1_factor_pos: 3.0,
            t1_factor_velo: 3.0,
            blending_time: Seconds(0.06),
            sys_cmd: 1,
        }
    }
}

/// `E_Sync_ExtrapolateMode` and `E_Sync_ExtrapolateState`: method of calculating the set values.
#[doc(alias = "E_Sync_ExtrapolateMode")]
#[doc(alias = "E_Sync_ExtrapolateState")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum ExtrapolateMode {
    /// As received, including beats.
    #[default]
    Bypass = 1,
    /// Through the PT1 filter.
    Pt1 = 2,
    /// Extrapolated by the correction time of sync mode.
    Sync = 3,
    /// Extrapolated by the correction time of time mode.
    Time = 4,
    /// Extrapolated by the phase observer's correction; not in the manual.
    Observer = 5,
}

impl ExtrapolateMode {
    /// Name in traces, status and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bypass => "bypass",
            Self::Pt1 => "pt1",
            Self::Sync => "sync",
            Self::Time => "time",
            Self::Observer => "observer",
        }
    }
}

/// `E_Sync_FallBackMode`: reaction if the calculated position deviates too far, or sync is lost.
#[doc(alias = "E_Sync_FallBackMode")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u8)]
pub enum FallBackMode {
    /// As received.
    Bypass = 1,
    /// Through the PT1 filter.
    #[default]
    Pt1 = 2,
}

impl From<FallBackMode> for ExtrapolateMode {
    fn from(mode: FallBackMode) -> Self {
        match mode {
            FallBackMode::Bypass => Self::Bypass,
            FallBackMode::Pt1 => Self::Pt1,
        }
    }
}

/// Output of one cycle of [`AxisExtrapolate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExtrapolateOutput {
    /// The received axis with its set values replaced; every other field passes through.
    #[doc(alias = "AxisOut")]
    pub axis: NcToPlcAxis,
    /// Mode that was actually used.
    #[doc(alias = "eState")]
    pub state: ExtrapolateMode,
    /// 0x4b59 while the position difference is too large; the fallback is in force then.
    #[doc(alias = "iErrorId")]
    pub error: Option<SyncError>,
    /// The manual's diagnostic values.
    pub diagnostic: ExtrapolateDiagnostic,
}

/// `ST_AxisExtrapolateDiagnostic`, TS5066 chapter 3.12.
#[doc(alias = "ST_AxisExtrapolateDiagnostic")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExtrapolateDiagnostic {
    /// Received minus calculated set position, u.
    #[doc(alias = "fPositionDiff")]
    pub position_diff: f64,
    /// Received minus calculated set velocity, u/s.
    #[doc(alias = "fVeloDiff")]
    pub velocity_diff: f64,
}

/// Bare set values after one cycle.
pub(super) struct Moved {
    pub(super) set: Kinematics,
    pub(super) state: ExtrapolateMode,
    pub(super) error: Option<SyncError>,
    pub(super) diagnostic: ExtrapolateDiagnostic,
    /// True if they lie between two frames that are shown later.
    pub(super) is_interpolated: bool,
    /// True if they are those of a plan.
    pub(super) is_planned: bool,
}

/// The set values of an axis.
pub(super) const fn set_of(axis: &NcToPlcAxis) -> Kinematics {
    Kinematics {
        position: axis.set_position,
        velocity: axis.set_velocity,
        acceleration: axis.set_acceleration,
    }
}

/// The axis with position and velocity replaced; every other field passes through.
pub(super) const fn with_set(axis: &NcToPlcAxis, set: &Kinematics) -> NcToPlcAxis {
    NcToPlcAxis {
        set_position: set.position,
        set_velocity: set.velocity,
        ..*axis
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct SetValues {
    position: f64,
    velocity: f64,
}

impl From<Kinematics> for SetValues {
    fn from(set: Kinematics) -> Self {
        Self {
            position: set.position,
            velocity: set.velocity,
        }
    }
}

impl AxisExtrapolate {
    /// Creates a block at rest. `task_cycle_time` is the receiver's.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn start(
        task_cycle_time: Span,
        parameters: ExtrapolateParameters,
    ) -> Result<Self, WrongParameter> {
        parameters.check()?;
        Ok(Self {
            pt1: Pt1::new(parameters.t1_factor_pos, parameters.t1_factor_velo),
            task_cycle_time: task_cycle_time.as_secs_f64(),
            parameters,
            mode: None,
            aim: SetValues::default(),
            blend: Blend::default(),
            carries_on: false,
        })
    }

    /// Changes the parameters while running. The set values continue from their current state.
    pub(super) fn set_parameters(&mut self, parameters: &ExtrapolateParameters) {
        self.parameters = *parameters;
        self.pt1
            .set(parameters.t1_factor_pos, parameters.t1_factor_velo);
        self.carry_on();
    }

    /// Continues the next cycle from the last one's state: all changes by then are blended.
    pub(super) const fn carry_on(&mut self) {
        self.carries_on = true;
    }

    /// True while a change of mode is being blended.
    pub(super) fn is_blending(&self) -> bool {
        !self.blend.is_over()
    }

    /// Restarts with an axis that may be moving: no blend, and a settled filter.
    pub(super) fn begin_anew(&mut self) {
        self.restart();
        // Without its lag at a moving axis the filter would fall behind within its time constant, which is a step of
        // the velocity.
        self.pt1.restart_settled(self.task_cycle_time);
    }

    /// Returns to the initial state at rest.
    pub(super) fn restart(&mut self) {
        self.pt1.restart();
        self.mode = None;
        self.aim = SetValues::default();
        self.blend = Blend::default();
        self.carries_on = false;
    }

    /// Runs one cycle. Without a correction time sync and time mode cannot extrapolate: the
    /// fallback takes their place. `elapsed` counts the own cycles since the previous call.
    pub fn update(
        &mut self,
        axis_in: &NcToPlcAxis,
        correction_time: Option<Seconds>,
        mode: ExtrapolateMode,
        fall_back: FallBackMode,
        elapsed: u32,
    ) -> ExtrapolateOutput {
        let corrections = CorrectionTimes {
            sync: correction_time,
            time: correction_time,
            observer: correction_time,
        };
        let set = set_of(axis_in);
        let known = KnownMotion::default();
        let moved = self.move_set_values(&set, corrections, known, mode, fall_back, elapsed);
        ExtrapolateOutput {
            axis: with_set(axis_in, &moved.set),
            state: moved.state,
            error: moved.error,
            diagnostic: moved.diagnostic,
        }
    }

    /// Runs one cycle for bare set values, with a correction time for each of the modes, and what is known of their motion
    /// besides.
    pub(super) fn move_set_values(
        &mut self,
        received: &Kinematics,
        corrections: CorrectionTimes,
        known: KnownMotion<'_>,
        mode: ExtrapolateMode,
        fall_back: FallBackMode,
        elapsed: u32,
    ) -> Moved {
        // The PT1 filter runs in every mode: a fallback must find it settled.
        let (position, velocity) = self
            .pt1
            .update(received.position, received.velocity, elapsed);
        let candidates = Candidates {
            received,
            filtered: SetValues { position, velocity },
            by_acceleration: self.parameters.use_acc_for_extrapolation,
            corrections,
            known,
        };
        let wished = candidates.of(mode);
        let error = wished.and_then(|aim| self.position_error(mode, &aim, received));
        // Both reasons end in the fallback, but only the first is an error.
        let (mode, aim) = match wished.filter(|_| error.is_none()) {
            Some(aim) => (mode, aim),
            None => {
                let mode = fall_back.into();
                let aim = candidates.of(mode);
                (mode, aim.unwrap_or(candidates.as_received()))
            }
        };
        let set = self.blended(mode, aim.set, &candidates, elapsed);
        Moved {
            set: Kinematics {
                position: set.position,
                velocity: set.velocity,
                acceleration: aim.acceleration,
            },
            state: mode,
            error,
            diagnostic: ExtrapolateDiagnostic {
                position_diff: received.position - set.position,
                velocity_diff: received.velocity - set.velocity,
            },
            is_interpolated: aim.is_interpolated,
            is_planned: aim.is_planned,
        }
    }

    fn position_error(
        &self,
        mode: ExtrapolateMode,
        aim: &Aim,
        received: &Kinematics,
    ) -> Option<SyncError> {
        let limit = self.parameters.max_position_diff;
        // The manual monitors the extrapolation; the lag of the PT1 filter is wanted and no error, and nothing is
        // guessed between two frames and by a plan.
        let extrapolates = !matches!(mode, ExtrapolateMode::Bypass | ExtrapolateMode::Pt1);
        if !extrapolates || aim.is_interpolated || aim.is_planned {
            return None;
        }
        let difference = (aim.set.position - received.position).abs();
        (limit > 0.0 && difference > limit).then_some(SyncError::MaxPositionDiffExceeded)
    }

    fn blended(
        &mut self,
        mode: ExtrapolateMode,
        aim: SetValues,
        candidates: &Candidates<'_>,
        elapsed: u32,
    ) -> SetValues {
        let passed = f64::from(elapsed) * self.task_cycle_time;
        // Advances first: the rest that a new blend takes over is that of this cycle, not of the last.
        self.blend.go_on(passed);
        let before = Kinematics {
            position: self.aim.position,
            velocity: self.aim.velocity,
            acceleration: candidates.acceleration(),
        };
        let standing = moved_on(&before, passed).into();
        let old = self.mode.replace(mode);
        let from = match old {
            Some(_) if core::mem::take(&mut self.carries_on) => Some(standing),
            // The old mode may have lost its correction: it continues from its last state.
            Some(old) if old != mode => Some(candidates.of(old).map_or(standing, |aim| aim.set)),
            _ => None,
        };
        if let Some(from) = from {
            // The rest of a blend is added to the new difference once. A difference of already blended values would
            // count it again with every change.
            let difference = from.position - aim.position + self.blend.rest();
            self.blend = Blend::starting(difference, self.parameters.blending_time.0);
        }
        self.carries_on = false;
        self.aim = aim;
        self.blend.over(aim)
    }
}

#[cfg(test)]
mod tests;
