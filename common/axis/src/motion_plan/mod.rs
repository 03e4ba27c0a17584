//! A motion promised ahead: the pieces of constant jerk that a generated axis will move along.
//!
//! A node that generates the motion of an axis knows it before it happens. A [`MotionPlan`] states it, and the instant
//! until which the node will not deviate from it. A follower of the axis evaluates the plan where it has no sample of
//! the motion. Instants are times after the ideal start of cycle 0 of the node's run, in its own clock: those of its
//! frames are count · cycle time.

mod check;
mod fault;
mod passage;

#[cfg(test)]
mod tests;

use coaxle_clock::{Seconds, Span};
use coaxle_curve::profile::{Kinematics, Limits, Profile};

pub use fault::{InvalidPlan, PlanFault};
pub use passage::{AwaitedPosition, PlannedPassage, first_passage};

/// Greatest number of pieces of a plan.
// A move from standstill to standstill has seven, and one more to stand.
pub const MOST_PIECES: usize = 8;

/// A piece of a planned motion, with constant jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionPiece {
    /// Its begin.
    pub start: Span,
    /// Its duration, above zero.
    pub duration: Span,
    /// State at its begin.
    pub from: Kinematics,
    /// Jerk, u/s³.
    pub jerk: f64,
}

/// Phases shorter than this are steps of the acceleration: of limits of the jerk that mean "none".
// Far above the nanosecond by which a piece is longer or shorter than its phase.
const STEP: Span = Span::from_micros(1);

impl MotionPiece {
    /// Returns the piece of a profile that begins at `began`, from one whole nanosecond to another between which its jerk is
    /// constant, but for the one at which a phase begins.
    #[must_use]
    pub fn of_profile(profile: &Profile, began: Span, start: Span, end: Span) -> Self {
        let at = |instant: Span| profile.at((instant - began).into());
        let (from, duration) = (at(start), end - start);
        let jerk = match duration < STEP {
            // On average: its phase may last for a part of the nanosecond only.
            true => (at(end).acceleration - from.acceleration) / duration.as_secs_f64(),
            // In its middle: at its begin rounding may find the phase before.
            false => profile.jerk_at((start - began + duration / 2).into()),
        };
        Self {
            start,
            duration,
            from,
            jerk,
        }
    }

    /// Returns the instant at which it ends.
    #[must_use]
    pub fn end(&self) -> Span {
        self.start + self.duration
    }

    /// Returns the state `after` an instant, of which the piece need not hold.
    #[must_use]
    #[inline]
    pub fn at(&self, instant: Span, after: Seconds) -> Kinematics {
        // In whole nanoseconds first: a run of years leaves a double a microsecond.
        let t = (instant - self.start).as_secs_f64() + after.0;
        self.from.after(t, self.jerk)
    }

    /// Returns the greatest velocity and the greatest acceleration in it, without signs.
    #[must_use]
    pub fn peaks(&self) -> (f64, f64) {
        let Self { from, jerk, .. } = *self;
        let end = self.at(self.end(), Seconds::ZERO);
        // The velocity turns where the acceleration is zero.
        let turn = -from.acceleration / jerk;
        let turns = turn > 0.0 && turn < self.duration.as_secs_f64();
        let at_turn = match turns {
            true => from.after(turn, jerk).velocity,
            false => end.velocity,
        };
        let velocity = from.velocity.abs().max(end.velocity.abs());
        (
            velocity.max(at_turn.abs()),
            from.acceleration.abs().max(end.acceleration.abs()),
        )
    }
}

/// A planned motion: up to [`MOST_PIECES`] pieces one after the other, smooth and within the limits of its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionPlan {
    pieces: [MotionPiece; MOST_PIECES],
    len: usize,
    promised_until: Span,
    limits: Limits,
}

impl MotionPlan {
    /// Creates the plan of an axis with these limits, which will not deviate from it before `promised_until`.
    ///
    /// # Errors
    /// [`InvalidPlan`], the first fault of the first faulty piece: a piece that is not finite, too short, out of order,
    /// or beyond the limits; a gap or a jump between two; no piece, too many, or a promise beyond them.
    pub fn new(
        pieces: &[MotionPiece],
        promised_until: Span,
        limits: &Limits,
    ) -> Result<Self, InvalidPlan> {
        check::plan(pieces, promised_until, limits)?;
        let mut plan = Self {
            pieces: [MotionPiece::default(); MOST_PIECES],
            len: pieces.len(),
            promised_until,
            limits: *limits,
        };
        plan.pieces[..pieces.len()].copy_from_slice(pieces);
        Ok(plan)
    }

    /// Returns its pieces: at least one.
    #[must_use]
    pub fn pieces(&self) -> &[MotionPiece] {
        &self.pieces[..self.len]
    }

    /// Returns the begin of its first piece.
    #[must_use]
    pub const fn start(&self) -> Span {
        self.pieces[0].start
    }

    /// Returns the instant until which the axis will not deviate from it.
    #[must_use]
    pub const fn promised_until(&self) -> Span {
        self.promised_until
    }

    /// Returns the limits of the axis.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Returns the state `after` an instant; none before the first piece, and beyond the promise.
    #[must_use]
    pub fn at(&self, instant: Span, after: Seconds) -> Option<Kinematics> {
        let wanted = instant + after.to_span();
        if wanted > self.promised_until {
            return None;
        }
        piece_at(self.pieces(), wanted).map(|piece| piece.at(instant, after))
    }
}

/// Returns the piece that an instant is in, of pieces in their order, which may leave gaps. An end belongs to the next one,
/// if that begins there.
#[must_use]
#[inline]
pub fn piece_at(pieces: &[MotionPiece], instant: Span) -> Option<&MotionPiece> {
    let next = pieces.partition_point(|piece| piece.start <= instant);
    let piece = pieces[..next].last()?;
    (instant <= piece.end()).then_some(piece)
}
