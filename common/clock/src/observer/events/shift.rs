//! Gross shifts: many messages in a row where the jitter would hardly put a single one.

use crate::instant::{Instant, Local, Span};
use crate::observer::ObserverParameters;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the detection of a shift.
    ShiftTuning {
        /// A run is displaced where its least lateness is above this part of its mean.
        // `n` exponential ones without a smaller one have a chance of exp(−0.4·n), 1e-7 for the 40 of a late run.
        late_part: f64 = 0.4,
        /// Likewise for the run above the line, which is twice as long.
        above_part: f64 = 0.3,
        /// The first messages of a run, which may have been late by chance, before the shift.
        first_ignored: u16 = 8,
        /// Messages in a row from which a suspected shift holds the estimate back …
        suspected: u16 = 8,
        /// … and of those above the line.
        // After a step of +30 µs at 5/20 without this: 17 µs rms and 22 ppm, with it 0.2 µs.
        suspected_above: u16 = 16,
        /// Messages after which a suspicion is dropped.
        longest_suspicion: u16 = 512,
        /// A shift this near to whole cycles, in cycles, is one.
        whole: f64 = 0.0625,
        /// Excess of ways from which exchanges are not believed, s.
        // Half of the longest one that they accept.
        longest_measured: f64 = 0.5,
        /// Cycles of a shift beyond delays that are no chance.
        fewest_cycles: f64 = 10.0,
    }
}

/// Watches the residuals, message by message.
#[derive(Clone, Debug)]
pub(in crate::observer) struct ShiftDetector {
    /// Two for each early message, less one for each other.
    early: u16,
    /// Messages in a row that were suspicious.
    suspected: u16,
    level: f64,
    since: Instant<Local>,
    late_run: Run,
    above_run: Run,
    /// The newest residuals, to find the new level from. Seconds.
    recent: [f64; RECENT],
    next: usize,
}

/// Messages in a row that all came too late.
#[derive(Clone, Copy, Debug)]
struct Run {
    least: f64,
    sum: f64,
    messages: u16,
}

impl Run {
    const NONE: Self = Self {
        least: f64::INFINITY,
        sum: 0.0,
        messages: 0,
    };

    fn take(&mut self, residual: f64) {
        self.messages = self.messages.saturating_add(1);
        // The first may have been late by chance, before the shift.
        if self.messages > TUNING.first_ignored {
            self.least = self.least.min(residual);
            self.sum += residual;
        }
    }

    /// A longer delay makes all messages later, also the earliest; wider jitter only most of them.
    /// For exponential jitter of whatever width, `n` messages without one below this part of their
    /// mean have a chance of about `exp(-TUNING.late_part·n)`.
    fn is_displaced(&self, level: f64, part: f64) -> bool {
        let n = f64::from(self.messages.saturating_sub(TUNING.first_ignored));
        self.least - level > part * (self.sum / n - level)
    }
}

const RECENT: usize = 16;

/// Residuals outside are out of the ordinary, s.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Bounds {
    pub(in crate::observer) early: f64,
    pub(in crate::observer) late: f64,
    /// Some messages should be below this, however late the others.
    pub(in crate::observer) above: f64,
    /// Level of the line.
    pub(in crate::observer) level: f64,
    /// Factor on the usual number of messages that make a shift.
    pub(in crate::observer) patience: f64,
}

impl ShiftDetector {
    pub(in crate::observer) const fn new() -> Self {
        Self {
            early: 0,
            suspected: 0,
            level: 0.0,
            since: Instant::EPOCH,
            late_run: Run::NONE,
            above_run: Run::NONE,
            recent: [0.0; RECENT],
            next: 0,
        }
    }

    pub(in crate::observer) fn clear(&mut self) {
        self.early = 0;
        self.suspected = 0;
        self.late_run = Run::NONE;
        self.above_run = Run::NONE;
    }

    /// Takes one residual. Returns whether a shift is certain: `messages` late ones, or a third as many early ones,
    /// at a regular pace (a backlog is late too, but comes in a burst).
    pub(in crate::observer) fn observe(
        &mut self,
        residual: f64,
        bounds: Bounds,
        arrived: Instant<Local>,
        pace: Span,
        messages: u16,
    ) -> bool {
        // Correlated delays make runs that are longer by chance alone.
        let messages = (f64::from(messages) * bounds.patience) as u16;
        self.recent[self.next] = residual;
        self.next = (self.next + 1) % RECENT;
        self.suspected = if self.is_suspicious() {
            self.suspected.saturating_add(1)
        } else {
            0
        };
        if residual < bounds.early {
            // Two up and one down: a third of the messages being early is enough, in whatever order.
            self.early = self.early.saturating_add(2);
            self.late_run = Run::NONE;
            return self.early >= messages / 3 * 2;
        }
        self.early = self.early.saturating_sub(1);
        self.level = bounds.level;
        if residual < bounds.above {
            self.above_run = Run::NONE;
        } else {
            if self.above_run.messages == 0 {
                self.since = arrived;
            }
            self.above_run.take(residual);
        }
        if residual < bounds.late {
            self.late_run = Run::NONE;
        } else {
            self.late_run.take(residual);
        }
        // A backlog is late too, but comes at once: as many messages take half of their time at least.
        self.is_certain(messages) && arrived - self.since >= pace * i64::from(messages / 2)
    }

    /// Reports whether the run is a shift. One that is long enough, but is none, makes room for the next.
    fn is_certain(&mut self, messages: u16) -> bool {
        let level = self.level;
        let runs = [
            (&mut self.late_run, messages, TUNING.late_part),
            (
                &mut self.above_run,
                messages.saturating_mul(2),
                TUNING.above_part,
            ),
        ];
        for (run, needed, part) in runs {
            if run.messages >= needed {
                if run.is_displaced(level, part) {
                    return true;
                }
                *run = Run::NONE;
            }
        }
        false
    }

