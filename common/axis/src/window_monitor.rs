//! A window that a distance may leave for a while.

use coaxle_clock::Seconds;

/// Monitors that a distance does not exceed its window for too long: a following error, or the
/// distance of an axis from its wanted position.
#[derive(Clone, Copy, Debug)]
pub struct WindowMonitor {
    /// Largest distance, u; 0: not monitored.
    window: f64,
    /// Time for which it may be exceeded, s.
    time: f64,
    /// Time for which it has been exceeded, s.
    beyond: f64,
}

impl WindowMonitor {
    /// Creates a monitor that trips when the distance has exceeded `window`, u, for longer than
    /// `time`, s; never with a window of 0.
    #[must_use]
    pub const fn new(window: f64, time: f64) -> Self {
        Self {
            window,
            time,
            beyond: 0.0,
        }
    }

    /// The largest distance, u; 0 if not monitored.
    #[must_use]
    pub const fn window(&self) -> f64 {
        self.window
    }

    /// Restarts: the window has not been exceeded.
    pub const fn forget(&mut self) {
        self.beyond = 0.0;
    }

    /// True if a distance exceeds the window.
    #[must_use]
    pub fn is_beyond(&self, distance: f64) -> bool {
        self.window > 0.0 && distance.abs() > self.window
    }

    /// Runs one cycle; returns true if the window has been exceeded for too long.
    pub fn trips(&mut self, distance: f64, elapsed: Seconds) -> bool {
        let beyond = self.is_beyond(distance);
        // Starts again from 0: single long cycles apart do not add up.
        self.beyond = if beyond { self.beyond + elapsed.0 } else { 0.0 };
        beyond && self.beyond > self.time
    }
}
