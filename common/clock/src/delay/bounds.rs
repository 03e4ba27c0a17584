//! Bounds of the sender's lead that no exchange can contradict, whatever happened to the line.
//!
//! A request arrives no earlier than it leaves, and so does its response: with `d = S − F`, how far the
//! sender's time is ahead of the line,
//!
//! ```text
//! t3 − F(t4)  ≤  d  ≤  t2 − F(t1)
//! ```
//!
//! Exchanges that agree narrow this down; one that contradicts the newer ones is of another time, and so are all
//! before it. They are compared with the line as it is now, not as it was when they came, and widen with age by the
//! possible error of the line's rate. (This is the intersection that Marzullo's algorithm makes of several servers,
//! made of one server at several times.)

use super::COVERED;
use super::trend::Trend;
use super::window::{Exchange, ExchangeStamps, Recent};
use crate::instant::{Instant, Local, Seconds};
use crate::observer::FarLine;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the bounds.
    BoundsTuning {
        /// Rate change of a clock that may not be noticed yet, s/s.
        // A quartz in a draught.
        unknown_rate: f64 = 1e-6,
        /// Change of a drift that may not be noticed yet, s/s.
        // Random schedules: a line that was 200 ppm wrong with a reported 5.
        unnoticed_rate: f64 = 200e-6,
        /// Largest possible drift, s/s, of a line that has not measured it yet.
        largest_rate: f64 = 2e-3,
        /// A line whose rate is no surer than this has not measured it.
        // It knows no more than what quartzes are usually like.
        unmeasured: f64 = 16e-6,
        /// Time, s, after which exchanges have tested the rate of a line.
        // Most of the ten seconds that are kept.
        tested: f64 = 8.0,
    }
}

/// Returns the correction of a delay, s, with which no recent exchange denies it, even if the rate of the line should be
/// quite wrong.
pub(super) fn pull(delay: f64, recent: &Recent<'_>) -> f64 {
    // A rate that may be 200 ppm wrong. At that of the line a change of its drift would move the delay before it is noticed.
    let Some(Agreeing { least, most, .. }) = Agreeing::of(recent, TUNING.unnoticed_rate, 0.0)
    else {
        return 0.0;
    };
    match least.ahead <= most.ahead {
        true => delay.clamp(least.ahead, most.ahead) - delay,
        // A single exchange that denies itself.
        false => 0.0,
    }
}

/// Bounds that recent exchanges leave open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Stamps whose response limits the sender's lead from below.
    least: ExchangeStamps,
    /// Stamps whose request limits the sender's lead from above.
    most: ExchangeStamps,
    /// Possible error of the rate beside what the line knows of it, s/s.
    doubt: f64,
    /// Proof that the line is at another rate than the sender: no path can do that.
    proven: Option<Trend>,
}

impl Bounds {
    /// Finds the bounds; none if there are no exchanges.
    pub(super) fn of(recent: &Recent<'_>) -> Option<Self> {
        let level = Agreeing::of(recent, 0.0, 0.0)?;
        let trend = Trend::of(recent);
        let trend = match level.contradicted {
            // Some rate makes them agree, however jittery the exchanges are that no trend is certain of.
            true => trend.or_else(|| Trend::left_open(recent)),
            false => trend,
        };
        let Some(trend) = trend else {
            let doubt = if !level.contradicted && recent.span() >= TUNING.tested {
                0.0
            } else if recent.line.rate_sigma >= TUNING.unmeasured {
                TUNING.largest_rate
            } else {
                TUNING.unnoticed_rate
            };
            return Some(Agreeing::of(recent, doubt, 0.0)?.bounds(doubt, None));
        };
        let agree = || Agreeing::of(recent, trend.sigma, trend.gain);
        let is_proven = recent.line.synced
            && trend.may_prove()
            // A slope alone may be a path whose ways change differently. No path brings a response before its request.
            && level.contradicted
            && agree().is_some_and(|all| !all.contradicted);
        let doubted = Agreeing::of(recent, trend.most(), 0.0)?;
        Some(doubted.bounds(trend.most(), is_proven.then_some(trend)))
    }

    /// Returns the least and the greatest lead of the sender over the line at `now`, s.
    pub(super) fn at(&self, now: Instant<Local>, line: &FarLine) -> (f64, f64) {
        let Self { least, most, .. } = self;
        let rate = rate_doubt(line, self.doubt);
        let Seconds(at_least) = line.offset_at(least.responded, least.arrived);
        let Seconds(at_most) = line.offset_at(most.received, most.requested);
        (
            at_least - rate * (now - least.arrived).as_secs_f64(),
            at_most + rate * (now - most.requested).as_secs_f64(),
        )
    }

    /// Drops the proof that the line is wrong.
    pub(super) fn unproven(self) -> Self {
        Self {
            proven: None,
            ..self
        }
    }

    /// Takes the sender's gain on the line per second, if the line is proven wrong, and the standard deviation of
    /// that; once.
    pub(super) fn take_proven_gain(&mut self) -> Option<(f64, f64)> {
        self.proven.take().map(|trend| (trend.gain, trend.sigma))
    }
}

/// Possible error of the rate of the line, s/s.
fn rate_doubt(line: &FarLine, doubt: f64) -> f64 {
    COVERED * line.rate_sigma + TUNING.unknown_rate + doubt
}

/// Exchanges that agree, from the newest on.
struct Agreeing {
    least: Limit,
    most: Limit,
    /// True if an older one does not agree.
    contradicted: bool,
}

/// Sender's lead over the line by one exchange, s.
#[derive(Clone, Copy)]
struct Limit {
    ahead: f64,
    stamps: ExchangeStamps,
}

impl Agreeing {
    /// The rate of the line may be wrong by `doubt` beside what it knows of that, and the sender gains on it, s/s.
    fn of(recent: &Recent<'_>, doubt: f64, gain: f64) -> Option<Self> {
        let rate = rate_doubt(recent.line, doubt);
        let limits = |exchange: &Exchange| {
            let stamps = exchange.stamps;
            let since = |at: Instant<Local>| (recent.now - at).as_secs_f64();
            let (requested, arrived) = (since(stamps.requested), since(stamps.arrived));
            let least = -exchange.back + gain * arrived - rate * arrived;
            let most = exchange.there + gain * requested + rate * requested;
            [least, most].map(|ahead| Limit { ahead, stamps })
        };
        // From the newest on: one that contradicts it is of a time before some event.
        let mut newest_first = recent.exchanges.iter().map(limits);
        let [least, most] = newest_first.next()?;
        let mut agreeing = Self {
            least,
            most,
            contradicted: false,
        };
        for [least, most] in newest_first {
            if least.ahead > agreeing.most.ahead || most.ahead < agreeing.least.ahead {
                agreeing.contradicted = true;
                break;
            }
            if least.ahead > agreeing.least.ahead {
                agreeing.least = least;
            }
            if most.ahead < agreeing.most.ahead {
                agreeing.most = most;
            }
        }
        Some(agreeing)
    }

    const fn bounds(&self, doubt: f64, proven: Option<Trend>) -> Bounds {
        Bounds {
            least: self.least.stamps,
            most: self.most.stamps,
            doubt,
            proven,
        }
    }
}
