//! The instant at which a planned axis comes to a position.
//!
//! A cam switch or a registration that has to act a dead time ahead needs the instant of a position, and not the position
//! of an instant. On each piece the position is a cubic, which is monotone between the zeros of its velocity: so no
//! passage is missed, and each is found to the last bits.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::law::Roots;
use coaxle_curve::law::polynomial::Polynomial;
use coaxle_curve::law::roots::roots_between_extremes;
use coaxle_curve::profile::Kinematics;

use super::{MotionPiece, MotionPlan};
use crate::modulo::Modulo;
use crate::travel_direction::TravelDirection;

/// Precision of positions, relative to the terms that they are sums of: that to which a plan has to continue itself. An axis
/// that turns or halts as near to a position has reached it.
const PRECISION: f64 = 1e-9;

/// Position to which an axis comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AwaitedPosition {
    /// The position, u.
    pub position: f64,
    /// Period in which it repeats; none: that position alone.
    pub modulo: Option<Modulo>,
    /// Direction in which the axis comes to it; none: any.
    pub direction: Option<TravelDirection>,
}

/// Arrival of an axis at a [`AwaitedPosition`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedPassage {
    /// The instant, to the nanosecond.
    pub at: Span,
    /// State of the axis then.
    pub state: Kinematics,
}

impl MotionPlan {
    /// Returns the first arrival at a target from an instant on (CODESYS `SMC_GetTravelTime`); none within the promise, or
    /// if the plan begins after that instant.
    ///
    /// An axis that is there at that instant has arrived if it moves on in the direction of the target, or if that is any.
    /// An axis that halts or turns there has arrived, and does not arrive again as it leaves.
    #[doc(alias = "SMC_GetTravelTime")]
    #[must_use]
    pub fn passage(&self, from: Span, target: &AwaitedPosition) -> Option<PlannedPassage> {
        first_passage(self.pieces(), from, self.promised_until, target)
    }
}

/// Returns the first arrival at a target between two instants; none before a gap, as for [`MotionPlan::passage`].
#[must_use]
pub fn first_passage(
    pieces: &[MotionPiece],
    from: Span,
    until: Span,
    target: &AwaitedPosition,
) -> Option<PlannedPassage> {
    if from > until || !target.position.is_finite() {
        return None;
    }
    let first = pieces.partition_point(|piece| piece.start <= from);
    let mut known = from;
    for piece in &pieces[first.saturating_sub(1)..] {
        if piece.start > known || piece.end() < known || known > until {
            return None;
        }
        let end = piece.end().min(until);
        let passage = PieceSearch::new(piece, target).first_between(known, end, known == from);
        if passage.is_some() {
            return passage;
        }
        known = piece.end();
    }
    None
}

/// Search on one piece.
struct PieceSearch<'a> {
    piece: &'a MotionPiece,
    target: &'a AwaitedPosition,
    /// Way from the begin of the piece by the time, s.
    way: Polynomial<4>,
}

/// An instant of a piece, s after its begin, and the position there.
#[derive(Clone, Copy)]
struct PieceInstant {
    t: f64,
    position: f64,
}

impl<'a> PieceSearch<'a> {
    fn new(piece: &'a MotionPiece, target: &'a AwaitedPosition) -> Self {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = piece.from;
        Self {
            piece,
            target,
            way: Polynomial([0.0, velocity, acceleration / 2.0, piece.jerk / 6.0]),
        }
    }

    /// Returns the first arrival; an axis that is at the target at `begin` arrives there if that `is_first` of all instants.
    fn first_between(&self, begin: Span, end: Span, is_first: bool) -> Option<PlannedPassage> {
        let [t, end] = [begin, end].map(|at| (at - self.piece.start).as_secs_f64());
        let turns: Roots = self.way.derivative().roots_in(t, end);
        let mut left = self.place(t);
        let mut is_first = is_first;
        for &t in turns.iter().chain(core::iter::once(&end)) {
            let right = self.place(t);
            if let Some(t) = self.on_the_way(left, right, is_first) {
                return Some(self.passage(t));
            }
            // A turn at the first instant leaves the axis there.
            is_first &= left.t == right.t;
            left = right;
        }
        None
    }

    /// Time of the first arrival between two turns.
    fn on_the_way(&self, left: PieceInstant, right: PieceInstant, is_first: bool) -> Option<f64> {
        let tolerance = self.tolerance(right.t);
        let moves = match right.position - left.position {
            way if way > 0.0 => Some(TravelDirection::Forward),
            way if way < 0.0 => Some(TravelDirection::Backward),
            _ => None,
        };
        let wanted = self.target.direction;
        if wanted.is_some() && wanted != moves {
            return None;
        }
        let direction = moves.unwrap_or_default();
        let sign = direction.sign();
        // At the begin of a later stretch it is where the stretch before has led it.
        let margin = if is_first { -tolerance } else { tolerance };
        let next = self.next(left.position + sign * margin, direction)?;
        // Distances in the direction of the motion.
        let [behind, beyond] = [left, right].map(|place| sign * (next - place.position));
        if behind <= tolerance {
            return Some(left.t);
        }
        if beyond > tolerance {
            return None;
        }
        if beyond >= -tolerance {
            return Some(right.t);
        }
        let mut less = self.way;
        less.0[0] = self.piece.from.position - next;
        let roots = roots_between_extremes(&less, &[], left.t, right.t);
        Some(roots.first().map_or(right.t, |t| *t))
    }

    /// Position of the target that comes next beyond a place.
    fn next(&self, here: f64, direction: TravelDirection) -> Option<f64> {
        let position = self.target.position;
        match self.target.modulo {
            Some(modulo) => Some(modulo.next(position, here, direction)),
            None => (direction.sign() * (position - here) > 0.0).then_some(position),
        }
    }

    fn place(&self, t: f64) -> PieceInstant {
        PieceInstant {
            t,
            position: self.piece.from.position + self.way.value(t),
        }
    }

    /// Precision of a position up to a time.
    fn tolerance(&self, t: f64) -> f64 {
        let [_, velocity, acceleration, jerk] = self.way.0.map(f64::abs);
        let way = ((jerk * t + acceleration) * t + velocity) * t;
        PRECISION * (self.piece.from.position.abs() + way)
    }

    fn passage(&self, t: f64) -> PlannedPassage {
        let piece = self.piece;
        PlannedPassage {
            at: piece.start + Seconds(t).to_span(),
            state: piece.from.after(t, piece.jerk),
        }
    }
}

#[cfg(test)]
mod tests;
