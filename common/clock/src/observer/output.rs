//! The far time that is shown: continuous, strictly monotone, never in a hurry.

use crate::instant::{Instant, Local, Remote, Seconds, Span};
use crate::numbers::floored;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the far time that is shown.
    ShownTuning {
        /// A distance that is not made up within this time at the usual limit is made up faster, s.
        // The limit is then what remains over this time, so that a jump of 26.5 ms takes 50 s instead of 265 s.
        made_up_within: f64 = 10.0,
        /// Rise of the limit per second, s/s².
        // An axis at 500 mm/s is accelerated by 0.5 mm/s².
        rise: f64 = 1e-3,
    }
}

/// A point in far time, finer than a nanosecond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarTime {
    /// Whole nanoseconds.
    pub instant: Instant<Remote>,
    /// Rest beyond them, ns: 0 to below 1.
    pub fraction_ns: f64,
}

impl FarTime {
    /// Time since `earlier`; negative if before.
    #[must_use]
    pub fn since(&self, earlier: Instant<Remote>) -> Seconds {
        Seconds(((self.instant - earlier).as_nanos() as f64 + self.fraction_ns) * 1e-9)
    }

    /// Adds `nanos` nanoseconds.
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

/// Limits of the shown time's approach to the estimate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Time constant of the approach, s.
    pub(super) pull_time: f64,
    /// Largest correction, s/s.
    pub(super) limit: f64,
    /// Largest correction of what would take too long at that limit, s/s.
    pub(super) catch_up: f64,
}

impl Pace {
    /// True if a distance takes too long at the usual limit.
    pub(super) fn is_too_slow_for(&self, distance: Seconds) -> bool {
        distance.0.abs() > self.limit * TUNING.made_up_within
    }
}

/// The time shown last, and when.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    pub(super) at: Instant<Local>,
    pub(super) far: FarTime,
    /// The estimate lies this much later, s.
    pub(super) remaining: Seconds,
    /// Raise of the limit of corrections, s/s.
    raised: f64,
}

impl Shown {
    pub(super) const fn new(at: Instant<Local>, far: FarTime) -> Self {
        Self {
            at,
            far,
            remaining: Seconds::ZERO,
            raised: 0.0,
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
        // A cycle twice at one instant moves nothing, nor does one that comes before it.
        if passed <= 0 {
            return;
        }
        let passed = passed as f64;
        let error = target.since(coasting.instant).0 * 1e9 - coasting.fraction_ns;
        let seconds = passed * 1e-9;
        // A low-pass of first order in its implicit form: stable for cycles of any length, and a jump for no pull time.
        let pull = error * (seconds / (seconds + pace.pull_time));
        let bound = passed * self.limit(seconds, error, pace);
        // Below one second per second in any case, so the far time never goes back.
        let correction = pull.clamp(-bound, bound);
        self.far = coasting.plus(correction);
        self.remaining = Seconds((error - correction) * 1e-9);
        self.at = at;
    }

    /// The largest correction in the next `seconds`, s/s, where `error` nanoseconds are to be made up.
    fn limit(&mut self, seconds: f64, error: f64, pace: Pace) -> f64 {
        let in_time = libm::fabs(error) * 1e-9 / TUNING.made_up_within;
        let wanted = in_time.min(pace.catch_up) - pace.limit;
        // Rises at a limited rate and falls at once: the way is made up by then.
        self.raised = wanted.min(self.raised + TUNING.rise * seconds).max(0.0);
        pace.limit + self.raised
    }
}
