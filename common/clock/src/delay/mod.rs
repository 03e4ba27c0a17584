//! Zero lag: the constant part of a link's delay, by time requests and responses.
//!
//! One-way messages show how a far clock runs, but not how long they were under way: the line that
//! a [`PhaseObserver`](crate::PhaseObserver) finds lies behind the sender's own time by a constant. So
//! the receiver asks now and then, and the sender responds. Each of the two messages is stamped when
//! it leaves and when it arrives:
//!
//! ```text
//! sender     ────────── t2 ─── t3 ──────────▶ S, told as spans since its cycle 0
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
//! That takes the two ways for equally long. Whatever they are in truth, neither is shorter than
//! nothing, so the error is at most half of the least round trip, `(least there + least back) / 2`, and
//! by how much the early ones differ from that: the uncertainty. (RFC 5905 reasons alike; as the line
//! takes the drift out, the two ways need not be of the same exchange.)

mod bounds;
mod drift;
mod estimate;
mod known;
mod outcome;
mod step;
#[cfg(test)]
mod tests;
mod trend;
mod window;

pub use outcome::{Asymmetry, DelayOutput, DelayState, Refusal};

use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::{FarLine, SuspectedDrift};
use bounds::Bounds;
use drift::Whose;
use estimate::Estimate;
use step::{Cause, Step, TELLING, Ways};
use window::{Exchange, Stamps, Window};

/// Between two requests as long as little is known …
const HASTE: Span = Span::from_millis(20);
/// … and later, or where nobody responds.
const LEISURE: Span = Span::from_millis(100);
/// After an event it is in haste until so many exchanges came, for so many requests at most.
const PLENTY: usize = 48;
const HASTY_QUESTIONS: u32 = 128;
/// So many exchanges make a measurement; and what was known before an event is held until then.
const ENOUGH: usize = 16;
/// Without an exchange for so long the measurement is stale.
const STALE_AFTER: Span = Span::from_secs(3);
/// No way is longer, and no sender further ahead: what says so is wrong.
const LONGEST: Span = Span::from_secs(1);
/// What the line's rate can be wrong by while it locks, s/s, and what rounding adds, s.
const RATE_TOLERANCE: f64 = 1e-3;
const ROUNDING: f64 = 10e-9;
/// The uncertainty covers so many standard deviations of the line.
const COVERED: f64 = 3.0;
/// An exchange that is older says nothing of the present path.
const LONGEST_AGE: Span = Span::from_secs(10);

/// A sender's response. Every stamp was taken as near to the wire as the machines allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeResponse {
    /// The run of the requester, as the request said.
    pub run: u64,
    /// Which request.
    pub number: u32,
    /// When the request left, in the requester's clock: `t1`.
    pub requested: Instant<Local>,
    /// The run of the sender.
    pub epoch: u64,
    /// When the request arrived, in the sender's clock since the ideal start of its cycle 0: `t2`.
    pub received: Span,
    /// When the response left, likewise: `t3`.
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
    /// The first request of the window: what was asked before it spans an event.
    first: u32,
    /// Bit n: request `next − 1 − n` waits for its response.
    open: u64,
    next_request: Instant<Local>,
    /// Requests since the last event.
    hasty: u32,
    window: Window,
    /// The same, but events do not clear it.
    history: Window,
    /// Somebody wants to know whose a change of the drift is.
    is_asked: bool,
    sender: Option<Sender>,
    estimate: Option<Estimate>,
    /// Between what all recent exchanges have it.
    bounds: Option<Bounds>,
    /// By how much that moves the estimate, s.
    pulled: f64,
    /// The line was lost, and no exchange was measured against the one that was found.
    is_of_lost_line: bool,
    /// A step of the line of which nobody knows yet whose it was.
    step: Option<Step>,
    /// One that was the sender's, until it is asked for, s.
    step_of_sender: Option<Seconds>,
    /// By how much half of the difference of the two ways has changed since the start, by steps that were the
    /// path's, s.
    asymmetry: f64,
    /// What it was at the start, as somebody knows.
    stated: Option<Asymmetry>,
    exchanges: u64,
    refused: u64,
}

/// The number of the first request: their numbers wrap within seconds of every run, not after thirteen years of one.
const FIRST_REQUEST: u32 = u32::MAX - 63;

