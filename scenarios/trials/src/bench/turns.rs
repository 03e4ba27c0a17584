//! A measurement in turns: changes of the machine affect all contenders equally.

use std::time::Duration;

use coaxle_clock::Span;
use coaxle_lab::finished::Progress;
use coaxle_os::machine;

/// Refresh interval of the progress.
// Ctrl-C is noticed within it, and a bar at fifty pictures a second looks smooth.
const REFRESH_INTERVAL: Duration = Duration::from_millis(20);

/// Ctrl-C came while something was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted: nothing is printed, as not everything was measured")]
pub(super) struct MeasurementInterrupted;

/// Remaining time of a measurement, on a progress bar.
pub(super) struct BenchProgress<'a> {
    progress: &'a mut dyn Progress,
    done: Span,
    planned: Span,
}

impl<'a> BenchProgress<'a> {
    /// Starts with nothing planned.
    pub(super) fn new(progress: &'a mut dyn Progress) -> Self {
        Self {
            progress,
            done: Span::ZERO,
            planned: Span::ZERO,
        }
    }

    /// Adds planned time.
    pub(super) fn plan(&mut self, time: Span) {
        self.planned += time;
    }

    /// Takes away planned time that is not measured.
    pub(super) fn forgo(&mut self, time: Span) {
        self.planned = (self.planned - time).max(self.done);
    }

    /// Time that was measured up to now.
    pub(super) const fn done(&self) -> Span {
        self.done
    }

    /// Waits.
    ///
    /// # Errors
    /// [`MeasurementInterrupted`].
    pub(super) fn wait(&mut self, time: Span) -> Result<(), MeasurementInterrupted> {
        let begin = machine::now();
        loop {
            let passed = machine::now() - begin;
            // Clamped: a late wake-up must not show more than the turn.
            self.show(passed.min(time))?;
            if passed >= time {
                self.done += time;
                return Ok(());
            }
            let left = (time - passed).as_nanos().unsigned_abs();
            std::thread::park_timeout(REFRESH_INTERVAL.min(Duration::from_nanos(left)));
        }
    }

    /// Adds time that was measured elsewhere.
    ///
    /// # Errors
    /// [`MeasurementInterrupted`].
    pub(super) fn passed(&mut self, time: Span) -> Result<(), MeasurementInterrupted> {
        self.done += time;
        self.show(Span::ZERO)
    }

    fn show(&mut self, passed: Span) -> Result<(), MeasurementInterrupted> {
        // Without a plan the share would be 0/0.
        let planned = self.planned.as_secs_f64().max(1e-9);
        let share = ((self.done + passed).as_secs_f64() / planned).min(1.0);
        if self.progress.at(share) {
            Ok(())
        } else {
            Err(MeasurementInterrupted)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last share that was shown.
    #[derive(Default)]
    struct LastShare(f64);

    impl Progress for LastShare {
        fn at(&mut self, share: f64) -> bool {
            self.0 = share;
            true
        }
    }

    #[test]
    fn the_bar_is_full_although_a_part_is_not_measured_and_a_turn_fails() {
        let mut last = LastShare::default();
        let mut turns = BenchProgress::new(&mut last);
        turns.plan(Span::from_secs(10));
        // Two seconds need what the machine does not have, and a turn of four fails after one.
        turns.forgo(Span::from_secs(2));
        let end = turns.done() + Span::from_secs(4);
        turns.passed(Span::from_secs(1)).unwrap();
        turns.passed(end - turns.done()).unwrap();
        turns.passed(Span::from_secs(4)).unwrap();
        assert!((last.0 - 1.0).abs() < 1e-12, "{}", last.0);
    }
}
