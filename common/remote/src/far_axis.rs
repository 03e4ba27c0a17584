//! The axis's half of `FB_AxisSync`: set values moved in time by the far clock's correction.

use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

use super::extrapolate::{AxisExtrapolate, ExtrapolateDiagnostic};
use super::far_sync::{FarCorrection, OnPositionError};
use super::parameters::{AxisSyncParameters, CheckedParameters, FilterState};
use super::planned::KnownMotion;

/// An axis of a far node: filter, blending and position error of its own, the clock shared.
#[derive(Clone, Debug)]
pub struct FarAxis {
    extrapolate: AxisExtrapolate,
    /// Latched position error; errors of the clock belong to the clock.
    position_error: Option<SyncError>,
    automatic_re_init: bool,
}

/// Output of one cycle of a [`FarAxis`].
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarAxisOutput {
    /// The set values, corrected.
    pub set: Kinematics,
    /// Mode that calculated them.
    pub state: FilterState,
    /// True if the far clock is known and corrected, and the axis has no position error.
    pub synced: bool,
    /// The error of the clock or of the axis.
    pub error: Option<SyncError>,
    /// Correction that moved the set values; none if the mode needs none or has none.
    pub correction_time: Option<Seconds>,
    /// True if the set values lie between two frames that are shown later; otherwise they are planned, a prediction, or
    /// as received.
    pub is_interpolated: bool,
    /// True if the set values are those of a plan.
    pub is_planned: bool,
    /// Received minus calculated.
    pub diagnostic: ExtrapolateDiagnostic,
    /// A position error was latched, and the axis restarts with the next cycle.
    pub re_initialised: bool,
}

impl FarAxis {
    /// Creates an axis at rest. `task_cycle_time` is the receiver's nominal cycle time.
    ///
    /// # Errors
    /// [`WrongParameter`] (0x4b56) names the parameter that is out of its range.
    pub fn start(
        task_cycle_time: Span,
        parameters: &AxisSyncParameters,
    ) -> Result<Self, WrongParameter> {
        Ok(Self {
            extrapolate: AxisExtrapolate::start(task_cycle_time, parameters.extrapolate)?,
            position_error: None,
            automatic_re_init: parameters.time_sync.automatic_re_init,
        })
    }

    /// Runs one cycle, with the set values of the frame that the correction is for. The modes with a correction show them
    /// later, or by a plan, if `known` has one; bypass and PT1 show the set values as received.
    pub fn update(
        &mut self,
        received: &Kinematics,
        correction: &FarCorrection,
        known: KnownMotion<'_>,
        elapsed: u32,
    ) -> FarAxisOutput {
        let fall_back = correction.fall_back;
        let was_latched = self.position_error.is_some();
        // Read before this cycle's error: an error is seen by its own cycle's fallback inside the extrapolation.
        let mode = match correction.on_position_error {
            OnPositionError::FallBack if was_latched => fall_back.into(),
            _ => correction.mode,
        };
        let times = correction.times;
        let moved = self
            .extrapolate
            .move_set_values(received, times, known, mode, fall_back, elapsed);
        let position_error = match correction.on_position_error {
            OnPositionError::Forget => moved.error,
            OnPositionError::FallBack | OnPositionError::KeepMode => {
                self.position_error = self.position_error.or(moved.error);
                self.position_error
            }
        };
        // The clock's error comes first: a position error mostly follows from it.
        let error = correction.error.or(position_error);
        // An error is reported for at least one whole cycle before the restart, so that no scan misses it.
        let re_initialised = was_latched && self.automatic_re_init;
        if re_initialised {
            self.position_error = None;
        }
        FarAxisOutput {
            set: moved.set,
            state: moved.state,
            synced: correction.synced && error.is_none(),
            error,
            // That of the mode actually used, which differs from the selected one in the fallback.
            correction_time: shown(correction.time(moved.state), known),
            is_interpolated: moved.is_interpolated,
            is_planned: moved.is_planned,
            diagnostic: moved.diagnostic,
            re_initialised,
        }
    }

    /// Restarts with its clock: clears a latched error, and continues the set values from their
    /// current state, blended into those of the clock.
    pub const fn re_initialise(&mut self) {
        self.position_error = None;
        self.extrapolate.carry_on();
    }

    /// Continues the set values of the next cycle from their current state: the difference of all
    /// changes is blended over `blending_time`.
    pub const fn carry_on(&mut self) {
        self.extrapolate.carry_on();
    }

    /// True while a change of mode is being blended.
    #[must_use]
    pub fn is_blending(&self) -> bool {
        self.extrapolate.is_blending()
    }

    /// Restarts at set values unrelated to the previous ones: no mode is blended from, and the
    /// filter has settled there. A latched error stays.
    pub fn begin_anew(&mut self) {
        self.extrapolate.begin_anew();
    }

    /// Returns this cycle again, as after a [restart](Self::begin_anew): without a blend from the previous mode.
    pub fn without_blend(
        &mut self,
        received: &Kinematics,
        correction: &FarCorrection,
        known: KnownMotion<'_>,
        moved: &FarAxisOutput,
        elapsed: u32,
    ) -> FarAxisOutput {
        // The cycle is calculated a second time, and must not find the state that its first pass left.
        self.begin_anew();
        let (times, fall_back) = (correction.times, correction.fall_back);
        let mode = moved.state;
        let again =
            (self.extrapolate).move_set_values(received, times, known, mode, fall_back, elapsed);
        FarAxisOutput {
            set: again.set,
            diagnostic: again.diagnostic,
            ..*moved
        }
    }

    /// Changes the parameters while running; the set values continue from their current state.
    pub fn set_parameters(&mut self, parameters: &CheckedParameters) {
        self.extrapolate
            .set_parameters(&parameters.whole.extrapolate);
        self.automatic_re_init = parameters.whole.time_sync.automatic_re_init;
    }

    /// Returns to the initial state at rest: no blend, no latched error.
    pub fn restart(&mut self) {
        self.extrapolate.restart();
        self.position_error = None;
    }
}

/// Correction up to the instant that is shown.
fn shown(correction: Option<Seconds>, known: KnownMotion<'_>) -> Option<Seconds> {
    let by = known.later.map_or(Seconds::ZERO, |later| later.by);
    correction.map(|correction| correction - by)
}
