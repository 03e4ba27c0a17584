//! The rate of the sender's clock by two exchanges of the timing channel alone.
//!
//! A line begins beside the rate that the messages show. Where these scatter by milliseconds, that is wrong for minutes, and a line beside it is
//! contradicted by its own exchanges again and again. Two exchanges bound the rate, whatever their ways are: each shows the sender's lead to half of
//! its round trip.

use crate::delay::TimeResponse;
use crate::instant::{Instant, Local, Span};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the rate by exchanges.
    OwnRateTuning {
        /// Greatest error, s/s, with which the rate of the messages can be judged …
        // Twice what a line expects of the rate that it begins with.
        sharp: f64 = 20e-6,
        /// … unless this time, s, has passed.
        // Of ways of 300 µs as on a machine of its own, where a line begins as soon as messages are synchronised, rates that are wrong by more than
        // 600 ppm are noticed.
        patience: f64 = 0.5,
    }
}

/// Rate by the first and the newest exchange since there is no line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OwnRate(Option<ExchangeMiddle>);

/// Middle of an exchange.
#[derive(Clone, Copy, Debug)]
struct ExchangeMiddle {
    /// Mean of the request's departure and the response's arrival.
    here: Instant<Local>,
    /// Mean of the request's arrival and the response's departure.
    far: Span,
    /// Half of the time on both ways, s.
    error: f64,
}

impl ExchangeMiddle {
    fn of(arrived: Instant<Local>, exchange: &TimeResponse) -> Self {
        let took = arrived - exchange.requested;
        let stayed = exchange.responded - exchange.received;
        Self {
            here: exchange.requested + took / 2,
            far: exchange.received + stayed / 2,
            error: 0.5 * (took - stayed).as_secs_f64(),
        }
    }
}

impl OwnRate {
    /// Takes an exchange whose response arrived at `arrived`. Returns the rate to begin with: that of the messages, where the exchanges permit
    /// it, or else their own, once that is sharp.
    pub(super) fn take(
        &mut self,
        arrived: Instant<Local>,
        exchange: &TimeResponse,
        by_messages: f64,
    ) -> Option<f64> {
        let newest = ExchangeMiddle::of(arrived, exchange);
        let first = *self.0.get_or_insert(newest);
        let passed = (newest.here - first.here).as_secs_f64();
        if passed <= 0.0 {
            return None;
        }
        let error = (first.error + newest.error) / passed;
        if error > TUNING.sharp && passed < TUNING.patience {
            return None;
        }
        let rate = (newest.far - first.far).as_secs_f64() / passed;
        if libm::fabs(by_messages - rate) <= error {
            return Some(by_messages);
        }
        (error <= TUNING.sharp).then_some(rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An exchange of a clock of this rate, `ways` ns there and back, 20 ms after the one before.
    fn exchange(n: i64, rate: f64, ways: i64) -> (Instant<Local>, TimeResponse) {
        let far = |at: i64| Span::from_nanos((at as f64 * rate) as i64);
        let requested = 20_000_000 * n;
        let received = requested + ways / 2;
        let responded = received + 300_000;
        let response = TimeResponse {
            run: 0,
            number: 0,
            requested: Instant::from_nanos(requested),
            epoch: 0,
            received: far(received),
            responded: far(responded),
        };
        (Instant::from_nanos(responded + ways / 2), response)
    }

    /// Number of exchanges until there is a rate, and that rate.
    fn rate(ways: i64, by_messages: f64) -> (i64, f64) {
        let mut own = OwnRate::default();
        (0..100)
            .find_map(|n| {
                let (arrived, exchange) = exchange(n, 1.000_14, ways);
                own.take(arrived, &exchange, by_messages)
                    .map(|rate| (n, rate))
            })
            .expect("a rate")
    }

    #[test]
    fn the_rate_of_the_messages_is_taken_where_exchanges_permit_it() {
        let (after, rate) = rate(2_000, 1.000_145);
        assert_eq!((after, rate), (5, 1.000_145));
    }

    #[test]
    fn one_that_they_deny_is_replaced() {
        let (_, rate) = rate(2_000, 1.000_03);
        assert!((rate - 1.000_14).abs() < 2e-6, "{rate}");
    }

    #[test]
    fn of_long_ways_only_a_rate_that_is_denied_is_waited_for() {
        assert_eq!(rate(300_000, 1.000_5), (25, 1.000_5));
        let (after, rate) = rate(30_000, 1.001);
        assert_eq!(after, 75);
        assert!((rate - 1.000_14).abs() < 1e-6, "{rate}");
    }
}
