//! Presentation of an axis: its values shown as much later as its frames say.

use coaxle_clock::{CycleTime, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::{FrameHeader, PresentAfter};
use coaxle_remote::{
    AxisPresentation, FarCorrection, FrameDelay, PresentedNow, ShownChange, ShownLater,
};

use super::{Axis, AxisScan};

/// Presentation of an axis, and what its cycles showed.
#[derive(Debug)]
pub(super) struct Presented {
    presentation: AxisPresentation,
    /// True if the newest cycle showed values between two frames.
    pub(super) is_interpolated: bool,
    /// Own cycles in which the frame that was needed had not arrived.
    pub(super) extrapolated: u64,
}

impl Presented {
    pub(super) fn new(cycle: CycleTime) -> Self {
        Self {
            presentation: AxisPresentation::new(cycle.span()),
            is_interpolated: false,
            extrapolated: 0,
        }
    }

    /// Takes the set values of a frame, and the delay that it states.
    pub(super) fn take(&mut self, count: u64, set: &Kinematics, stated: Option<PresentAfter>) {
        self.presentation.take(count, set, delay_of(stated));
    }

    /// The frames and their delay, if they are shown later.
    pub(super) fn later(&self) -> Option<ShownLater<'_>> {
        self.presentation.later()
    }

    /// Notes how the newest cycle was calculated.
    pub(super) fn note(&mut self, is_interpolated: bool, is_predicted: bool, elapsed: u32) {
        self.is_interpolated = is_interpolated;
        if self.is_in_force() && is_predicted {
            self.extrapolated = self.extrapolated.saturating_add(elapsed.into());
        }
    }

    /// True if its frames are to be shown later.
    pub(super) fn is_in_force(&self) -> bool {
        self.presentation.is_in_force()
    }
}

fn delay_of(stated: Option<PresentAfter>) -> Span {
    stated.map_or(Span::ZERO, PresentAfter::span)
}

impl Axis {
    /// Forgets its frames: the next ones are unrelated to them.
    pub(super) fn forget_frames(&mut self) {
        if let Some(presented) = &mut self.presented {
            presented.presentation.clear();
        }
    }

    /// True if the frames that are shown have arrived, although they are shown later.
    pub(in super::super) fn covers(&self, correction: &FarCorrection) -> bool {
        let presented = self.presented.as_ref();
        presented.is_some_and(|presented| presented.presentation.covers(correction.of_clock()))
    }

    /// The time by which it is shown later, as its frames state; none where it is shown now whatever they state.
    pub(in super::super) fn delay(&self) -> Option<Span> {
        let by = self.presented.as_ref()?.presentation.delay();
        (by > Span::ZERO).then_some(by)
    }

    /// True unless it is shown now whatever its frames state.
    pub(in super::super) const fn may_be_later(&self) -> bool {
        self.presented.is_some()
    }

    /// Lag of the axis; none where it is shown now.
    pub(in super::super) fn lag(&self) -> Option<Seconds> {
        let presentation = &self.presented.as_ref()?.presentation;
        presentation.is_shown().then(|| presentation.lag())
    }

    /// Adopts the presentation delay of the newest frame. Between values shown later and values as received lies the
    /// whole delay, over which a blend would be a straight line.
    pub(super) fn follow_presentation(
        &mut self,
        header: &FrameHeader,
        correction: &FarCorrection,
        scan: &AxisScan<'_>,
    ) {
        let Some(presented) = &mut self.presented else {
            return;
        };
        let now = PresentedNow {
            passed: self.cycle_time * i64::from(scan.elapsed),
            age: correction.time(correction.mode),
            held: scan.held,
        };
        let stated = FrameDelay {
            count: header.count,
            delay: delay_of(header.present_after),
            cycle: header.cycle_time.span(),
        };
        // Another delay is a step, from which the axis is brought back as from every other.
        if presented.presentation.follow(&stated, &now) == ShownChange::LaterOrNow {
            self.begin_anew();
            self.rejoin();
        }
    }
}
