//! A window that something may leave for a while.

use coaxle_clock::Seconds;

/// Watches that a distance is not beyond its window for too long: a following error, or what limits have left
/// between an axis and where it should be.
#[derive(Clone, Copy, Debug)]
pub struct WindowMonitor {
    /// Largest distance, u; 0: not watched.
    window: f64,
    /// How long it may be larger, s.
    time: f64,
    /// How long it has been, s.
    beyond: f64,
}

impl WindowMonitor {
    /// Trips when the distance has been larger than `window`, u, for longer than `time`, s; never with a
    /// window of 0.
    #[must_use]
    pub const fn new(window: f64, time: f64) -> Self {
        Self {
            window,
            time,
            beyond: 0.0,
        }
    }

    /// The largest distance, u; 0 if none is watched.
    #[must_use]
    pub const fn window(&self) -> f64 {
        self.window
    }

    /// Begins anew: nothing has been beyond the window so far.
    pub const fn forget(&mut self) {
        self.beyond = 0.0;
    }

    /// Whether a distance is beyond the window.
    #[must_use]
    pub fn is_beyond(&self, distance: f64) -> bool {
        self.window > 0.0 && distance.abs() > self.window
    }

    /// One cycle: whether that was too much for too long.
    pub fn trips(&mut self, distance: f64, elapsed: Seconds) -> bool {
        let beyond = self.is_beyond(distance);
        self.beyond = if beyond { self.beyond + elapsed.0 } else { 0.0 };
        beyond && self.beyond > self.time
    }
}
