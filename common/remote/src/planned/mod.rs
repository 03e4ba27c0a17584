//! A far axis by the plan of its node: where a sample is missing, the motion that the node has promised.
//!
//! Plans come several times a second, each with the motion of the next moments ([`MotionPlan`]). A
//! [`PlannedMotion`] joins them, and checks them against each other and against the samples of the axis as these come. A
//! plan is used only after a sample has confirmed it, and no longer than its promise; one that is contradicted is not used
//! at all. So whatever a node promises, the worst is that the axis is where it would be without a plan.
//!
//! Not in the manual, which extrapolates.
//!
//! [`MotionPlan`]: coaxle_axis::motion_plan::MotionPlan

#[cfg(test)]
mod tests;

use coaxle_axis::motion_plan::{
    AwaitedPosition, MotionPiece, PlanFault, PlannedPassage, first_passage, piece_at,
};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Kinematics;

use super::presented::ShownLater;

/// Number of pieces kept.
// Three plans of the longest kind: the oldest one of them ends before its pieces are pushed out. 1.2 kB an axis.
const KEPT: usize = 24;
/// Largest difference of a sample from the plan: by the rounding of positions, and the duration of a change of the jerk
/// within a nanosecond, far above both …
const ROUNDING: f64 = 1e-9;
/// … and by the time, s, that a node may take between the calculation of a plan and of a frame.
const TIMING: f64 = 1e-6;

/// The promised motion of an axis in one run of its node.
#[derive(Clone, Debug)]
pub struct PlannedMotion {
    pieces: [MotionPiece; KEPT],
    len: usize,
    promised_until: Span,
    /// Cycle of the newest plan.
    count: u64,
    /// True if a sample has confirmed it since the last contradiction.
    is_confirmed: bool,
}

/// A plan as it arrives: its pieces, at least one, are those of a valid plan.
#[derive(Clone, Copy, Debug)]
pub struct ReceivedPlan<'a> {
    /// The sender's cycle count when it made the plan.
    pub count: u64,
    /// Its pieces.
    pub pieces: &'a [MotionPiece],
    /// The instant until which the axis will not deviate from it.
    pub promised_until: Span,
}

impl Default for PlannedMotion {
    fn default() -> Self {
        Self {
            pieces: [MotionPiece::default(); KEPT],
            len: 0,
            promised_until: Span::ZERO,
            count: 0,
            is_confirmed: false,
        }
    }
}

impl PlannedMotion {
    /// Forgets all plans: the next ones are unrelated to them.
    pub const fn clear(&mut self) {
        self.len = 0;
        self.is_confirmed = false;
    }

    /// Takes a plan; one that is older than the newest is left out. A contradiction to an earlier promise ends the use of
    /// both until a sample shows which of them is right.
    ///
    /// # Errors
    /// [`PlanFault::PromiseMovedBack`] and [`PlanFault::PromiseBroken`].
    pub fn take(&mut self, plan: &ReceivedPlan<'_>) -> Result<(), PlanFault> {
        let Some(first) = plan.pieces.first() else {
            return Err(PlanFault::NoPieces);
        };
        let mut outcome = Ok(());
        if self.len > 0 {
            if plan.count <= self.count {
                return Ok(());
            }
            if plan.promised_until < self.promised_until {
                return Err(PlanFault::PromiseMovedBack);
            }
            if self.is_broken_by(plan) {
                self.clear();
                outcome = Err(PlanFault::PromiseBroken);
            }
        }
        self.cut(first.start);
        self.append(plan.pieces);
        self.promised_until = plan.promised_until;
        self.count = plan.count;
        outcome
    }

    /// Takes a sample of the axis at an instant. A contradiction ends the use of all plans so far.
    ///
    /// # Errors
    /// [`PlanFault::Contradicted`].
    pub fn check(&mut self, instant: Span, sample: &Kinematics) -> Result<(), PlanFault> {
        let Some(piece) = self.promised(instant) else {
            return Ok(());
        };
        if is_beside(piece, instant, sample) {
            self.clear();
            return Err(PlanFault::Contradicted);
        }
        self.is_confirmed = true;
        Ok(())
    }

    /// Returns the state `after` an instant; none where nothing is promised or confirmed.
    #[must_use]
    pub fn at(&self, instant: Span, after: Seconds) -> Option<Kinematics> {
        if !self.is_confirmed {
            return None;
        }
        let piece = self.promised(instant + after.to_span())?;
        Some(piece.at(instant, after))
    }

    /// True if the state `after` an instant is known.
    #[must_use]
    pub fn reaches(&self, instant: Span, after: Seconds) -> bool {
        self.is_confirmed && self.promised(instant + after.to_span()).is_some()
    }

