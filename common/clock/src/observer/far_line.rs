//! The line that the observer follows, for others to use, and the delay that they pass to it.

use super::line::Estimate;
use super::output::FarTime;
use super::{LARGEST_DRIFT, PhaseObserver};
use crate::instant::{Instant, Local, Remote, Seconds, Span};
use crate::numbers::{rounded, together};

/// The straight line from local time to far time as estimated when it was requested: at the local instant `t` it is
/// at that `k·T` whose message, if it met no jitter, arrives at `t`.
///
/// Unlike the far time that is shown it knows nothing of a delay, and is not slewed.
#[derive(Clone, Copy, Debug)]
pub struct FarLine {
    /// The sender's run.
    pub epoch: u64,
    /// True if the observer is synchronised, and the line not just found again.
    pub synced: bool,
    /// Number of restarts of locking.
    pub relocks: u32,
    /// Standard deviation of its offset.
    pub sigma: Seconds,
    /// Standard deviation of its rate, s/s.
    pub rate_sigma: f64,
    /// Sum of all jumps of the path's delay so far: the line fell by as much.
    pub jumped: Seconds,
    /// Sum of all corrections of the line by a better one: it fell by as much, though the path's delay is what it
    /// was.
    pub corrected: Seconds,
    /// Number of changes of the drift after which the line was found again.
    pub drift_steps: u32,
    /// Sum of all jumps that turned out to be changes of the drift then: the path's delay did not grow by them.
    pub taken_back: Seconds,
    /// Number of times that counts got another map to far time.
    pub rebases: u32,
    /// The far time of the run's count 0.
    pub(crate) count_zero: Instant<Remote>,
    /// Point `here`, `far` on the line.
    pub(crate) here: Instant<Local>,
    pub(crate) far: FarTime,
    /// Seconds of the far clock per local second.
    pub(crate) rate: f64,
}

impl FarLine {
    /// Returns the sender's lead over the line at the local instant `at`, if its clock shows `since_count_zero`
    /// there, counted from the ideal start of its cycle 0.
    #[must_use]
    pub fn offset_at(&self, since_count_zero: Span, at: Instant<Local>) -> Seconds {
        let line = self.at(at);
        let ahead = (self.count_zero + since_count_zero) - line.instant;
        // Whole nanoseconds are subtracted first: as floats, times since the start would have no digits for the fraction.
        Seconds((ahead.as_nanos() as f64 - line.fraction_ns) * 1e-9)
    }

    pub(crate) fn at(&self, at: Instant<Local>) -> FarTime {
        let FarLine {
            here, far, rate, ..
        } = *self;
        Heading { here, far, rate }.at(at)
    }
}

/// Course of a line, without what is known of it besides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heading {
    here: Instant<Local>,
    far: FarTime,
    pub(super) rate: f64,
}

impl Heading {
    pub(super) fn at(&self, at: Instant<Local>) -> FarTime {
        self.far
            .plus((at - self.here).as_nanos() as f64 * self.rate)
    }
}

impl PhaseObserver {
    /// Sets the least delay of the link, as measured by a two-way exchange or known otherwise. The far time then
    /// leads by it. Once there is a synchronised far time the change is slewed, by up to 1 ms/s.
    pub const fn set_delay(&mut self, delay: Span) {
        self.delay.set(delay);
        self.known_rate = None;
    }

    /// Sets a delay that is measured against the line as it is now, in every cycle: both change at once, so that the far
    /// time does not follow what the line does. The far clock runs at `rate` meanwhile, seconds per local second.
    pub(crate) fn follow_delay(&mut self, delay: Span, rate: f64) {
        let by = (delay - self.delay.set_to()).as_nanos();
        self.delay.shift(by as f64);
        self.known_rate = Some(rate);
    }

    /// Attributes a jump of the line (see [`FarLine::jumped`]) to the path, not to the sender: the delay grows by as
    /// much, and the far time goes on as if nothing had happened.
    pub fn attribute_step_to_path(&mut self, jump: Seconds) {
        self.delay.shift(jump.0 * 1e9);
    }

    /// Takes steps of the line for the path's from now on until
    /// [`attribute_step_to_sender`](Self::attribute_step_to_sender) says otherwise, as time responses will attribute
    /// them. Else steps are attributed by the messages themselves.
    pub const fn leave_steps_to_exchanges(&mut self, they_tell: bool) {
        self.exchanges_tell = they_tell;
    }

    /// Attributes a step, taken for the path's before, to the sender's clock, which stood still or leapt. Returns the
    /// part of it that now goes into the map from counts to far time: whole cycles, if it was so long that slewing it
    /// would take too long. The far time itself goes on as it did.
    pub fn attribute_step_to_sender(&mut self, step: Seconds) -> Span {
        let Some(stream) = &mut self.stream else {
            return Span::ZERO;
        };
        self.drift_change.attributed.forget();
        // A short one is slewed: mapping it would be a jump of every corrected position.
        if libm::fabs(step.0) * 1e3 < self.parameters.smallest_skip_ms {
            return Span::ZERO;
        }
        let cycles = rounded(step.0 / self.seconds_per_count);
        let mapped = self.data_cycle_time * cycles;
        if cycles != 0 {
            stream.origin += mapped;
            // What the map takes, the delay had taken for the path. The far time stays where it is.
            self.delay.shift(-(mapped.as_nanos() as f64));
            self.events.rebase();
        }
        mapped
    }

    /// Returns the line as it is now; none until there is one.
    #[must_use]
    pub fn line(&self) -> Option<FarLine> {
        let followed = self.followed()?;
        self.line_of(&followed.estimate, followed.at)
    }

    /// Makes the line of an estimate, which is of the count `at` since the first.
    pub(super) fn line_of(&self, estimate: &Estimate, at: i64) -> Option<FarLine> {
        let stream = self.stream.as_ref()?;
        let Heading { here, far, rate } = self.heading(estimate, at)?;
        Some(FarLine {
            epoch: stream.epoch,
            synced: self.progress.is_synced()
                && stream.newest_arrival >= self.drift_change.settled_from,
            relocks: self.events.relocks,
            sigma: Seconds(together(
                stream.choice.sigma(estimate.offset_variance),
                self.drift_doubt(),
            )),
            rate_sigma: stream.choice.sigma(estimate.drift_variance),
            jumped: self.jumped,
            corrected: self.corrected,
            drift_steps: self.drift_change.steps,
            taken_back: self.drift_change.taken_back,
            rebases: self.events.rebases,
            count_zero: stream.origin - self.data_cycle_time * stream.first_count as i64,
            here,
            far,
            rate,
        })
    }

    /// Makes the course of the line alone; the rest takes four times as long.
    pub(super) fn heading(&self, estimate: &Estimate, at: i64) -> Option<Heading> {
        let stream = self.stream.as_ref()?;
        let due = self.data_cycle_time * at;
        let far = FarTime {
            instant: stream.origin + due,
            fraction_ns: 0.0,
        };
        // Phases grow by the drift per far second, so the far clock runs at the inverse.
        let rate = 1.0 / (1.0 + within_largest(estimate.drift));
        Some(Heading {
            here: stream.first_arrival + due,
            far: far.plus(-estimate.offset * 1e9 * rate),
            rate,
        })
    }
}

/// Limits a drift to what is believed.
pub(super) const fn within_largest(drift: f64) -> f64 {
    drift.clamp(-LARGEST_DRIFT, LARGEST_DRIFT)
}
