//! The axis's half of `FB_AxisSync`: set values moved in time by what the far clock says.

use coaxle_clock::time_sync::{SyncError, WrongParameter};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

use super::extrapolate::{AxisExtrapolate, ExtrapolateDiagnostic};
use super::far_sync::{FarCorrection, OnPositionError};
use super::parameters::{AxisSyncParameters, CheckedParameters, FilterState};

/// One axis of a far node: filter, blending and position error of its own, the clock shared.
#[derive(Clone, Debug)]
pub struct FarAxis {
    extrapolate: AxisExtrapolate,
    /// It is latched here; errors of the clock are the clock's.
    position_error: Option<SyncError>,
    automatic_re_init: bool,
}

/// What one cycle of a [`FarAxis`] gives.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarAxisOutput {
    /// The set values, corrected.
    pub set: Kinematics,
    /// The mode that made them.
    pub state: FilterState,
    /// Whether the far clock is known and corrected, and the axis where it says.
    pub synced: bool,
    /// The error of the clock or of the axis.
    pub error: Option<SyncError>,
    /// The correction that moved the set values; none where the mode needs none or has none.
    pub correction_time: Option<Seconds>,
    /// Received minus calculated.
    pub diagnostic: ExtrapolateDiagnostic,
    /// A position error was latched, and the axis starts up again with the next cycle.
    pub re_initialised: bool,
}

impl FarAxis {
    /// An axis at rest. `task_cycle_time` is the receiver's nominal cycle time.
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

    /// One cycle, with the set values of the same frame that the correction is for.
    pub fn update(
        &mut self,
        received: &Kinematics,
        correction: &FarCorrection,
        elapsed: u32,
    ) -> FarAxisOutput {
        let fall_back = correction.fall_back;
        let was_latched = self.position_error.is_some();
        let mode = match correction.on_position_error {
            OnPositionError::FallBack if was_latched => fall_back.into(),
            _ => correction.mode,
        };
        let times = correction.times;
        let moved = self
            .extrapolate
            .move_set_values(received, times, mode, fall_back, elapsed);
        let position_error = match correction.on_position_error {
            OnPositionError::Forget => moved.error,
            OnPositionError::FallBack | OnPositionError::KeepMode => {
                self.position_error = self.position_error.or(moved.error);
                self.position_error
            }
        };
        let error = correction.error.or(position_error);
        let re_initialised = was_latched && self.automatic_re_init;
        if re_initialised {
            self.position_error = None;
        }
        FarAxisOutput {
            set: moved.set,
            state: moved.state,
            synced: correction.synced && error.is_none(),
            error,
            correction_time: correction.time(moved.state),
            diagnostic: moved.diagnostic,
            re_initialised,
        }
    }

    /// Its clock starts anew: no error is latched any more, and the set values go on from where they are,
    /// blended into what the clock says next.
    pub const fn re_initialise(&mut self) {
        self.position_error = None;
        self.extrapolate.carry_on();
    }

    /// The set values of the next cycle go on from where they are, whatever has changed by then: the
    /// difference is blended over `blending_time`.
    pub const fn carry_on(&mut self) {
        self.extrapolate.carry_on();
    }

    /// Whether a change of mode is being blended over.
    #[must_use]
    pub fn is_blending(&self) -> bool {
        self.extrapolate.is_blending()
    }

    /// Where the set values were says nothing of where they are next: no mode is blended from, and the filter
    /// has settled there. An error that is latched stays.
    pub fn begin_anew(&mut self) {
        self.extrapolate.begin_anew();
    }

    /// Changes the parameters while running; the set values go on from where they are.
    pub fn set_parameters(&mut self, parameters: &CheckedParameters) {
        self.extrapolate
            .set_parameters(&parameters.whole.extrapolate);
        self.automatic_re_init = parameters.whole.time_sync.automatic_re_init;
    }

    /// At rest again, as it was started: nothing is blended from, no error is latched.
    pub fn restart(&mut self) {
        self.extrapolate.restart();
        self.position_error = None;
    }
}
