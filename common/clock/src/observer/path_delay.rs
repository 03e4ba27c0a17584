//! The configured or measured path delay, on its way into the far time.

use crate::instant::Span;
use crate::numbers::rounded;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of a delay on its way into the far time.
    PathDelayTuning {
        /// Time constant of the approach, s.
        pull_time: f64 = 0.5,
        /// Greatest rate at which a new delay is taken over, s/s.
        // At 500 mm/s the slave then moves by 0.5 mm/s faster or slower.
        slew_limit: f64 = 1e-3,
    }
}

/// A delay, and how much of it the far time contains already.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PathDelay {
    set: Span,
    /// ns
    shown: f64,
}

impl PathDelay {
    pub(super) const fn set(&mut self, delay: Span) {
        self.set = delay;
    }

    /// Delay that was set.
    pub(super) const fn set_to(&self) -> Span {
        self.set
    }

    /// Shifts both at once.
    pub(super) fn shift(&mut self, by_ns: f64) {
        self.set += Span::from_nanos(rounded(by_ns));
        self.shown += by_ns;
    }

    /// Delay that the far time contains, ns.
    pub(super) const fn shown(&self) -> f64 {
        self.shown
    }

    /// Delay that the far time still lacks, ns.
    pub(super) fn missing(&self) -> f64 {
        self.set.as_nanos() as f64 - self.shown
    }

    /// Takes the whole delay over.
    pub(super) const fn jump(&mut self) {
        self.shown = self.set.as_nanos() as f64;
    }

    /// Advances by `passed_ns` of local time, ns. Returns the gain of the far time, ns.
    pub(super) fn advance(&mut self, passed_ns: f64) -> f64 {
        let passed = passed_ns.max(0.0);
        let seconds = passed * 1e-9;
        let bound = passed * TUNING.slew_limit;
        // Implicit low-pass, as of the shown time: no cycle is too long for it.
        let gain = (self.missing() * (seconds / (seconds + TUNING.pull_time))).clamp(-bound, bound);
        self.shown += gain;
        gain
    }
}
