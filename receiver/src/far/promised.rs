//! The motion that a far node has promised for an axis, as seen from the instant shown: for those who act a dead time ahead.

use coaxle_axis::motion_plan::AwaitedPosition;
use coaxle_clock::Span;
use coaxle_remote::PlannedMotion;

use super::FarNode;

/// Instants of a far node's run that the last two cycles showed.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownInstants {
    before: Span,
    now: Span,
}

impl ShownInstants {
    /// Those of a cycle that shows `now`.
    pub(super) fn after(last: Option<Self>, now: Span) -> Self {
        // An instant that jumps back, to an axis that is shown later than before, makes nothing happen again.
        let before = last.map_or(now, |last| last.now.min(now));
        Self { before, now }
    }

    /// That of the newest cycle.
    pub(super) const fn now(&self) -> Span {
        self.now
    }
}

/// Promised motion of an axis, from the instant shown on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PromisedMotion<'a> {
    motion: &'a PlannedMotion,
    shown: ShownInstants,
}

impl PromisedMotion<'_> {
    /// True if the axis comes to a position within a time from now on, or has come to it since the cycle before: then no
    /// arrival is missed, however short the time is.
    pub(crate) fn comes_to(&self, position: &AwaitedPosition, within: Span) -> bool {
        let ShownInstants { before, now } = self.shown;
        let passage = self.motion.passage(before, now + within, position);
        passage.is_some()
    }
}

impl FarNode {
    /// The promised motion of one of its axes; none without a promise.
    pub(crate) fn promised(&self, axis: usize) -> Option<PromisedMotion<'_>> {
        let plans = self.followed().plans.as_deref()?;
        Some(PromisedMotion {
            motion: plans.motion(axis)?,
            shown: self.axes.get(axis)?.shown_instants()?,
        })
    }
}