    /// True if the estimate is to be held back.
    pub(in crate::observer) fn is_suspected(&self) -> bool {
        (1..TUNING.longest_suspicion).contains(&self.suspected)
    }

    fn is_suspicious(&self) -> bool {
        let suspicious = |run: &Run, messages: u16, part: f64| {
            // After twice those ignored the least of a run says something: jitter that became wider has early messages, too.
            let wider =
                run.messages > 2 * TUNING.first_ignored && !run.is_displaced(self.level, part);
            run.messages >= messages && !wider
        };
        suspicious(&self.late_run, TUNING.suspected, TUNING.late_part)
            || suspicious(&self.above_run, TUNING.suspected_above, TUNING.above_part)
            || self.early >= TUNING.suspected
    }

    /// The newest residuals.
    pub(in crate::observer) const fn recent(&self) -> &[f64; RECENT] {
        &self.recent
    }
}

/// Evidence that distinguishes a longer delay from a sender that stood still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::observer) enum Evidence {
    /// Only the shift itself.
    Nothing,
    /// Send stamps in the messages. A sender that begins its cycles late is seen by that and is no shift, so a shift
    /// was the path, or a clock that stopped.
    SendStamps,
    /// Time responses, which will attribute it soon.
    Exchanges,
}

/// Whole cycles in a shift that is no change of the delay, but a sender that stood still (or leapt): 0 if the delay
/// may well have changed by as much.
pub(in crate::observer) fn skipped_cycles(
    shift: f64,
    cycle: f64,
    evidence: Evidence,
    parameters: &ObserverParameters,
) -> i64 {
    let cycles = libm::round(shift / cycle);
    let rest = shift - cycles * cycle;
    let ms = libm::fabs(shift) * 1e3;
    let whole = ms >= parameters.smallest_skip_ms && libm::fabs(rest) < TUNING.whole * cycle;
    let beyond_delays =
        ms >= parameters.largest_slewed_shift_ms && libm::fabs(cycles) > TUNING.fewest_cycles;
    // Send stamps rule out a late sender but not a stopped clock, and exchanges will say which it was.
    let is_skip = match evidence {
        Evidence::Nothing => whole || beyond_delays,
        Evidence::SendStamps => beyond_delays,
        Evidence::Exchanges => libm::fabs(shift) > TUNING.longest_measured,
    };
    if is_skip { cycles as i64 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_or_whole_shifts_are_skips() {
        let parameters = ObserverParameters::default();
        let skipped = |evidence, ms: f64| skipped_cycles(ms * 1e-3, 1e-3, evidence, &parameters);
        let small = [0.2, -0.2, 2.0, -2.0, 7.4];
        let large = [7.01, -7.01, 60.4, -3000.3];
        for (evidence, expected) in [
            (Evidence::Nothing, [7, -7, 60, -3000]),
            (Evidence::SendStamps, [0, 0, 60, -3000]),
            (Evidence::Exchanges, [0, 0, 0, -3000]),
        ] {
            assert_eq!(small.map(|ms| skipped(evidence, ms)), [0; 5]);
            assert_eq!(large.map(|ms| skipped(evidence, ms)), expected);
        }
        let long = skipped_cycles(0.06, 0.1, Evidence::Nothing, &parameters);
        assert_eq!(long, 0);
        // A sender that stood still is whole cycles late, but for how late its messages come by chance.
        assert_eq!(skipped(Evidence::Nothing, 7.05), 7);
        assert_eq!(skipped(Evidence::Nothing, 7.07), 0);
        // A link may well be slower by some long cycles.
        let skipped =
            |evidence, cycles: f64| skipped_cycles(cycles * 1e-2, 1e-2, evidence, &parameters);
        assert_eq!(skipped(Evidence::Nothing, 8.4), 0);
        assert_eq!(skipped(Evidence::Nothing, 12.4), 12);
        // No way of this length is measured by exchanges, which take a second at most for both.
        assert_eq!(skipped(Evidence::Exchanges, 40.0), 0);
        assert_eq!(skipped(Evidence::Exchanges, 60.0), 60);
    }

    #[test]
    fn a_burst_of_late_messages_is_no_shift() {
        let bounds = Bounds {
            early: -1e-5,
            late: 1e-4,
            above: 2e-5,
            level: 0.0,
            patience: 1.0,
        };
        let pace = Span::from_millis(1);
        let notice = |spacing: Span| {
            let mut detector = ShiftDetector::new();
            (0..60).any(|k| {
                let arrived = Instant::EPOCH + spacing * k;
                detector.observe(1e-3, bounds, arrived, pace, 48)
            })
        };
        assert!(notice(pace));
        assert!(!notice(Span::from_micros(10)));
    }

    #[test]
    fn wider_jitter_is_no_shift_but_a_longer_delay_is() {
        let bounds = Bounds {
            early: -1e-5,
            late: 3e-5,
            above: 1.5e-5,
            level: 0.0,
            patience: 1.0,
        };
        let pace = Span::from_millis(1);
        let notice = |residual: fn(f64) -> f64| {
            let mut detector = ShiftDetector::new();
            (0..400).any(|k| {
                // Every twentieth is the earliest.
                let part = (0.5 + f64::from(k * 7 % 20)) / 20.0;
                let arrived = Instant::EPOCH + pace * i64::from(k);
                detector.observe(residual(-libm::log(part)), bounds, arrived, pace, 48)
            })
        };
        assert!(!notice(|late| 3.5e-5 + 4e-4 * late));
        assert!(notice(|late| 2e-4 + 2e-5 * late));
    }
}
