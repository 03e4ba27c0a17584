//! The motion that a far node has promised for an axis, as seen from the instant shown: for those who act a dead time ahead.

use coaxle_axis::motion_plan::AwaitedPosition;
use coaxle_clock::Span;
use coaxle_remote::PlannedMotion;

/// Instants of a far node's run that the last two cycles showed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShownInstants {
    before: Span,
    now: Span,
}

impl ShownInstants {
    /// Instants of a cycle that shows `now`.
    pub(crate) fn after(last: Option<Self>, now: Span) -> Self {
        // An instant that jumps back, to an axis that is shown later than before, makes nothing happen again.
        let before = last.map_or(now, |last| last.now.min(now));
        Self { before, now }
    }

    /// Instant that the newest cycle showed.
    pub(crate) const fn now(&self) -> Span {
        self.now
    }
}

/// Promised motion of an axis, from the instant shown on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PromisedMotion<'a> {
    motion: &'a PlannedMotion,
    shown: ShownInstants,
}

impl<'a> PromisedMotion<'a> {
    /// Creates the promise of an axis that is shown at these instants.
    pub(crate) const fn new(motion: &'a PlannedMotion, shown: ShownInstants) -> Self {
        Self { motion, shown }
    }

    /// True if the axis comes to a position within a time from now on, or has come to it since the cycle before: then no
    /// arrival is missed, however short the time is.
    pub(crate) fn comes_to(&self, position: &AwaitedPosition, within: Span) -> bool {
        let ShownInstants { before, now } = self.shown;
        let passage = self.motion.passage(before, now + within, position);
        passage.is_some()
    }
}
