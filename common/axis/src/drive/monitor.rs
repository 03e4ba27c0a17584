//! The monitor of a following error.

use coaxle_clock::Seconds;

/// Watches that a following error is not beyond its window for too long.
#[derive(Clone, Copy, Debug)]
pub(super) struct FollowingErrorMonitor {
    /// Largest following error, u; 0: not watched.
    window: f64,
    /// How long it may be larger, s.
    time: f64,
    /// How long it has been, s.
    beyond: f64,
}

impl FollowingErrorMonitor {
    pub(super) const fn new(window: f64, time: f64) -> Self {
        Self {
            window,
            time,
            beyond: 0.0,
        }
    }

    pub(super) const fn forget(&mut self) {
        self.beyond = 0.0;
    }

    pub(super) fn is_beyond(&self, following_error: f64) -> bool {
        self.window > 0.0 && following_error.abs() > self.window
    }

    /// One cycle: whether that was too much for too long.
    pub(super) fn trips(&mut self, following_error: f64, elapsed: Seconds) -> bool {
        let beyond = self.is_beyond(following_error);
        self.beyond = if beyond { self.beyond + elapsed.0 } else { 0.0 };
        beyond && self.beyond > self.time
    }
}
