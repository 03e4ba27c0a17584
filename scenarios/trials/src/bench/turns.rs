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
