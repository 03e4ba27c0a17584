//! Echo of the send stamps in the arrivals.
//!
//! A sender wakes up a little late each time and says so. Over any link its messages then arrive later by as much. Where
//! they do not, something else decides when a message is seen: polling for messages, or a link that delivers them in
//! batches. Arrivals are level then between two of its steps, whatever the sender's clock does, and the scatter of
//! arrivals says nothing of their worth.
//!
//! The slope of first differences shows it: 1 where arrivals echo, 0 where they do not. Its standard deviation is
//! `√(var Δa / (n · var Δs))`.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the comparison of arrivals with send stamps.
    EchoTuning {
        /// Messages over which differences count.
        memory: f64 = 4_096.0,
        /// Least number of messages for a result.
        enough: f64 = 128.0,
        /// Standard deviations below one half at which a slope is none, and above it at which it is one.
        certain: f64 = 4.0,
        /// A difference of more than this multiple of the usual is a spike or a tooth and no echo.
        // Teeth alone, now and then, echo on the mean.
        outlier: f64 = 5.0,
    }
}

/// Least square of differences, s².
// Not tuned: a floor. Without it the first difference after phases that are all alike would be an outlier for ever, and the slope
// of stamps that are all alike is 0/0.
const LEAST_SQUARE: f64 = 1e-14;

/// Compares arrivals with send stamps.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::observer) struct Echo {
    /// The count of the newest message, its phase and its stamp, s.
    last: Option<(i64, f64, f64)>,
    count: f64,
    /// Means of squares and products of differences, s².
    stamps: f64,
    phases: f64,
    both: f64,
    missing: Option<bool>,
}

impl Echo {
    /// Takes the lateness of sending a message, s, and its phase, from which that was not taken away.
    pub(in crate::observer) fn take(&mut self, count: i64, phase: f64, stamp: f64) {
        let Some((before, last_phase, last_stamp)) = self.last.replace((count, phase, stamp))
        else {
            return;
        };
        let (by_phase, by_stamp) = (phase - last_phase, stamp - last_stamp);
        let square = by_phase * by_phase;
        let usual = self.phases.max(by_stamp * by_stamp).max(LEAST_SQUARE);
        // Differences of neighbours alone: over a gap the clock's drift is in the phases, and not in the stamps.
        if count.wrapping_sub(before) != 1
            || self.count > 16.0 && square > TUNING.outlier * TUNING.outlier * usual
        {
            return;
        }
        self.count = (self.count + 1.0).min(TUNING.memory);
        // A plain mean up to the memory, then one that forgets.
        let part = 1.0 / self.count;
        self.stamps += part * (by_stamp * by_stamp - self.stamps);
        self.phases += part * (square - self.phases);
        self.both += part * (by_phase * by_stamp - self.both);
    }

    /// Evaluates the messages taken.
    pub(in crate::observer) fn judge(&mut self) {
        if self.count < TUNING.enough || self.stamps < LEAST_SQUARE {
            return;
        }
        let slope = self.both / self.stamps;
        // Standard deviation of a slope without echo: every other cause of the phases is noise here.
        let sigma = libm::sqrt(self.phases / (self.stamps * self.count));
        // Half-way between echo and none, each four standard deviations away. In between nothing is said.
        if slope + TUNING.certain * sigma < 0.5 {
            self.missing = Some(true);
        } else if slope - TUNING.certain * sigma > 0.5 {
            self.missing = Some(false);
        }
    }

    /// Reports whether something other than the sender decides when its messages are seen, once that is clear.
    pub(in crate::observer) const fn is_missing(&self) -> Option<bool> {
        self.missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::tests::delays::Random;

    /// Result for messages that were sent up to some 5 µs late and are seen as `seen` returns.
    fn is_missing(messages: i64, mut seen: impl FnMut(f64, &mut Random) -> f64) -> Option<bool> {
        let mut random = Random::of_seed(3);
        let mut echo = Echo::default();
        for count in 0..messages {
            let late = 5e-6 * random.normal();
            let phase = 2e-4 + 5e-7 * count as f64 + seen(late, &mut random);
            echo.take(count, phase, late);
        }
        echo.judge();
        echo.is_missing()
    }

    #[test]
    fn arrivals_that_do_not_echo_are_noticed_and_others_are_not() {
        let polled = |_: f64, random: &mut Random| 5e-6 * random.exponential();
        assert_eq!(is_missing(100, polled), None, "too few");
        assert_eq!(is_missing(256, polled), Some(true));
        assert_eq!(is_missing(4_096, |late, _| late), Some(false));
        let jitter = |late: f64, random: &mut Random| late + 2e-5 * random.exponential();
        assert_eq!(is_missing(4_096, jitter), Some(false));
    }

    #[test]
    fn a_sender_that_is_never_late_tells_nothing() {
        let mut echo = Echo::default();
        for count in 0..1_000 {
            echo.take(count, 0.0, 0.0);
        }
        echo.judge();
        assert_eq!(echo.is_missing(), None);
    }
}
