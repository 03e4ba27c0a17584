//! Branches of a program for a step that cannot be taken.

use super::outcome::{Outcome, Trouble};

/// The steps to continue with; without one, the program's default applies.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Branches {
    pub(super) aborted: Option<usize>,
    pub(super) failed: Option<usize>,
    pub(super) refused: Option<usize>,
    pub(super) rolled_back: Option<usize>,
    pub(super) timed_out: Option<usize>,
}

impl Branches {
    pub(super) const fn of(&self, trouble: Trouble) -> Option<usize> {
        match trouble {
            Trouble::Outcome(Outcome::Aborted) => self.aborted,
            Trouble::Outcome(Outcome::Failed) => self.failed,
            Trouble::Outcome(Outcome::Refused) => self.refused,
            Trouble::Outcome(Outcome::RolledBack) => self.rolled_back,
            Trouble::TimedOut => self.timed_out,
            Trouble::Outcome(Outcome::Done) | Trouble::TakenOver | Trouble::NothingUnderWay => None,
        }
    }
}