/// The run of the sender that is asked, and what was known of its line.
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
    /// An exchange that has asked nothing yet. `run` tells this run of the requester from others.
    #[must_use]
    pub const fn new(run: u64) -> Self {
        Self {
            run,
            next: FIRST_REQUEST,
            first: FIRST_REQUEST,
            open: 0,
            next_request: Instant::from_nanos(i64::MIN),
            hasty: 0,
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

    /// Takes it from somebody who knows how unequal the two ways are, or for equally long again. What changes by that shows at
    /// once.
    pub const fn state_asymmetry(&mut self, stated: Option<Asymmetry>) {
        self.stated = stated;
    }

    /// Forgets what was measured and measures anew.
    pub fn restart(&mut self) {
        self.forget();
        self.sender = None;
    }

    /// Looks at what became of the line. A new run of the sender: all is forgotten. A jump is taken
    /// for the path's doing, so that the sender's time stays where it was, until the next exchanges
    /// say otherwise (see [`step_of_sender`](Self::step_of_sender)); it is returned, and
    /// [`PhaseObserver::attribute_step_to_path`] is to be told.
    ///
    /// [`PhaseObserver::attribute_step_to_path`]: crate::PhaseObserver::attribute_step_to_path
    pub fn follow(&mut self, line: &FarLine) -> Option<Seconds> {
        let now = Sender {
            epoch: line.epoch,
            jumped: line.jumped,
            corrected: line.corrected,
            taken_back: line.taken_back,
            drift_steps: line.drift_steps,
            rebases: line.rebases,
            relocks: line.relocks,
            synced: line.synced,
        };
        let before = match self.sender.replace(now) {
            Some(before) if before.epoch == now.epoch => before,
            _ => {
                self.forget();
                return None;
            }
        };
        if now.drift_steps != before.drift_steps {
            return self.follow_drift_step(now.taken_back - before.taken_back, line);
        }
        let jump = now.jumped - before.jumped;
        let corrected = now.corrected - before.corrected;
        let is_rebased = now.rebases != before.rebases;
        if jump != Seconds::ZERO {
            let (usual, newest) = (self.window.usual(line), self.window.newest(line));
            let step = self
                .step_of(jump, usual.zip(newest))
                .filter(|_| !is_rebased);
            // What exchanges leave open goes along with the line, until newer ones say something.
            let (bounds, pulled) = (self.bounds, self.pulled);
            self.start_over();
            (self.bounds, self.pulled) = (bounds, pulled);
            self.step = step;
            let estimate = self.estimate.as_mut()?;
            if let Some(usual) = usual {
                estimate.forget_spanning(jump.0, usual.delay() + self.asymmetry);
            }
            estimate.follow_jump(jump.0);
            estimate.delay += corrected.0;
            return Some(jump + corrected);
        }
        if corrected != Seconds::ZERO {
            // The exchanges are corrected with the line: the sender's time stays where it was.
            let estimate = self.estimate.as_mut()?;
            estimate.delay += corrected.0;
            return Some(corrected);
        }
        if is_rebased || now.relocks != before.relocks {
            // What was measured against a line that is gone is no help any more.
            self.start_over();
            self.asymmetry = 0.0;
            self.is_of_lost_line = now.relocks != before.relocks;
        } else if now.synced && !before.synced {
            self.measure_again(line);
            if let Some(estimate) = &self.estimate {
                self.estimate(estimate.newest, line);
            }
            self.hurry();
        }
        None
    }

    /// The number of the request that is due, if one is. Once there is a line to measure against.
    pub fn ask(&mut self, now: Instant<Local>) -> Option<u32> {
        if self.sender.is_none() || now < self.next_request {
            return None;
        }
        let hurried = self.is_asked || self.window.len() < PLENTY && self.hasty < HASTY_QUESTIONS;
        self.hasty = self.hasty.saturating_add(1);
        self.next_request = now + if hurried { HASTE } else { LEISURE };
        let number = self.next;
        self.next = self.next.wrapping_add(1);
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

    /// Whether messages that come later and later are the doing of the sender's clock (or of the path), once exchanges
    /// tell. Until then they are made in haste.
    pub fn is_drift_of_sender(&mut self, suspected: Option<&SuspectedDrift>) -> Option<bool> {
        let told = suspected.and_then(|suspected| drift::whose(suspected, self.history.all()));
        let is_new = suspected.is_some() && !self.is_asked;
        self.is_asked = suspected.is_some() && told.is_none();
        if is_new && self.is_asked {
            self.next_request = Instant::from_nanos(i64::MIN);
        }
        told.map(|whose| whose == Whose::Sender)
    }

    /// By how much the sender gains on the line per second, s/s, and the standard deviation of that, once exchanges
    /// prove the line wrong; each time once. [`PhaseObserver::follow_drift`] is to be told.
    ///
    /// [`PhaseObserver::follow_drift`]: crate::PhaseObserver::follow_drift
    pub fn proven_gain(&mut self) -> Option<(f64, f64)> {
        self.bounds.as_mut()?.take_proven_gain()
    }

    /// Whether exchanges will tell of a step of the line at `now` whether it was the path's or the sender's.
    #[must_use]
    pub fn can_attribute(&self, now: Instant<Local>) -> bool {
        let is_fresh = |estimate: &Estimate| now - estimate.newest <= STALE_AFTER;
        let compares = self.step.is_some() || self.window.len() >= TELLING;
        compares && self.estimate.as_ref().is_some_and(is_fresh)
    }

    /// A step of the line that was taken for the path's until exchanges said that the sender's clock stood
    /// still for so long, or leapt; each once. [`PhaseObserver::attribute_step_to_sender`] is to be told, and
    /// what that says goes to [`map_step_of_sender`](Self::map_step_of_sender).
    ///
    /// [`PhaseObserver::attribute_step_to_sender`]: crate::PhaseObserver::attribute_step_to_sender
    pub const fn step_of_sender(&mut self) -> Option<Seconds> {
        self.step_of_sender.take()
    }

    /// So much of a step of the sender went into the map from counts to far time; the rest is slewed.
    pub fn map_step_of_sender(&mut self, mapped: Span) {
        let (Some(estimate), Some(sender)) = (&mut self.estimate, &mut self.sender) else {
            return;
        };
        if mapped != Span::ZERO {
            estimate.take_back(mapped.as_secs_f64());
            // The sender moved with the line, so what was measured against it holds.
            sender.rebases = sender.rebases.saturating_add(1);
        }
    }

    /// The delay, once there is one: how far the sender's time is ahead of the line.
    #[must_use]
    pub fn delay(&self) -> Option<Span> {
        self.estimate
            .map(|estimate| Span::from_secs_f64(self.delay_of(&estimate)))
    }

    /// What is known at `now`, of the line as it is then.
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
                true if age > STALE_AFTER || self.is_of_lost_line => DelayState::Stale,
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
        let request = if back < 64 { 1 << back } else { 0 };
        if self.open & request == 0 {
            return Err(Refusal::NotAsked);
        }
        self.open &= !request;
        let passed = arrived - response.requested;
        if !(Span::ZERO..=LONGEST).contains(&passed) || response.responded < response.received {
            return Err(Refusal::Implausible);
        }
        let stamps = Stamps {
            requested: response.requested,
            received: response.received,
            responded: response.responded,
            arrived,
        };
        let exchange = Exchange::measured(stamps, line);
        let longest = Seconds::from(LONGEST).0;
        if libm::fabs(exchange.there) > longest || libm::fabs(exchange.back) > longest {
            return Err(Refusal::Implausible);
        }
        let round_trip = exchange.there + exchange.back;
        if round_trip < -(RATE_TOLERANCE * passed.as_secs_f64() + ROUNDING) {
            return Err(Refusal::NegativeRoundTrip);
        }
        Ok(exchange)
    }

    /// What the window says, beside what was known before.
    fn estimate(&mut self, now: Instant<Local>, line: &FarLine) {
        let Some((there, back)) = self.window.early(line) else {
            return;
        };
        let enough = self.window.len() >= ENOUGH;
        let seen = Estimate::of(&there, &back, now, enough).beside(self.asymmetry);
        self.estimate = Some(match &self.estimate {
            Some(before) => before.after(seen),
            None => seen,
        });
    }

    /// A step of the line that exchanges will tell of, if enough came before it.
    fn step_of(&self, jump: Seconds, before: Option<(Ways, Ways)>) -> Option<Step> {
        match &self.step {
            Some(step) => Some(step.again(jump.0)),
            None => before.map(|(usual, newest)| Step::new(jump.0, usual, newest)),
        }
    }

    /// The line is another one, and has not jumped by so much, but changed its drift. Against another line the delay that
    /// was known may be anything that exchanges leave open.
    fn follow_drift_step(&mut self, taken_back: Seconds, line: &FarLine) -> Option<Seconds> {
        self.start_over();
        let estimate = self.estimate.as_mut()?;
        estimate.take_back(taken_back.0);
        self.bound_by_history(line);
        Some(Seconds::ZERO - taken_back)
    }

    /// What an exchange says of whose the last step was.
    fn attribute(&mut self, exchange: &Exchange) {
        let ways = Ways {
            there: exchange.there,
            back: exchange.back,
        };
        let cause = self.step.as_mut().and_then(|step| step.take(ways));
        match cause {
            None => return,
            Some(Cause::Sender(step)) => self.step_of_sender = Some(Seconds(step)),
            Some(Cause::Path { asymmetry }) => self.asymmetry += asymmetry,
        }
        self.step = None;
    }

    /// While the line is unsure it moves under what was measured against it.
    fn measure_again(&mut self, line: &FarLine) {
        self.window.measure_again(line);
        if let Some(estimate) = &mut self.estimate {
            estimate.be_replaced();
        }
    }

    const fn hurry(&mut self) {
        self.hasty = 0;
        self.next_request = Instant::from_nanos(i64::MIN);
    }

    /// The window begins anew, and is filled in haste.
    fn start_over(&mut self) {
        self.window.clear();
        self.first = self.next;
        self.bounds = None;
        self.pulled = 0.0;
        self.step = None;
        self.hurry();
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
