//! The line through the exchanges of the timing channel.

use super::doubt::Doubt;
use super::noise::{Noise, RoundTrip};
use crate::delay::TimeResponse;
use crate::instant::{Instant, Local, Span};
use crate::numbers::rounded;
use crate::observer::Bank;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the line.
    TimingLineTuning {
        /// Measurements that are enough for the line to be believed.
        enough: u32 = 8,
        /// Possible error of the rate that the line begins with, s/s.
        // It is the rate of a line that is synchronised.
        expected_drift: f64 = 10e-6,
        /// Standard deviations that, beside half of the round trip, are more than any way can explain.
        // A clock leapt.
        beyond_chance: f64 = 8.0,
        /// After this many such measurements in a row the line begins again.
        contradictions: u8 = 4,
    }
}

/// Error of stamps, by which the ways may seem shorter than nothing, s.
// Not tuned: a bound far above what stamps of one machine differ by (some ns), and far below what a clock leaps by.
const STAMP_ERROR: f64 = 1e-6;

/// Exchanges that make one measurement: the shortest of their ways there, and the shortest of their ways back.
pub(crate) const GROUP: usize = 8;
/// Standard deviations that the uncertainty covers.
const COVERED: f64 = 3.0;

/// Ways of one exchange, beside a line with the rate that was known when it began, s.
#[derive(Clone, Copy, Debug, Default)]
struct ExchangeWays {
    /// Departure of the request, and arrival of the response, since the first exchange.
    left: f64,
    arrived: f64,
    /// Sender's lead, plus the way there.
    there: f64,
    /// Sender's lead, less the way back.
    back: f64,
}

/// Sender's lead over the own clock, as a line in time.
#[derive(Clone, Debug)]
pub(crate) struct TimingLine {
    /// Origin on both clocks, and the rate of the sender's clock as assumed then.
    here: Instant<Local>,
    far: Span,
    rate: f64,
    group: [ExchangeWays; GROUP],
    filled: usize,
    bank: Option<Bank>,
    /// Time of the bank's estimate since the beginning, s.
    at: f64,
    noise: Noise,
    /// By the shortest ways there and back of each group: how long a measurement was held up.
    round_trip: RoundTrip,
    /// By single exchanges: how far the middle of the ways may be off.
    of_one: RoundTrip,
    measurements: u32,
    contradictions: u8,
    /// Innovation of the newest measurement, s.
    missed: Option<f64>,
    /// Error of the line by the newest measurement, beyond chance.
    doubt: Doubt,
}

impl TimingLine {
    /// Begins with an exchange, beside a line with this rate, s/s.
    ///
    /// The shortest round trip is that of the last `measurements`.
    pub(crate) fn new(first: &TimeResponse, rate: f64, measurements: usize) -> Self {
        Self {
            here: first.requested,
            far: first.received,
            rate,
            group: [ExchangeWays::default(); GROUP],
            filled: 0,
            bank: None,
            at: 0.0,
            noise: Noise::new(),
            round_trip: RoundTrip::new(measurements),
            of_one: RoundTrip::new(measurements),
            measurements: 0,
            contradictions: 0,
            missed: None,
            doubt: Doubt::NONE,
        }
    }

    /// Takes the innovation of the newest measurement, s; once.
    pub(crate) const fn take_missed(&mut self) -> Option<f64> {
        self.missed.take()
    }

    /// Takes an exchange whose response arrived at `arrived`. Returns whether the clocks are no longer where the line
    /// has them.
    pub(crate) fn take(&mut self, arrived: Instant<Local>, exchange: &TimeResponse) -> bool {
        let (left, came) = (self.since(exchange.requested), self.since(arrived));
        self.group[self.filled] = ExchangeWays {
            left,
            arrived: came,
            there: self.ahead(exchange.received, left),
            back: self.ahead(exchange.responded, came),
        };
        self.filled += 1;
        if self.filled == GROUP {
            self.filled = 0;
            self.measure();
        }
        self.contradictions >= TUNING.contradictions
    }

    /// True if enough measurements were taken.
    pub(crate) fn is_acquired(&self) -> bool {
        self.measurements >= TUNING.enough
    }

    /// Time of the sender's clock at `now`, since the ideal start of its cycle 0.
    pub(crate) fn far_time(&self, now: Instant<Local>) -> Span {
        let since = self.since(now);
        let ahead = self.bank.as_ref().map_or(0.0, |bank| {
            let estimate = bank.combined();
            estimate.offset + estimate.drift * (since - self.at)
        });
        // Whole nanoseconds first: the rest is a small number.
        let passed = (now - self.here).as_nanos();
        let beside = passed as f64 * (self.rate - 1.0) + ahead * 1e9;
        self.far + Span::from_nanos(passed) + Span::from_nanos(rounded(beside))
    }

    /// Rate of the sender's clock, seconds per local second.
    pub(crate) fn rate(&self) -> f64 {
        self.rate + self.bank.as_ref().map_or(0.0, |bank| bank.combined().drift)
    }

