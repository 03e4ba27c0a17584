//! The slave's path during a synchronisation: a few pieces, one after the other.

use coaxle_curve::law::Motion;

use super::demands::SlaveDemands;
use super::path_piece::PathPiece;

/// Three phases of jerk to a velocity, one at it, three to the synchronous one, and the rest.
const MAX_PIECES: usize = 8;

/// At least one piece, following each other without a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlavePath {
    first: PathPiece,
    rest: [PathPiece; MAX_PIECES - 1],
    len: usize,
}

impl SlavePath {
    /// Makes a path of one piece.
    pub(super) const fn of(first: PathPiece) -> Self {
        Self {
            first,
            // Copies as a filling: a path is copied into the cycle, where nothing is allocated.
            rest: [first; MAX_PIECES - 1],
            len: 0,
        }
    }

    /// Appends a piece; of two pieces, one without length is none.
    pub(super) fn then(mut self, piece: PathPiece) -> Self {
        // A piece without length has no derivatives: they are divided by it.
        if self.first.length == 0.0 {
            return Self::of(piece);
        }
        if piece.length != 0.0 && self.len < self.rest.len() {
            self.rest[self.len] = piece;
            self.len += 1;
        }
        self
    }

    pub(super) fn pieces(&self) -> impl DoubleEndedIterator<Item = &PathPiece> {
        core::iter::once(&self.first).chain(&self.rest[..self.len])
    }

    pub(super) fn first(&self) -> &PathPiece {
        &self.first
    }

    pub(super) fn last(&self) -> &PathPiece {
        match self.len {
            0 => &self.first,
            len => &self.rest[len - 1],
        }
    }

    /// True if all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.pieces().all(PathPiece::is_finite)
    }

    /// Returns the slave at a master position (or time). The first and the last piece continue beyond the
    /// ends.
    pub(super) fn at(&self, master: f64) -> Motion {
        // At a joint the earlier piece: both have the same motion there, but for the jerk.
        let piece = self.pieces().find(|piece| !piece.is_passed_by(master));
        piece.unwrap_or(self.last()).at(master)
    }

    /// Computes the demands on the slave.
    pub(super) fn demands(&self, master_velocity: f64) -> SlaveDemands {
        let first = self.first.demands(master_velocity);
        let rest = self.rest[..self.len].iter();
        rest.map(|piece| piece.demands(master_velocity))
            .fold(first, SlaveDemands::joined)
    }
}
