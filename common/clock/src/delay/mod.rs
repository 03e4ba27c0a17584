//! Zero lag: the constant part of a link's delay, by time requests and responses.
//!
//! One-way messages show how a far clock runs, but not how long they were under way: the line that a
//! [`PhaseObserver`](crate::PhaseObserver) finds lies behind the sender's own time by a constant. So the receiver
//! sends a time request now and then, and the sender responds. Each of the two messages is stamped when it leaves and
//! when it arrives:
//!
//! ```text
//! sender     ────────── t2 ─── t3 ──────────▶ S, sent as spans since its cycle 0
//!                     ↗          ↘
//! receiver   ─────── t1           t4 ───────▶ local, where the line F is known
//! ```
//!
//! With `d = S − F`, how far the sender's time is ahead of the line,
//!
//! ```text
//! there = t2 − F(t1) = d + way there        back = F(t4) − t3 = −d + way back
//! ```
//!
//! Jitter only lengthens a way, so the early ones over the last exchanges count, and
//! `d = (early there − early back) / 2`, where one in 32 of the ways is not longer than the early one.
//! That takes the two ways for equally long. Whatever they are in truth, neither is shorter than nothing, so the
//! error is at most half of the least round trip, `(least there + least back) / 2`, and by how much the early ones
//! differ from that: the uncertainty. (RFC 5905 reasons alike; as the line takes the drift out, the two ways need not
//! be of the same exchange.)

mod bounds;
mod drift;
mod estimate;
mod known;
mod line;
mod outcome;
mod step;
#[cfg(test)]
mod tests;
mod trend;
mod window;

pub use outcome::{Asymmetry, DelayOutput, DelayState, Refusal};

use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::{FarLine, SuspectedDrift};
use crate::tuning::tuning;
use bounds::Bounds;
use drift::Whose;
use estimate::Estimate;
use step::Step;
use window::{Exchange, ExchangeStamps, Window};

tuning! {
    /// Tuned constants of the exchange.
    ExchangeTuning {
        /// Interval of requests as long as little is known …
        // Eight exchanges, which attribute a step, take 0.16 s.
        fast_interval: Span = Span::from_millis(20),
        /// … and later, or without responses.
        // Ten a second for the drift of ten seconds.
        slow_interval: Span = Span::from_millis(100),
        /// Exchanges after an event until which the interval is short …
        // One in 32 of them is early.
        fast_exchanges: usize = 48,
        /// … and the greatest number of requests for that, where responses are lost.
        fast_requests: u32 = 128,
        /// Exchanges that make a measurement; and the estimate before an event is held until then.
        enough: usize = 16,
        /// Time without an exchange after which the measurement is stale.
        stale_after: Span = Span::from_secs(3),
        /// Longest way, and greatest lead of a sender.
        // An exchange beyond it is wrong.
        longest: Span = Span::from_secs(1),
        /// Error of the line's rate while it locks, s/s; see `ROUNDING`, too.
        rate_tolerance: f64 = 1e-3,
        /// Age from which an exchange says nothing of the present path.
        longest_age: Span = Span::from_secs(10),
    }
}

/// Standard deviations of the line that the uncertainty covers.
const COVERED: f64 = 3.0;
/// Error of a round trip by rounding, s.
// Not tuned: four stamps of whole nanoseconds are off by 4 ns at most, and a lie is larger.
const ROUNDING: f64 = 10e-9;

/// A sender's response. Every stamp was taken as near to the wire as the machines allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeResponse {
    /// The run of the requester, as the request said.
    pub run: u64,
    /// Number of the request.
    pub number: u32,
    /// Departure of the request, in the requester's clock: `t1`.
    pub requested: Instant<Local>,
    /// The run of the sender.
    pub epoch: u64,
    /// Arrival of the request, in the sender's clock since the ideal start of its cycle 0: `t2`.
    pub received: Span,
    /// Departure of the response, likewise: `t3`.
    pub responded: Span,
}

/// Measures how far a sender's time is ahead of the line that an observer follows.
///
/// Call [`follow`](Self::follow) once per cycle, [`ask`](Self::ask) after it, and
/// [`take`](Self::take) for each response. Nothing allocates.
#[derive(Clone, Debug)]
pub struct DelayExchange {
    run: u64,
    /// The number of the next request.
    next: u32,
    /// First request of the window: one before it spans an event.
    first: u32,
    /// Bit n: request `next − 1 − n` waits for its response.
    open: u64,
    next_request: Instant<Local>,
    /// Requests since the last event.
    fast_requests: u32,
    window: Window,
    /// Exchanges like `window`, but not cleared by events.
    history: Window,
    /// True while the cause of a change of the drift is wanted.
    is_asked: bool,
    sender: Option<Sender>,
    estimate: Option<Estimate>,
    /// Bounds by all recent exchanges.
    bounds: Option<Bounds>,
    /// Correction of the estimate by those, s.
    pulled: f64,
    /// True if the line was lost, and no exchange was measured against the one that was found.
    is_of_lost_line: bool,
    /// Step of the line that is not attributed yet.
    step: Option<Step>,
    /// Step attributed to the sender, until it is taken, s.
    step_of_sender: Option<Seconds>,
    /// Change of half of the difference of the two ways since the start, by steps that were the path's, s.
    asymmetry: f64,
    /// Asymmetry of the ways at the start, if stated.
    stated: Option<Asymmetry>,
    exchanges: u64,
    refused: u64,
}