    /// Standard deviation of the far time but for the asymmetry of the ways, s.
    pub(crate) fn sigma(&self, now: Instant<Local>) -> f64 {
        let Some(bank) = &self.bank else {
            return f64::INFINITY;
        };
        let ahead = (self.since(now) - self.at).max(0.0);
        let variance = bank
            .combined()
            .offset_variance_after(ahead, bank.drift_walk());
        libm::sqrt(variance + bank.bias_variance())
    }

    /// Greatest error of the far time: whatever the ways are, neither is shorter than nothing, s.
    pub(crate) fn uncertainty(&self, now: Instant<Local>) -> f64 {
        0.5 * self.round_trip() + COVERED * self.sigma(now) + self.doubt(now)
    }

    /// Error of the far time where more than chance shows one, s: by the newest measurements, and by the filter that follows a rate most
    /// quickly.
    pub(crate) fn doubt(&self, now: Instant<Local>) -> f64 {
        let since = self.since(now);
        let Some(bank) = &self.bank else {
            return 0.0;
        };
        let ahead = (since - self.at).max(0.0);
        let estimate = bank.combined();
        let (agile, variance) = bank.agile(ahead);
        let apart = libm::fabs(estimate.offset + estimate.drift * ahead - agile);
        // As clocks wander quickly, the slow filters are begun again and again, and one may lead for a measurement before it is wrong.
        let by_filters = match apart > COVERED * libm::sqrt(variance) {
            true => apart,
            false => 0.0,
        };
        self.doubt.after(since).max(by_filters)
    }

    /// Least round trip, s.
    pub(crate) const fn round_trip(&self) -> f64 {
        // Of one exchange, in which no rate is. A rate r that changes within a group makes the ways of two exchanges seem shorter together by r times the time
        // between them: 0.3 of 2 µs for 3.6 ppm in swarm schedule 90447, which is within chance, and for ten seconds.
        self.of_one.shortest()
    }

    fn since(&self, at: Instant<Local>) -> f64 {
        (at - self.here).as_nanos() as f64 * 1e-9
    }

    /// Sender's lead, where its clock shows `far`, over a line with the first rate, s.
    fn ahead(&self, far: Span, since: f64) -> f64 {
        let far = (far - self.far).as_nanos() as f64 * 1e-9;
        (far - since) - (self.rate - 1.0) * since
    }

    /// Makes one measurement of the group, which is full.
    fn measure(&mut self) {
        let middle = self.group.iter().map(|ways| ways.left).sum::<f64>() / GROUP as f64;
        // Of one exchange, so that no error of the rate is in it.
        let exchanges = self.group.iter().map(|ways| ways.there - ways.back);
        let quickest = exchanges.fold(f64::INFINITY, f64::min);
        let (drift, drift_sigma) =
            self.bank
                .as_ref()
                .map_or((0.0, TUNING.expected_drift), |bank| {
                    let estimate = bank.combined();
                    (estimate.drift, libm::sqrt(estimate.drift_variance))
                });
        // Brought to one time: at 100 ppm leads within a group of 0.16 s differ by 16 µs.
        let level = |ahead: f64, at: f64| (ahead - drift * (at - middle), at);
        let ways = self.group.iter();
        let there = ways.clone().map(|ways| level(ways.there, ways.left));
        let back = ways.map(|ways| level(ways.back, ways.arrived));
        let (there, there_at) = there.fold((f64::INFINITY, 0.0), lesser);
        let (back, back_at) = back.fold((f64::NEG_INFINITY, 0.0), greater);
        // Of the shortest ways there and back, which need not be of one exchange.
        let round_trip = there - back;
        // A wrong rate makes them shorter together than they are. In swarm schedule 2932 two of a line that had just begun took nothing
        // together, for ten seconds, and far time was further off than stated.
        let by_rate = COVERED * drift_sigma * libm::fabs(there_at - back_at);
        let longest = (round_trip + by_rate).min(quickest);
        if !(round_trip > -STAMP_ERROR && middle > self.at) {
            // A clock leapt within the group, or the rate is wrong by far.
            self.contradictions += 1;
            self.doubt_at(middle, 0.5 * (there + back));
            return;
        }
        let measured = 0.5 * (there + back);
        let longer = self.round_trip.take(longest);
        let _ = self.of_one.take(quickest);
        let passed = middle - self.at;
        let Some(bank) = &mut self.bank else {
            let variance = self.noise.first(round_trip);
            let drift = TUNING.expected_drift * TUNING.expected_drift;
            self.bank = Some(Bank::new(measured, variance, drift));
            self.at = middle;
            self.measurements = 1;
            return;
        };
        let estimate = bank.combined();
        let expected = estimate.offset + estimate.drift * passed;
        let known = estimate.offset_variance_after(passed, bank.drift_walk());
        self.missed = Some(measured - expected);
        // On one of both ways, or on both.
        let held_up = 0.25 * longer * longer;
        let variance = self.noise.variance() + held_up;
        let by_chance = COVERED * libm::sqrt(known + variance);
        (self.doubt).take(middle, passed, measured - expected, by_chance);
        if self.doubt.is_any() {
            // At a wrong rate the ways of two exchanges seem shorter together than they are, and for ten seconds.
            self.round_trip.correct(quickest);
        }
        let chance = TUNING.beyond_chance * libm::sqrt(known + variance);
        // Ways of any inequality move the middle by half of the round trip at most.
        let bound = chance + 0.5 * round_trip.max(self.round_trip.shortest());
        if self.measurements >= TUNING.enough && libm::fabs(measured - expected) > bound {
            self.contradictions += 1;
            return;
        }
        self.contradictions = 0;
        self.noise.take(middle, measured, held_up);
        bank.observe(passed, measured, variance);
        self.at = middle;
        self.measurements = self.measurements.saturating_add(1);
    }

