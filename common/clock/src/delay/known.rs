//! Delay in the end: its measurement, a stated asymmetry of the ways, and the bounds of exchanges.

use super::bounds::{self, Bounds};
use super::estimate::Estimate;
use super::window::Recent;
use super::{Asymmetry, COVERED, DelayExchange};
use crate::instant::{Instant, Local, Span};
use crate::numbers::together;
use crate::observer::FarLine;

impl DelayExchange {
    /// Bounds the estimate by exchanges: whatever the window makes of them, a delay that they all deny is wrong.
    pub(super) fn bound(&mut self, now: Instant<Local>, line: &FarLine) {
        let measured = self.window.measured_now(line);
        self.bound_by(&Recent {
            exchanges: &measured[..self.window.len()],
            now,
            line,
        });
    }

    /// Bounds the estimate after an event that cleared the window: messages before it arrived no earlier than they left,
    /// whatever the line is now.
    pub(super) fn bound_by_history(&mut self, line: &FarLine) {
        let measured = self.history.measured_now(line);
        let exchanges = &measured[..self.history.len()];
        let Some(newest) = exchanges.first() else {
            return;
        };
        self.bound_by(&Recent {
            exchanges,
            now: newest.at,
            line,
        });
        // Exchanges before the event prove nothing of the line after it.
        self.bounds = self.bounds.map(Bounds::unproven);
    }

    fn bound_by(&mut self, recent: &Recent<'_>) {
        self.bounds = Bounds::of(recent);
        if let Some(estimate) = &self.estimate {
            self.pulled = bounds::pull(self.measured(estimate), recent);
        }
    }

    /// Delay by the ways and their known asymmetry, s.
    fn measured(&self, estimate: &Estimate) -> f64 {
        let longer = self.stated.map_or(Span::ZERO, |stated| stated.longer);
        estimate.delay + 0.5 * longer.as_secs_f64()
    }

    /// Delay that no exchange denies, s.
    pub(super) fn delay_of(&self, estimate: &Estimate) -> f64 {
        self.measured(estimate) + self.pulled
    }

    /// Greatest error of the delay, s. A statement that exchanges deny makes nothing surer.
    pub(super) fn uncertainty(
        &self,
        estimate: &Estimate,
        now: Instant<Local>,
        line: &FarLine,
    ) -> f64 {
        let whatever_the_ways = self.uncertainty_of_any_ways(estimate, now, line);
        let Some(Asymmetry { within, .. }) = self.stated else {
            return whatever_the_ways;
        };
        let stated =
            0.5 * within.as_secs_f64() + estimate.doubt() + COVERED * sigma(estimate, line);
        // A statement that was right leaves nothing to pull beyond its own error.
        match self.pulled.abs() <= stated {
            true => stated.min(whatever_the_ways),
            false => whatever_the_ways,
        }
    }

    /// Sender's lead over the line if its ways are equally long, by the exchanges of the last seconds, s.
    pub(crate) fn middle(&self) -> Option<f64> {
        let estimate = self.estimate.as_ref().filter(|known| known.measured)?;
        Some(estimate.delay - self.asymmetry)
    }

    /// Change of half of the difference of the two ways since the start, s.
    pub(crate) const fn asymmetry(&self) -> f64 {
        self.asymmetry
    }

    /// Correction of the middle of exchanges for the known asymmetry of their ways, s, and the greatest error of that where the
    /// least round trip is `round_trip`, s.
    pub(crate) fn inequality(&self, round_trip: f64) -> (f64, f64) {
        let half = 0.5 * round_trip;
        let (stated, within) = match self.stated {
            Some(Asymmetry { longer, within }) if longer.as_secs_f64().abs() <= round_trip => {
                let within = 0.5 * within.as_secs_f64();
                (0.5 * longer.as_secs_f64(), within.min(half))
            }
            _ => (0.0, half),
        };
        (stated + self.asymmetry, within + self.asymmetry.abs())
    }

    /// True if ways of this least round trip cannot differ as stated: neither is shorter than nothing.
    pub(super) fn is_statement_denied(&self, estimate: &Estimate, line: &FarLine) -> bool {
        let Some(Asymmetry { longer, within }) = self.stated else {
            return false;
        };
        // Ways differ by no more than their sum, the round trip.
        let least = longer.as_secs_f64().abs() - within.as_secs_f64();
        let unsure = estimate.doubt() + COVERED * sigma(estimate, line);
        estimate.measured && least > estimate.round_trip() + 2.0 * unsure
    }

    /// Uncertainty by the measurement, and no less than exchanges leave open.
    fn uncertainty_of_any_ways(
        &self,
        estimate: &Estimate,
        now: Instant<Local>,
        line: &FarLine,
    ) -> f64 {
        let measured = estimate.uncertainty + COVERED * line.sigma.0;
        let Some(bounds) = &self.bounds else {
            return measured;
        };
        let (least, most) = bounds.at(now, line);
        let delay = self.delay_of(estimate);
        measured.max(delay - least).max(most - delay)
    }
}

/// Standard deviation of a delay whose ways are as unequal as assumed, s.
pub(super) fn sigma(estimate: &Estimate, line: &FarLine) -> f64 {
    together(estimate.jitter, line.sigma.0)
}
