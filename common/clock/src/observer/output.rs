//! The far time that is shown: continuous, strictly monotone, never in a hurry.

use crate::instant::{Instant, Local, Remote, Seconds, Span};
use crate::numbers::floored;

/// A point in far time, finer than a nanosecond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarTime {
    /// Whole nanoseconds.
    pub instant: Instant<Remote>,
    /// What lies beyond them, ns: 0 to below 1.
    pub fraction_ns: f64,
}

impl FarTime {
    /// How long after `earlier`; negative if before.
    #[must_use]
    pub fn since(&self, earlier: Instant<Remote>) -> Seconds {
        Seconds(((self.instant - earlier).as_nanos() as f64 + self.fraction_ns) * 1e-9)
    }

    /// The point `nanos` nanoseconds later.
    pub(crate) fn plus(self, nanos: f64) -> Self {
        let total = self.fraction_ns + nanos;
        let whole = floored(total);
        let fraction_ns = total - whole as f64;
        Self {
            instant: self.instant + Span::from_nanos(whole),
            // A tiny negative total rounds to a whole one.
            fraction_ns: if fraction_ns < 1.0 { fraction_ns } else { 0.0 },
        }
    }
}

/// How far the shown time may follow the estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Time constant of the approach, s.
    pub(super) pull_time: f64,
    /// Largest correction, s/s.
    pub(super) limit: f64,
}

/// The time shown last, and when.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    pub(super) at: Instant<Local>,
    pub(super) far: FarTime,
    /// The estimate lies this much later, s.
    pub(super) remaining: Seconds,
}

impl Shown {
    pub(super) const fn new(at: Instant<Local>, far: FarTime) -> Self {
        Self {
            at,
            far,
            remaining: Seconds::ZERO,
        }
    }

    /// Moves on to `at`, where the far clock alone would lead to `coasting`, towards `target`.
    pub(super) fn advance(
        &mut self,
        at: Instant<Local>,
        coasting: FarTime,
        target: FarTime,
        pace: Pace,
    ) {
        let passed = (at - self.at).as_nanos();
        if passed <= 0 {
            return;
        }
        let passed = passed as f64;
        let error = target.since(coasting.instant).0 * 1e9 - coasting.fraction_ns;
        let seconds = passed * 1e-9;
        let pull = error * (seconds / (seconds + pace.pull_time));
        let bound = passed * pace.limit;
        let correction = pull.clamp(-bound, bound);
        self.far = coasting.plus(correction);
        self.remaining = Seconds((error - correction) * 1e-9);
        self.at = at;
    }
}
