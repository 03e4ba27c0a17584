//! Fit of the exponential width to the messages, or a change of the network.

use super::correlated_delay::CorrelatedDelay;

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

/// Messages that show whether the width still fits. A mean score outside says no, and only `MEMORY_AFTER_CHANGE` of
/// the messages before still count.
const MISFIT_MEMORY: f64 = 96.0;
const MISFIT: core::ops::Range<f64> = -0.35..0.6;
/// Already outside of this, measurements wait until the widths fit again, but no longer than this.
const DOUBTFUL: core::ops::Range<f64> = -0.25..0.35;
const LONGEST_WAIT: f64 = 512.0;
/// Exponential widths at which the lateness of messages is clipped, for both: a burst of spikes is no change.
pub(super) const LATE: f64 = 2.0;
const MEMORY_AFTER_CHANGE: f64 = 64.0;
/// Memory and bounds for small changes.
const SLOW_MISFIT_MEMORY: f64 = 4_096.0;
const SLOW_MISFIT: core::ops::Range<f64> = -0.15..0.2;
const MEMORY_AFTER_SLOW_CHANGE: f64 = 512.0;

impl Misfit {
    /// Takes the scores summed over a block of `n` messages, in full and clipped at [`LATE`]. Returns the number of
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
        self.quick += (clipped - n * self.quick) / MISFIT_MEMORY;
        self.slow += (score - n * self.slow) / SLOW_MISFIT_MEMORY;
        self.usual += (clipped - n * self.usual) / SLOW_MISFIT_MEMORY;
        let tolerance = correlated.patience();
        let quick = (self.quick - self.usual) / tolerance;
        let waits = known && !DOUBTFUL.contains(&quick);
        self.waited = if waits { self.waited + n } else { 0.0 };
        if !MISFIT.contains(&quick) {
            Some(MEMORY_AFTER_CHANGE * correlated.factor())
        } else if !SLOW_MISFIT.contains(&(self.slow / tolerance)) {
            Some(MEMORY_AFTER_SLOW_CHANGE * correlated.factor())
        } else {
            None
        }
    }

    pub(super) fn is_waited_for(&self) -> bool {
        (1.0..LONGEST_WAIT).contains(&self.waited)
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
                let clipped = late.min(LATE);
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