/// The number of the first request: their numbers wrap within seconds of every run, not after thirteen years of one.
const FIRST_REQUEST: u32 = u32::MAX - 63;

/// Run of the sender, and what was known of its line.
#[derive(Clone, Copy, Debug)]
struct Sender {
    epoch: u64,
    jumped: Seconds,
    corrected: Seconds,
    taken_back: Seconds,
    drift_steps: u32,
    rebases: u32,
    relocks: u32,
    synced: bool,
}

impl DelayExchange {
    /// Makes an exchange without requests as yet. `run` distinguishes this run of the requester from others.
    #[must_use]
    pub const fn new(run: u64) -> Self {
        Self {
            run,
            next: FIRST_REQUEST,
            first: FIRST_REQUEST,
            open: 0,
            next_request: Instant::from_nanos(i64::MIN),
            fast_requests: 0,
            window: Window::new(),
            history: Window::new(),
            is_asked: false,
            sender: None,
            estimate: None,
            bounds: None,
            pulled: 0.0,
            is_of_lost_line: false,
            step: None,
            step_of_sender: None,
            asymmetry: 0.0,
            stated: None,
            exchanges: 0,
            refused: 0,
        }
    }

    /// States the asymmetry of the two ways, or takes them for equally long again. The change shows at once.
    pub const fn state_asymmetry(&mut self, stated: Option<Asymmetry>) {
        self.stated = stated;
    }

    /// Forgets the measurements and measures again.
    pub fn restart(&mut self) {
        self.forget();
        self.sender = None;
    }

    /// Returns the number of the request that is due, if one is. Needs a line to measure against.
    pub fn ask(&mut self, now: Instant<Local>) -> Option<u32> {
        if self.sender.is_none() || now < self.next_request {
            return None;
        }
        let is_fast = self.is_asked
            || self.window.len() < TUNING.fast_exchanges
                && self.fast_requests < TUNING.fast_requests;
        self.fast_requests = self.fast_requests.saturating_add(1);
        self.next_request = now
            + if is_fast {
                TUNING.fast_interval
            } else {
                TUNING.slow_interval
            };
        let number = self.next;
        self.next = self.next.wrapping_add(1);
        // A bit for each of the last 64 requests: at 50 a second a response may take 1.3 s, longer than `longest`.
        self.open = self.open << 1 | 1;
        Some(number)
    }

    /// Takes a response that arrived at `arrived`, measured against the line as it is now.
    ///
    /// # Errors
    /// [`Refusal`], the first reason that applies; the response is counted and not used.
    pub fn take(
        &mut self,
        response: &TimeResponse,
        arrived: Instant<Local>,
        line: &FarLine,
    ) -> Result<(), Refusal> {
        let checked = self.check(response, arrived, line);
        // Kept across events, too: whatever the line is, a response arrives after its request.
        if let Ok(exchange) = checked {
            self.history.push(exchange);
        }
        match checked {
            // Its request left before the event, and its response after it: it fits neither line.
            Ok(_) if (response.number.wrapping_sub(self.first) as i32) < 0 => {}
            Ok(exchange) => {
                self.exchanges = self.exchanges.saturating_add(1);
                self.window.push(exchange);
                self.is_of_lost_line = false;
                self.attribute(&exchange);
                if !line.synced {
                    self.measure_again(line);
                }
                self.estimate(arrived, line);
                self.bound(arrived, line);
            }
            Err(_) => self.refused = self.refused.saturating_add(1),
        }
        checked.map(|_| ())
    }

    /// Reports whether messages that come later and later are due to the sender's clock (true) or to the path, once
    /// exchanges show it. Until then requests go out at the fast interval.
    pub fn is_drift_of_sender(&mut self, suspected: Option<&SuspectedDrift>) -> Option<bool> {
        let told = suspected.and_then(|suspected| drift::whose(suspected, self.history.all()));
        let is_new = suspected.is_some() && !self.is_asked;
        self.is_asked = suspected.is_some() && told.is_none();
        if is_new && self.is_asked {
            // At once, as the slope of the ways is known the sooner.
            self.next_request = Instant::from_nanos(i64::MIN);
        }
        told.map(|whose| whose == Whose::Sender)
    }

    /// Takes the sender's gain on the line per second, s/s, and the standard deviation of that, once exchanges prove
    /// the line wrong; each time once. To be passed to [`PhaseObserver::follow_drift`].
    ///
    /// [`PhaseObserver::follow_drift`]: crate::PhaseObserver::follow_drift
    pub fn proven_gain(&mut self) -> Option<(f64, f64)> {
        self.bounds.as_mut()?.take_proven_gain()
    }