    /// Returns the first arrival at a position between two instants; none where nothing is promised or confirmed.
    #[must_use]
    pub fn passage(
        &self,
        from: Span,
        until: Span,
        target: &AwaitedPosition,
    ) -> Option<PlannedPassage> {
        let until = until.min(self.known_until()?);
        first_passage(self.pieces(), from, until, target)
    }

    /// Returns the instant until which the motion is known; none if none is.
    #[must_use]
    pub fn known_until(&self) -> Option<Span> {
        (self.is_confirmed && self.len > 0).then_some(self.promised_until)
    }

    fn pieces(&self) -> &[MotionPiece] {
        &self.pieces[..self.len]
    }

    /// The piece of an instant, if it is within the promise.
    fn promised(&self, instant: Span) -> Option<&MotionPiece> {
        match instant <= self.promised_until {
            true => piece_at(self.pieces(), instant),
            false => None,
        }
    }

    /// True if a plan deviates from the earlier promise where both are known.
    fn is_broken_by(&self, plan: &ReceivedPlan<'_>) -> bool {
        // Cubics that agree at their joints, and at the ends, agree: deviations between are as small as their limits let
        // them be, and the samples are checked as well.
        let joints = plan.pieces.iter().map(|piece| piece.start);
        joints.chain([self.promised_until]).any(|instant| {
            let both = self.promised(instant).zip(piece_at(plan.pieces, instant));
            both.is_some_and(|(old, new)| is_beside(old, instant, &new.at(instant, Seconds::ZERO)))
        })
    }

    /// Ends the pieces at an instant, and at the promise: what follows was an intention.
    fn cut(&mut self, instant: Span) {
        let end = instant.min(self.promised_until);
        while let Some(last) = self.pieces[..self.len].last_mut() {
            if last.start < end {
                last.duration = last.duration.min(end - last.start);
                return;
            }
            self.len -= 1;
        }
    }

    /// Appends pieces; the oldest ones make room.
    fn append(&mut self, new: &[MotionPiece]) {
        // No plan is longer than what is kept.
        let new = &new[..new.len().min(KEPT)];
        let surplus = (self.len + new.len()).saturating_sub(KEPT);
        self.pieces.copy_within(surplus..self.len, 0);
        self.len -= surplus;
        self.pieces[self.len..self.len + new.len()].copy_from_slice(new);
        self.len += new.len();
    }
}

/// True if a state at an instant is none of a piece.
fn is_beside(piece: &MotionPiece, instant: Span, state: &Kinematics) -> bool {
    let planned = piece.at(instant, Seconds::ZERO);
    let passed = (instant - piece.start).as_secs_f64();
    // Of the terms that the position is a sum of.
    let terms = piece.from.position.abs() + piece.from.velocity.abs() * passed;
    let scale = terms.max(state.position.abs());
    let most = ROUNDING * scale + planned.velocity.abs() * TIMING;
    // Of NaN, too.
    let off = (state.position - planned.position).abs();
    off.is_nan() || off > most
}

/// Time for which the promise has to reach the instant shown without a break before the plan is used: several renewals.
// Where a lead is hardly longer than the way, each plan reaches it for a part of the time, and the axis would change between plan
// and prediction: `presented/now` was off by 2.9 mm instead of 2.3, and was brought back 20 times.
const COVERED_NS: u32 = 1_000_000_000;

/// Time for which the promises of a node have reached the instant shown without a break, ns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PlanCoverage(u32);

impl PlanCoverage {
    /// Returns it a cycle later, `passed` after the one before: `reaches` is true if the promise reaches the instant shown.
    #[must_use]
    pub fn after(self, passed: Span, reaches: bool) -> Self {
        let passed = u32::try_from(passed.as_nanos()).unwrap_or(u32::MAX);
        match reaches {
            true => Self(self.0.saturating_add(passed).min(COVERED_NS)),
            false => Self::default(),
        }
    }

    /// True if the plan is to be used.
    #[must_use]
    pub const fn suffices(self) -> bool {
        self.0 >= COVERED_NS
    }
}

/// What is known of the motion of an axis besides its newest frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownMotion<'a> {
    /// The frames, if they are shown later.
    pub later: Option<ShownLater<'a>>,
    /// The plan, if there is one.
    pub planned: Option<PlannedAhead<'a>>,
}

/// Planned motion of an axis in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct PlannedAhead<'a> {
    /// The motion.
    pub motion: &'a PlannedMotion,
    /// Instant of the newest frame.
    pub newest: Span,
}

impl PlannedAhead<'_> {
    /// Returns the state `age` after the newest frame; none where nothing is promised.
    pub(crate) fn at(&self, age: f64) -> Option<Kinematics> {
        self.motion.at(self.newest, Seconds(age))
    }
}
