//! The stop of a slave whose master has run back under a flying saw.

use coaxle_clock::Seconds;

use coaxle_curve::profile::Kinematics;
use coaxle_saw::RollbackStop;

/// The stop after a rollback, under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct RollingBack {
    stop: RollbackStop,
    since: Seconds,
}

impl RollingBack {
    /// `since` that long ago the master passed the coupling position.
    pub(super) const fn new(stop: RollbackStop, since: Seconds) -> Self {
        Self { stop, since }
    }

    pub(super) fn advance(&mut self, elapsed: Seconds) -> Kinematics {
        self.since = self.since + elapsed;
        self.stop.at(self.since)
    }

    pub(super) fn is_over(&self) -> bool {
        self.since >= self.stop.duration()
    }

    /// Where it ends, u.
    pub(super) fn end(&self) -> f64 {
        self.stop.end_position()
    }
}
