//! Parameters of a [`PhaseObserver`](super::PhaseObserver).

use super::output::Pace;
use crate::instant::Span;
use crate::time_sync::WrongParameter;

/// Parameters of the observer. The defaults suit cycle times of 1 ms and quartz clocks; nothing
/// needs tuning to the network, whose jitter the observer measures.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct ObserverParameters {
    /// Standard deviation of the drift expected before anything is known, ppm. Above 0, at most
    /// 10 000. Drifts of several times this are found too.
    pub expected_drift_ppm: f64,
    /// Synchronised needs an offset that is known to this standard deviation, µs. Above 0.
    pub synced_sigma_us: f64,
    /// Or to this part of the standard deviation of a message's jitter: no link is kept waiting for
    /// an accuracy that is fine only on a better one. Above 0, at most 1.
    pub synced_sigma_part: f64,
    /// Least number of messages to be synchronised, at least 16; four times as many if the offset is known only in
    /// comparison with the jitter.
    pub synced_messages: u32,
    /// Time after which the best accuracy there is will do, where the sender's clock allows neither, s. Above 0.
    pub longest_locking_s: f64,
    /// The far time once synchronised gains or loses at most this much on the estimated far
    /// clock, ppm. Above 0, at most 500 000.
    pub slew_limit_ppm: f64,
    /// A distance that would take longer than ten seconds to make up at `slew_limit_ppm` is made up at up to this, ppm: a clock
    /// that leapt by some milliseconds without time responses that say so. The state is unsure meanwhile. No more than
    /// `slew_limit_ppm` is that limit for everything. Above 0, at most 500 000.
    pub catch_up_slew_limit_ppm: f64,
    /// Limit like `slew_limit_ppm`, until synchronised. Above 0, at most 500 000.
    pub locking_slew_limit_ppm: f64,
    /// The far time approaches the estimate with this time constant, ms. At least 0.
    pub pull_time_ms: f64,
    /// Messages in a row, all far too late, that are a shift; a third of them, if too early. At least 24. Raised to
    /// what comes in `shortest_shift_ms`.
    pub shift_messages: u16,
    /// Lateness that is over sooner is no shift: a link that keeps the order holds up everything
    /// behind one late message, ms. At least 0, at most 1000.
    pub shortest_shift_ms: f64,
    /// Without time responses and send stamps a shift of at least this much that is a whole number of sender
    /// cycles is a sender that stood still, not a slower network, ms. Where time responses say that it was the
    /// sender, from this much on whole cycles go into the index map. Above 0.
    pub smallest_skip_ms: f64,
    /// Without time responses a shift of at least this much (and of more than ten sender cycles) is no delay
    /// either: whole cycles go into the index map, only the rest is slewed, ms. Above 0.
    pub largest_slewed_shift_ms: f64,
    /// Without a message for this long (but at least for four sender cycles) the observer is in
    /// holdover, ms. Above 0.
    pub holdover_after_ms: f64,
    /// Without a message for this long (but at least for twice the above) it is lost, ms. Above 0.
    pub lost_after_ms: f64,
}

impl Default for ObserverParameters {
    fn default() -> Self {
        Self {
            expected_drift_ppm: 100.0,
            synced_sigma_us: 1.0,
            synced_sigma_part: 0.05,
            synced_messages: 256,
            longest_locking_s: 30.0,
            slew_limit_ppm: 100.0,
            catch_up_slew_limit_ppm: 1_000.0,
            locking_slew_limit_ppm: 500_000.0,
            pull_time_ms: 50.0,
            shift_messages: 48,
            shortest_shift_ms: 20.0,
            smallest_skip_ms: 5.0,
            largest_slewed_shift_ms: 50.0,
            holdover_after_ms: 20.0,
            lost_after_ms: 1_000.0,
        }
    }
}

