//! A line through the time exchanges alone, for paths whose delay wanders.
//!
//! The [observer](crate::PhaseObserver) follows messages, and what it cannot see is a delay that wanders as slowly as a clock
//! does: the line wanders with it, and the exchanges of ten seconds, averaged, say afterwards by how much. But half of the
//! difference of the two ways of an exchange knows nothing of a delay that both have alike. So exchanges with the least round
//! trip make a line of their own, as those of a [timing channel](crate::timing) do.
//!
//! It is some ten times less sharp where delays do not wander, as there are a hundred times fewer exchanges than messages. Which
//! of both is followed is decided by how well each predicted the next exchanges: what those scatter by themselves is in
//! both alike.

use crate::delay::{DelayExchange, TimeResponse};
use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::FarLine;
use crate::timing::Steering;
use crate::timing::line::{GROUP, TimingLine};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the choice between messages and exchanges.
    TwoWayTuning {
        /// Groups that the mean squares of misses are over, …
        memory: f64 = 8.0,
        /// … and are known after this number.
        enough: f64 = 8.0,
        /// Greatest miss of messages, as a multiple of the usual one of exchanges.
        // A change that is over is forgotten in ten seconds (drift_table, "delay +1 ms in 2 s": messages had long been right again, and were not
        // followed for half a minute).
        clipped: f64 = 6.0,
        /// The exchanges are followed where messages miss them by more than this, as a multiple in squares …
        worse: f64 = 2.5,
        /// … and no longer where by less than this.
        // Where only the exchanges' own scatter counts they are equal.
        as_good: f64 = 1.25,
        /// Least miss of messages that counts, s.
        // On AR(1) delays of 15 µs they miss by 3, and exchanges lag behind a drift that changes at once.
        least: f64 = 10e-6,
        /// Least miss of messages where exchanges are followed.
        // A path that wanders returns to its mean twice in each period.
        still_least: f64 = 4e-6,
        /// Time after an event within which exchanges are not followed.
        // Nothing is compared across an event, which is attributed within this time.
        steady_for: Span = Span::from_secs(10),
        /// Time without an exchange after which the messages are followed again.
        stale_after: Span = Span::from_secs(2),
    }
}

/// Groups whose shortest round trip counts: ten seconds at ten exchanges a second. Longer ones say less.
const ROUND_TRIPS: usize = 12;

/// The line through the exchanges, and how well both lines predict.
#[derive(Clone, Debug, Default)]
pub(crate) struct TwoWay {
    line: Option<TimingLine>,
    /// The events of the line and of the path so far, and when the last one was seen.
    events: Option<Events>,
    steady_since: Option<Instant<Local>>,
    newest: Option<Instant<Local>>,
    /// Least of the ways there and back of the group that is being filled, as the delay has them, s.
    there: f64,
    back: f64,
    filled: usize,
    /// Mean squares of what messages and exchanges missed the next group by, s².
    by_messages: f64,
    by_exchanges: f64,
    groups: f64,
    in_use: bool,
}

/// The events of the line and of the path up to now. What was predicted before one is not compared with what comes after.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Events {
    epoch: u64,
    relocks: u32,
    rebases: u32,
    drift_steps: u32,
    jumped: Seconds,
    asymmetry: f64,
}

impl Events {
    const fn of(far: &FarLine, exchange: &DelayExchange) -> Self {
        Self {
            epoch: far.epoch,
            relocks: far.relocks,
            rebases: far.rebases,
            drift_steps: far.drift_steps,
            jumped: far.jumped,
            asymmetry: exchange.asymmetry(),
        }
    }
}

impl TwoWay {
    /// Forgets everything.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// True if the exchanges are followed.
    pub(crate) const fn is_in_use(&self) -> bool {
        self.in_use
    }

    /// Takes an exchange whose response arrived at `arrived`, beside the line of messages and the delay by the last exchanges.
    pub(crate) fn take(
        &mut self,
        arrived: Instant<Local>,
        response: &TimeResponse,
        far: &FarLine,
        exchange: &DelayExchange,
    ) {
        let events = Events::of(far, exchange);
        if self.events != Some(events) {
            self.forget();
            self.events = Some(events);
            self.steady_since = Some(arrived);
        }
        let (Some(delay), true) = (exchange.middle(), far.synced) else {
            return;
        };
        self.newest = Some(arrived);
        let there = far.offset_at(response.received, response.requested).0 - delay;
        let back = delay - far.offset_at(response.responded, arrived).0;
        let is_first = self.filled == 0;
        self.there = if is_first {
            there
        } else {
            self.there.min(there)
        };
        self.back = if is_first { back } else { self.back.min(back) };
        self.filled += 1;
        let line =
            (self.line).get_or_insert_with(|| TimingLine::new(response, far.rate, ROUND_TRIPS));
        // A clock leapt: the observer will notice it, too, and until then neither predicts anything.
        if line.take(arrived, response) {
            self.forget();
            self.events = Some(events);
            self.steady_since = Some(arrived);
        } else if self.filled == GROUP {
            self.filled = 0;
            self.compare(arrived);
        }
    }

    /// Compares how well both predicted a group, which is full.
    fn compare(&mut self, now: Instant<Local>) {
        let Some(missed) = self.line.as_mut().and_then(TimingLine::take_missed) else {
            return;
        };
        // Ways against the messages' line and the delay: zero, but for scatter, if both are right.
        let by_messages = 0.5 * (self.there - self.back);
        self.groups = (self.groups + 1.0).min(TUNING.memory);
        let part = 1.0 / self.groups;
        self.by_exchanges += part * (missed * missed - self.by_exchanges);
        let most = TUNING.clipped * self.by_exchanges.max(TUNING.least * TUNING.least);
        let square = (by_messages * by_messages).min(most);
        self.by_messages += part * (square - self.by_messages);
        let (times, least) = match self.in_use {
            true => (TUNING.as_good, TUNING.still_least),
            false => (TUNING.worse, TUNING.least),
        };
        // Squares on both sides, as the scatter of the exchanges themselves is in both.
        let is_better = self.by_messages > (times * self.by_exchanges).max(least * least);
        let is_steady = (self.steady_since).is_some_and(|since| now - since >= TUNING.steady_for);
        self.in_use = is_better && is_steady && self.groups >= TUNING.enough;
    }

    /// Returns the steering of far time at `now`, beside the line of messages as it is; none where that is the better one.
    /// `exchange` has the asymmetry of the ways.
    pub(crate) fn steer(
        &mut self,
        now: Instant<Local>,
        far: &FarLine,
        exchange: &DelayExchange,
        was_in_use: bool,
    ) -> Option<Steering> {
        if self.events != Some(Events::of(far, exchange)) {
            return None;
        }
        let is_fresh = (self.newest).is_some_and(|newest| now - newest <= TUNING.stale_after);
        let line = self.line.as_ref().filter(|line| line.is_acquired());
        let line = line.filter(|_| self.in_use && is_fresh && far.synced)?;
        // Only the two lines are compared without an asymmetry. Far time has it.
        let (beside, unequal) = exchange.inequality(line.round_trip());
        let ahead = far.offset_at(line.far_time(now), now).0 + beside;
        let sigma = line.sigma(now);
        Some(Steering::Channel {
            ahead: Seconds(ahead),
            uncertainty: Seconds(unequal + 3.0 * sigma + line.doubt(now)),
            sigma: Seconds(sigma),
            rate: line.rate(),
            begins: !was_in_use,
        })
    }
}
