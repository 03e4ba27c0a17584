//! Fit of the exponential width to the messages, or a change of the network.

use super::correlated_delay::CorrelatedDelay;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the fit of the exponential width. A mean score is 0 where the width is right.
    MisfitTuning {
        /// Messages that show whether the width still fits.
        // The mean of independent scores scatters by 0.07.
        memory: f64 = 96.0,
        /// A mean score below it says that the jitter became narrower, and only `memory_after_change` of the messages before still
        /// count …
        least: f64 = -0.35,
        /// … and one above it, that it became wider.
        // Scores are skewed to this side.
        greatest: f64 = 0.6,
        /// Already outside of this, measurements wait until the widths fit again …
        doubtful_least: f64 = -0.25,
        /// … on either side …
        doubtful_greatest: f64 = 0.35,
        /// … but no longer than for this number of messages.
        longest_wait: f64 = 512.0,
        /// Exponential widths at which the lateness of messages is clipped.
        // A burst of spikes is no change (at 8 widths bursts on busy PCs trigger it, and the ripple is 496 ns instead of 318).
        late: f64 = 2.0,
        /// Messages that count after a change.
        // As many as have shown it.
        memory_after_change: f64 = 64.0,
        /// Messages that show small changes, with a scatter of 0.011 …
        slow_memory: f64 = 4_096.0,
        /// … by a mean score below this …
        slow_least: f64 = -0.15,
        /// … or above this.
        slow_greatest: f64 = 0.2,
        /// Messages that count after a small change.
        memory_after_slow_change: f64 = 512.0,
    }
}

/// Mean scores of the exponential width over the last messages: near 0 while it is right.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Misfit {
    quick: f64,
    slow: f64,
    /// Usual quick score, for jitter of another shape.
    usual: f64,
    /// Messages for which the width has not been fit to measure with.
    waited: f64,
}

impl Misfit {
    /// Takes the scores summed over a block of `n` messages, in full and clipped. Returns the number of
    /// messages that still count, if the width (once `known`) does not fit any more. Where the delay wanders, it may
    /// fit less well for longer.
    pub(super) fn take(
        &mut self,
        score: f64,
        clipped: f64,
        n: f64,
        known: bool,
        correlated: &CorrelatedDelay,
    ) -> Option<f64> {
        // Sums over a block of n: the mean moves as by n messages one after the other.
        self.quick += (clipped - n * self.quick) / TUNING.memory;
        self.slow += (score - n * self.slow) / TUNING.slow_memory;
        self.usual += (clipped - n * self.usual) / TUNING.slow_memory;
        let tolerance = correlated.patience();
        // Less the usual score: jitter that is not exponential has a mean that is not 0.
        let quick = (self.quick - self.usual) / tolerance;
        // At first no width fits, and waiting would only delay the lock.
        let waits = known && !(TUNING.doubtful_least..TUNING.doubtful_greatest).contains(&quick);
        self.waited = if waits { self.waited + n } else { 0.0 };
        // The quick test first: after a large change both fail, and the shorter memory is the right one.
        if !(TUNING.least..TUNING.greatest).contains(&quick) {
            Some(TUNING.memory_after_change * correlated.factor())
        } else if !(TUNING.slow_least..TUNING.slow_greatest).contains(&(self.slow / tolerance)) {
            Some(TUNING.memory_after_slow_change * correlated.factor())
        } else {
            None
        }
    }

    pub(super) fn is_waited_for(&self) -> bool {
        (1.0..TUNING.longest_wait).contains(&self.waited)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wider_jitter_is_noticed_and_a_burst_is_not() {
        let noticed = |late: f64, blocks: usize| {
            let mut misfit = Misfit::default();
            (0..blocks).any(|_| {
                let clipped = late.min(TUNING.late);
                misfit
                    .take(
                        8.0 * late,
                        8.0 * clipped,
                        8.0,
                        true,
                        &CorrelatedDelay::new(),
                    )
                    .is_some()
            })
        };
        assert!(noticed(3.0, 10));
        assert!(noticed(-0.7, 12));
        assert!(!noticed(7.0, 2));
    }

    #[test]
    fn measurements_do_not_wait_for_ever() {
        let mut misfit = Misfit::default();
        let mut waited = 0;
        for _ in 0..200 {
            let _ = misfit.take(8.0, 8.0, 8.0, true, &CorrelatedDelay::new());
            waited += usize::from(misfit.is_waited_for());
        }
        assert!(waited > 10 && waited < 64, "{waited}");
    }
}
