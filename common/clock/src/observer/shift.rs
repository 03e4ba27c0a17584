//! Gross shifts: many messages in a row where the jitter would hardly put a single one.

use super::parameters::ObserverParameters;
use crate::instant::{Instant, Local, Span};

/// Watches the residuals, message by message.
#[derive(Clone, Debug)]
pub(super) struct ShiftDetector {
    late: u16,
    early: u16,
    above: u16,
    since: Instant<Local>,
    /// The newest residuals, to find the new level from. Seconds.
    recent: [f64; RECENT],
    next: usize,
}

const RECENT: usize = 16;
/// A suspected shift holds the estimate back from so many messages on.
const SUSPECTED: u16 = 8;

/// Residuals outside are out of the ordinary, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) early: f64,
    pub(super) late: f64,
    /// Some messages should be below this, however late the others.
    pub(super) above: f64,
}

impl ShiftDetector {
    pub(super) const fn new() -> Self {
        Self {
            late: 0,
            early: 0,
            above: 0,
            since: Instant::EPOCH,
            recent: [0.0; RECENT],
            next: 0,
        }
    }

    pub(super) fn clear(&mut self) {
        self.late = 0;
        self.early = 0;
        self.above = 0;
    }

    /// Takes one residual. Says whether a shift is certain: `messages` late ones, or a third as
    /// many early ones, at a regular pace (a backlog is late too, but comes in a burst).
    pub(super) fn observe(
        &mut self,
        residual: f64,
        bounds: Bounds,
        arrived: Instant<Local>,
        pace: Span,
        messages: u16,
    ) -> bool {
        self.recent[self.next] = residual;
        self.next = (self.next + 1) % RECENT;
        if residual < bounds.early {
            self.early = self.early.saturating_add(1);
            self.late = 0;
            return self.early >= messages / 3;
        }
        self.early = self.early.saturating_sub(1);
        if residual < bounds.above {
            self.above = 0;
        } else if self.above == 0 {
            self.since = arrived;
        }
        if residual < bounds.late {
            self.late = 0;
        } else {
            self.late = self.late.saturating_add(1);
        }
        self.above = self
            .above
            .saturating_add(u16::from(residual >= bounds.above));
        let certain = self.late >= messages || self.above >= messages.saturating_mul(2);
        certain && arrived - self.since >= pace * i64::from(messages / 2)
    }

    pub(super) const fn is_suspected(&self) -> bool {
        self.late >= SUSPECTED || self.early >= SUSPECTED / 2
    }

    /// The newest residuals.
    pub(super) const fn recent(&self) -> &[f64; RECENT] {
        &self.recent
    }
}

/// The whole cycles in a shift that is no change of the delay, but a sender that stood still (or
/// leapt): 0 if the delay may well have changed by so much.
pub(super) fn skipped_cycles(shift: f64, cycle: f64, parameters: &ObserverParameters) -> i64 {
    let cycles = libm::round(shift / cycle);
    let rest = shift - cycles * cycle;
    let ms = libm::fabs(shift) * 1e3;
    let whole = ms >= parameters.smallest_skip_ms && libm::fabs(rest) < WHOLE * cycle;
    let beyond_delays = ms >= parameters.largest_slewed_shift_ms && libm::fabs(cycles) > 10.0;
    if whole || beyond_delays {
        cycles as i64
    } else {
        0
    }
}

/// A shift this near to whole cycles, in cycles, is one.
const WHOLE: f64 = 0.0625;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_or_whole_shifts_are_skips() {
        let parameters = ObserverParameters::default();
        let skipped = |ms: f64| skipped_cycles(ms * 1e-3, 1e-3, &parameters);
        assert_eq!([0.2, -0.2, 2.0, -2.0, 7.4].map(skipped), [0; 5]);
        assert_eq!(
            [7.01, -7.01, 60.4, -3000.3].map(skipped),
            [7, -7, 60, -3000]
        );
        assert_eq!(skipped_cycles(0.06, 0.1, &parameters), 0);
    }

    #[test]
    fn a_burst_of_late_messages_is_no_shift() {
        let bounds = Bounds {
            early: -1e-5,
            late: 1e-4,
            above: 2e-5,
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
}