impl ObserverParameters {
    pub(super) fn check(&self) -> Result<(), WrongParameter> {
        const ABOVE_ZERO: &str = "a finite number above 0";
        const SLEW: &str = "above 0 and at most 500000 ppm";
        let above_zero = |x: f64| x.is_finite() && x > 0.0;
        // At half a second per second the far time still runs forwards, at half its rate.
        let slew = |x: f64| x > 0.0 && x <= 500_000.0;
        let checks = [
            (
                "expected-drift-ppm",
                self.expected_drift_ppm,
                self.expected_drift_ppm > 0.0 && self.expected_drift_ppm <= 1e4,
                "above 0 and at most 10000 ppm",
            ),
            (
                "synced-sigma-us",
                self.synced_sigma_us,
                above_zero(self.synced_sigma_us),
                ABOVE_ZERO,
            ),
            (
                "synced-sigma-part",
                self.synced_sigma_part,
                self.synced_sigma_part > 0.0 && self.synced_sigma_part <= 1.0,
                "above 0 and at most 1",
            ),
            (
                "synced-messages",
                f64::from(self.synced_messages),
                self.synced_messages >= 16,
                "at least 16",
            ),
            (
                "longest-locking-s",
                self.longest_locking_s,
                above_zero(self.longest_locking_s),
                ABOVE_ZERO,
            ),
            (
                "slew-limit-ppm",
                self.slew_limit_ppm,
                slew(self.slew_limit_ppm),
                SLEW,
            ),
            (
                "catch-up-slew-limit-ppm",
                self.catch_up_slew_limit_ppm,
                slew(self.catch_up_slew_limit_ppm),
                SLEW,
            ),
            (
                "locking-slew-limit-ppm",
                self.locking_slew_limit_ppm,
                slew(self.locking_slew_limit_ppm),
                SLEW,
            ),
            (
                "pull-time-ms",
                self.pull_time_ms,
                self.pull_time_ms.is_finite() && self.pull_time_ms >= 0.0,
                "a finite number, at least 0",
            ),
            (
                "shift-messages",
                f64::from(self.shift_messages),
                self.shift_messages >= 24,
                "at least 24",
            ),
            (
                "shortest-shift-ms",
                self.shortest_shift_ms,
                (0.0..=1000.0).contains(&self.shortest_shift_ms),
                "0 to 1000 ms",
            ),
            (
                "smallest-skip-ms",
                self.smallest_skip_ms,
                above_zero(self.smallest_skip_ms),
                ABOVE_ZERO,
            ),
            (
                "largest-slewed-shift-ms",
                self.largest_slewed_shift_ms,
                above_zero(self.largest_slewed_shift_ms),
                ABOVE_ZERO,
            ),
            (
                "holdover-after-ms",
                self.holdover_after_ms,
                above_zero(self.holdover_after_ms),
                ABOVE_ZERO,
            ),
            (
                "lost-after-ms",
                self.lost_after_ms,
                above_zero(self.lost_after_ms),
                ABOVE_ZERO,
            ),
        ];
        match checks.iter().find(|(_, _, fits, _)| !fits) {
            None => Ok(()),
            Some(&(parameter, received, _, expected)) => Err(WrongParameter {
                parameter,
                received,
                expected,
            }),
        }
    }

    /// Number of messages out of bounds that make a shift.
    pub(super) fn messages_of_a_shift(&self, data_cycle_time: Span) -> u16 {
        let least = millis(self.shortest_shift_ms).div_floor(data_cycle_time);
        self.shift_messages
            // At cycles of 0.1 ms the messages of a shift come within 5 ms, less than a hold-up takes.
            .max(u16::try_from(least).unwrap_or(u16::MAX))
    }

    /// Limits of the far time's movement.
    pub(super) fn pace(&self, locking: bool) -> Pace {
        if locking {
            let limit = self.locking_slew_limit_ppm * 1e-6;
            Pace {
                // Before it is synchronised nobody moves by the far time, so it may jump.
                pull_time: 0.0,
                limit,
                catch_up: limit,
            }
        } else {
            Pace {
                pull_time: self.pull_time_ms * 1e-3,
                limit: self.slew_limit_ppm * 1e-6,
                catch_up: self.catch_up_slew_limit_ppm * 1e-6,
            }
        }
    }

    /// Silence that begins holdover, and silence that ends it.
    pub(super) fn silences(&self, data_cycle_time: Span) -> (Span, Span) {
        // A slow sender is silent for a cycle after each message, and three in a row may be lost.
        let holdover = millis(self.holdover_after_ms).max(data_cycle_time * 4);
        (holdover, millis(self.lost_after_ms).max(holdover * 2))
    }
}

fn millis(ms: f64) -> Span {
    Span::from_secs_f64(ms * 1e-3)
}