    /// Doubts the line by a measurement that it does not take.
    fn doubt_at(&mut self, middle: f64, measured: f64) {
        if let Some(bank) = &self.bank {
            let estimate = bank.combined();
            let passed = middle - self.at;
            let missed = measured - estimate.offset - estimate.drift * passed;
            self.doubt.take(middle, passed, missed, 0.0);
        }
    }
}

/// The pair with the lesser first number.
fn lesser(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    if other.0 < one.0 { other } else { one }
}

/// The pair with the greater first number.
fn greater(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    if other.0 > one.0 { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line, and the number of the next exchange.
    struct Exchanged {
        line: TimingLine,
        next: i64,
        /// Lead of the sender's clock, ns.
        lead: i64,
        restarts: u32,
    }

    impl Exchanged {
        fn new() -> Self {
            Self {
                line: TimingLine::new(&Self::exchange(0, 0, 0).0, 1.0, super::super::noise::KEPT),
                next: 0,
                lead: 0,
                restarts: 0,
            }
        }

        /// Makes the exchange `n` of fifty a second, by ways of 600 ns, one longer by `more` and the other one shorter; and when its
        /// response arrives.
        fn exchange(n: i64, lead: i64, more: i64) -> (TimeResponse, Instant<Local>) {
            let requested = 20_000_000 * n;
            let received = requested + 600 + more;
            let responded = received + 300_000;
            let response = TimeResponse {
                run: 0,
                number: 0,
                requested: Instant::from_nanos(requested),
                epoch: 0,
                received: Span::from_nanos(received + lead),
                responded: Span::from_nanos(responded + lead),
            };
            (response, Instant::from_nanos(responded + 600 - more))
        }

        /// Takes groups of exchanges whose middles are 100 ns early and late in turn.
        fn take(&mut self, groups: i64) {
            for _ in 0..groups * GROUP as i64 {
                let more = if self.next / GROUP as i64 % 2 == 0 {
                    100
                } else {
                    -100
                };
                let (exchange, arrived) = Self::exchange(self.next, self.lead, more);
                self.restarts += u32::from(self.line.take(arrived, &exchange));
                self.next += 1;
            }
        }
    }

    #[test]
    fn a_line_is_believed_after_a_second() {
        let mut exchanged = Exchanged::new();
        exchanged.take(7);
        assert!(!exchanged.line.is_acquired());
        exchanged.take(2);
        assert!(exchanged.line.is_acquired());
    }

    /// Swarm schedule 2932: by the rate of a line that had just begun, two ways took nothing together, and for ten seconds.
    #[test]
    fn a_rate_that_is_not_known_yet_makes_no_way_shorter() {
        for rate in [-8e-6, 8e-6] {
            let mut exchanged = Exchanged::new();
            let (first, _) = Exchanged::exchange(0, 0, 0);
            exchanged.line = TimingLine::new(&first, 1.0 + rate, super::super::noise::KEPT);
            for _ in 0..20 {
                exchanged.take(1);
                let round_trip = exchanged.line.round_trip();
                assert!(round_trip > 1_190e-9, "{round_trip}");
            }
        }
    }

    /// Swarm schedule 90447: a rate changed by as much as chance may have done, and for ten seconds two ways took less together than they do.
    #[test]
    fn a_rate_that_changes_makes_no_way_shorter() {
        let mut exchanged = Exchanged::new();
        exchanged.take(100);
        for n in 0..80 {
            // 1 ppm: 20 ns from one exchange to the next, and 140 ns within a group.
            for _ in 0..GROUP {
                let (exchange, arrived) = Exchanged::exchange(exchanged.next, exchanged.lead, 0);
                assert!(!exchanged.line.take(arrived, &exchange));
                exchanged.next += 1;
                exchanged.lead += 20;
            }
            let round_trip = exchanged.line.round_trip();
            assert!(round_trip > 1_190e-9, "{n}: {round_trip}");
        }
    }

    #[test]
    fn a_clock_that_leaps_further_than_chance_and_ways_explain_is_another_line() {
        for (leap, is_another) in [
            (1_900, false),
            (2_200, true),
            (-1_900, false),
            (-2_200, true),
        ] {
            let mut exchanged = Exchanged::new();
            exchanged.take(100);
            exchanged.lead = leap;
            exchanged.take(8);
            assert_eq!(exchanged.restarts > 0, is_another, "{leap} ns");
        }
    }
}
