//! What no exchange can deny, whatever became of the line.
//!
//! A request arrives no earlier than it leaves, and so does its response: with `d = S − F`, how far the
//! sender's time is ahead of the line,
//!
//! ```text
//! t3 − F(t4)  ≤  d  ≤  t2 − F(t1)
//! ```
//!
//! Exchanges that agree narrow this down; one that contradicts the newer ones is of another time, and so are
//! all before it. They are compared with the line as it is now, not as it was when they came, and grow wider
//! with their age by what the rate of the line may be wrong by. (This is the intersection that Marzullo's
//! algorithm makes of several servers, of one server at several times.)

use super::COVERED;
use super::trend::Trend;
use super::window::{Exchange, Stamps};
use crate::instant::{Instant, Local, Seconds};
use crate::observer::FarLine;

/// A clock may run differently by so much, s/s, and nobody knows of it yet: a quartz in a draught.
const UNKNOWN_RATE: f64 = 1e-6;

/// A drift may have changed by so much, s/s, as long as nobody has noticed yet.
const UNNOTICED_RATE: f64 = 200e-6;

/// By how much a delay, s, is to be moved for none of the recent exchanges, given the newest first, to deny it at `now`,
/// even if the rate of the line should be quite wrong.
pub(super) fn pull<'a>(
    delay: f64,
    newest_first: impl Iterator<Item = &'a Exchange>,
    now: Instant<Local>,
    line: &FarLine,
) -> f64 {
    let agreeing = Agreeing::of(newest_first, now, line, UNNOTICED_RATE);
    let Some(Agreeing { bounds, .. }) = agreeing else {
        return 0.0;
    };
    let (least, most) = bounds.at(now, line);
    match least <= most {
        true => delay.clamp(least, most) - delay,
        // A single exchange that denies itself.
        false => 0.0,
    }
}

/// What recent exchanges leave open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Its response says that the sender is ahead by no less.
    least: Stamps,
    /// Its request says that the sender is ahead by no more.
    most: Stamps,
    /// What the rate may be wrong by beside what the line knows of it, s/s.
    doubt: f64,
    /// The line is at another rate than the sender: no path can do that.
    proven: Option<Trend>,
}

impl Bounds {
    /// What exchanges say at `now`, given the newest first; none if there are none.
    pub(super) fn of<'a>(
        newest_first: impl Iterator<Item = &'a Exchange> + Clone,
        now: Instant<Local>,
        line: &FarLine,
    ) -> Option<Self> {
        let level = Agreeing::of(newest_first.clone(), now, line, 0.0)?;
        let Some(trend) = Trend::of(newest_first.clone(), now, line) else {
            return Some(level.bounds);
        };
        let tilted = FarLine {
            rate: line.rate + trend.gain,
            far: line.at(now),
            here: now,
            ..*line
        };
        let agrees = || Agreeing::of(newest_first.clone(), now, &tilted, trend.sigma);
        let is_proven = line.synced
            && trend.may_prove()
            && level.contradicted
            && agrees().is_some_and(|all| !all.contradicted);
        let doubted = Agreeing::of(newest_first, now, line, trend.most())?;
        Some(Self {
            proven: is_proven.then_some(trend),
            ..doubted.bounds
        })
    }

    /// How far the sender is ahead of the line at least and at most at `now`, s.
    pub(super) fn at(&self, now: Instant<Local>, line: &FarLine) -> (f64, f64) {
        (
            least(&self.least, now, line, self.doubt),
            most(&self.most, now, line, self.doubt),
        )
    }

    /// By how much the sender gains on the line per second, if the line is proven wrong, and the standard
    /// deviation of that; once.
    pub(super) fn take_proven_gain(&mut self) -> Option<(f64, f64)> {
        self.proven.take().map(|trend| (trend.gain, trend.sigma))
    }
}

/// Exchanges that agree, from the newest on.
struct Agreeing {
    bounds: Bounds,
    /// An older one does not.
    contradicted: bool,
}

impl Agreeing {
    fn of<'a>(
        mut newest_first: impl Iterator<Item = &'a Exchange>,
        now: Instant<Local>,
        line: &FarLine,
        doubt: f64,
    ) -> Option<Self> {
        let newest = newest_first.next()?.stamps;
        let mut bounds = Bounds {
            least: newest,
            most: newest,
            doubt,
            proven: None,
        };
        let (mut lower, mut upper) = bounds.at(now, line);
        let mut contradicted = false;
        for Exchange { stamps, .. } in newest_first {
            let (least, most) = (
                least(stamps, now, line, doubt),
                most(stamps, now, line, doubt),
            );
            if least > upper || most < lower {
                contradicted = true;
                break;
            }
            if least > lower {
                (bounds.least, lower) = (*stamps, least);
            }
            if most < upper {
                (bounds.most, upper) = (*stamps, most);
            }
        }
        Some(Self {
            bounds,
            contradicted,
        })
    }
}

fn least(stamps: &Stamps, now: Instant<Local>, line: &FarLine, doubt: f64) -> f64 {
    let Seconds(ahead) = line.offset_at(stamps.responded, stamps.arrived);
    ahead - widened(stamps.arrived, now, line, doubt)
}

fn most(stamps: &Stamps, now: Instant<Local>, line: &FarLine, doubt: f64) -> f64 {
    let Seconds(ahead) = line.offset_at(stamps.received, stamps.requested);
    ahead + widened(stamps.requested, now, line, doubt)
}

/// What the line can have gained or lost since, s.
fn widened(since: Instant<Local>, now: Instant<Local>, line: &FarLine, doubt: f64) -> f64 {
    let rate = COVERED * line.rate_sigma + UNKNOWN_RATE + doubt;
    rate * (now - since).as_secs_f64()
}