    /// The delay, once there is one: how far the sender's time is ahead of the line.
    #[must_use]
    pub fn delay(&self) -> Option<Span> {
        self.estimate
            .map(|estimate| Span::from_secs_f64(self.delay_of(&estimate)))
    }

    /// Reports the delay at `now`, of the line as it is then.
    pub fn output(&self, now: Instant<Local>, line: &FarLine) -> DelayOutput {
        let blank = DelayOutput {
            state: DelayState::Asking,
            exchanges: self.exchanges,
            refused: self.refused,
            ..DelayOutput::default()
        };
        let Some(estimate) = &self.estimate else {
            return blank;
        };
        let age = now - estimate.newest;
        DelayOutput {
            state: match estimate.measured {
                false => DelayState::Asking,
                true if age > TUNING.stale_after || self.is_of_lost_line => DelayState::Stale,
                true => DelayState::Measured,
            },
            delay: Some(Seconds(self.delay_of(estimate))),
            uncertainty: Some(Seconds(self.uncertainty(estimate, now, line))),
            is_statement_denied: self.is_statement_denied(estimate, line),
            jitter: Some(Seconds(estimate.jitter)),
            sigma: Some(Seconds(known::sigma(estimate, line))),
            age: Some(age),
            ..blank
        }
    }

    fn check(
        &mut self,
        response: &TimeResponse,
        arrived: Instant<Local>,
        line: &FarLine,
    ) -> Result<Exchange, Refusal> {
        if response.run != self.run {
            return Err(Refusal::OtherRun);
        }
        if response.epoch != line.epoch {
            return Err(Refusal::OtherEpoch);
        }
        let back = self.next.wrapping_sub(1).wrapping_sub(response.number);
        // A shift by 64 would overflow, and older requests are closed anyway.
        let request = if back < 64 { 1 << back } else { 0 };
        if self.open & request == 0 {
            return Err(Refusal::NotAsked);
        }
        // A second response to one request is refused, from any sender.
        self.open &= !request;
        let passed = arrived - response.requested;
        if !(Span::ZERO..=TUNING.longest).contains(&passed)
            || response.responded < response.received
        {
            return Err(Refusal::Implausible);
        }
        let stamps = ExchangeStamps {
            requested: response.requested,
            received: response.received,
            responded: response.responded,
            arrived,
        };
        let exchange = Exchange::measured(stamps, line);
        let longest = Seconds::from(TUNING.longest).0;
        // Stamps of a clock that leapt, or of somebody who makes them up.
        if libm::fabs(exchange.there) > longest || libm::fabs(exchange.back) > longest {
            return Err(Refusal::Implausible);
        }
        // The sender's lead cancels in the sum, so whatever is below zero is an error of the line's rate, or a lie.
        let round_trip = exchange.there + exchange.back;
        if round_trip < -(TUNING.rate_tolerance * passed.as_secs_f64() + ROUNDING) {
            return Err(Refusal::NegativeRoundTrip);
        }
        Ok(exchange)
    }

    /// Merges the window's estimate with the one before.
    fn estimate(&mut self, now: Instant<Local>, line: &FarLine) {
        let Some((there, back)) = self.window.early(line) else {
            return;
        };
        let enough = self.window.len() >= TUNING.enough;
        let seen = Estimate::of(&there, &back, now, enough).beside(self.asymmetry);
        self.estimate = Some(match &self.estimate {
            Some(before) => before.after(seen),
            None => seen,
        });
    }

    /// Measures the exchanges again while the line is unsure and moves under them.
    fn measure_again(&mut self, line: &FarLine) {
        self.window.measure_again(line);
        if let Some(estimate) = &mut self.estimate {
            estimate.be_replaced();
        }
    }

    const fn ask_fast(&mut self) {
        self.fast_requests = 0;
        self.next_request = Instant::from_nanos(i64::MIN);
    }

    /// Clears the window, and fills it again at the fast interval.
    fn start_over(&mut self) {
        self.window.clear();
        self.first = self.next;
        self.bounds = None;
        self.pulled = 0.0;
        self.step = None;
        self.ask_fast();
        if let Some(estimate) = &mut self.estimate {
            estimate.be_replaced();
        }
    }

    fn forget(&mut self) {
        self.start_over();
        self.history.clear();
        self.estimate = None;
        self.step_of_sender = None;
        self.asymmetry = 0.0;
        self.is_of_lost_line = false;
        self.open = 0;
    }
}

#[cfg(feature = "perturb")]
pub(crate) const ALL_TUNED: &[crate::tuning::TunedBlock] = &[
    TUNED,
    bounds::TUNED,
    drift::TUNED,
    estimate::TUNED,
    step::TUNED,
    trend::TUNED,
    window::TUNED,
];
