//! The pieces of the motions that are decided.

use coaxle_axis::motion_plan::{MOST_PIECES, MotionPiece, MotionPlan};
use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::Limits;

use super::active_motion::ActiveMotion;

/// Pieces of constant jerk from the present on, as many as a plan has.
pub(super) struct PlannedPieces {
    pieces: [MotionPiece; MOST_PIECES],
    len: usize,
    /// Begin of those that are of interest.
    now: Span,
    decided_until: Span,
}

impl PlannedPieces {
    /// Collects the pieces of motions, each of which ends where the next one begins. The first motion is in progress `now`.
    pub(super) fn of<'a>(
        motions: impl Iterator<Item = &'a ActiveMotion>,
        now: Span,
        decided_until: Span,
    ) -> Self {
        let mut collected = Self {
            pieces: [MotionPiece::default(); MOST_PIECES],
            len: 0,
            now,
            decided_until,
        };
        let mut motions = motions.peekable();
        while let Some(motion) = motions.next() {
            let next = motions.peek().map(|next| next.began);
            // A decision that leaves the motion as it is.
            if next != Some(motion.began) {
                collected.add(motion, next);
            }
        }
        collected
    }

    /// Returns the plan, whose instants are those since the start after `origin`; none without a piece.
    pub(super) fn plan(mut self, origin: Span, limits: &Limits) -> Option<MotionPlan> {
        let pieces = &mut self.pieces[..self.len];
        for piece in &mut *pieces {
            piece.start += origin;
        }
        let last = pieces.last()?;
        let promised_until = (origin + self.decided_until).min(last.end());
        MotionPlan::new(pieces, promised_until, limits).ok()
    }

    /// Adds the pieces of a motion up to the begin of the next one, if that is decided.
    fn add(&mut self, motion: &ActiveMotion, next: Option<Span>) {
        let profile = &motion.profile;
        let begin_of =
            |Seconds(s): Seconds| motion.began + Span::from_nanos((s * 1e9).ceil() as i64);
        let begins = profile.phase_begins().map(begin_of);
        let standing = begin_of(profile.duration());
        let mut start = None;
        for begin in begins.chain([standing]) {
            if let Some(start) = start.replace(begin) {
                self.push(motion, start, begin.min(next.unwrap_or(Span::MAX)));
            }
        }
        // Its final velocity has no end of its own.
        self.push(motion, standing, next.unwrap_or(self.decided_until));
    }

    /// Adds the piece of a motion between two instants, if there is anything in it.
    fn push(&mut self, motion: &ActiveMotion, start: Span, end: Span) {
        let is_of_interest = start < end && end > self.now && start < self.decided_until;
        if !is_of_interest || self.len == MOST_PIECES {
            return;
        }
        self.pieces[self.len] = MotionPiece::of_profile(&motion.profile, motion.began, start, end);
        self.len += 1;
    }
}
