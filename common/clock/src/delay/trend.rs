//! Rate of the sender against the line, by the exchanges alone.
//!
//! The middles of exchanges that took no longer than most lie on the sender's own time, but for a constant. A line
//! whose rate is right is level against them. Where it is not, the cause may be a path whose ways change differently,
//! so it only makes the line less certain; but no path can bring a response before its request. Exchanges that
//! [contradict](super::bounds) each other against this line, and do not against one at their own rate, prove that the
//! line is wrong.

use super::window::{Exchange, KEPT, Recent};
use crate::instant::{Instant, Local, Span};
use crate::numbers::together;
use crate::straight_line::StraightLine;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the trend.
    TrendTuning {
        /// Exchanges needed for a trend.
        // They span half a second: no two requests are closer than at the fast interval.
        enough: usize = 24,
        /// Time that proves something, s.
        proving: f64 = 2.0,
        /// Standard deviations at which a slope is no chance.
        significant: f64 = 4.0,
        /// Agreement of both halves of the time, or else the sender's clock has changed meanwhile.
        alike: f64 = 0.3,
    }
}

/// Sender's gain on the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trend {
    /// Gain, s/s.
    pub(super) gain: f64,
    /// Standard deviation of the gain, s/s.
    pub(super) sigma: f64,
    /// Time since the oldest exchange, s.
    span: f64,
}

impl Trend {
    /// Finds the trend of exchanges; none as long as that may be chance.
    pub(super) fn of(recent: &Recent<'_>) -> Option<Self> {
        let quick = quick(recent)?;
        let whole = Self::through(quick.points(), quick.span)?;
        let newer = Self::through(quick.points().take(quick.len / 2), quick.span)?;
        let doubt = TUNING.significant * together(whole.sigma, newer.sigma);
        // A clock that was steered within the window has no single rate to restart the line with.
        let is_like = (whole.gain - newer.gain).abs() <= doubt + TUNING.alike * whole.gain.abs();
        let is_told = whole.gain.abs() > TUNING.significant * whole.sigma;
        (is_told && is_like).then_some(whole)
    }

    /// Finds the rates that the exchanges leave open, however long each of them took: at no other rate do all of them agree.
    /// None if they do not at any.
    pub(super) fn left_open(recent: &Recent<'_>) -> Option<Self> {
        let now = recent.now;
        let since = |at: Instant<Local>| (at - now).as_secs_f64();
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for response in recent.exchanges {
            let arrived = since(response.stamps.arrived);
            for request in recent.exchanges {
                // The sender is ahead by no less than the one says, and later by no more than the other one says.
                let passed = since(request.stamps.requested) - arrived;
                let gain = (request.there + response.back) / passed;
                match passed > 0.0 {
                    true => most = most.min(gain),
                    false => least = least.max(gain),
                }
            }
        }
        (least < most).then(|| Self {
            gain: 0.5 * (least + most),
            // Anything in between is as likely.
            sigma: (most - least) / libm::sqrt(12.0),
            span: recent.span(),
        })
    }

    fn through(points: impl Iterator<Item = (f64, f64)> + Clone, span: f64) -> Option<Self> {
        if points.clone().count() < TUNING.enough / 4 {
            return None;
        }
        let line = StraightLine::through(points);
        let sigma = line.slope_sigma();
        sigma.is_finite().then_some(Self {
            gain: line.slope,
            sigma,
            span,
        })
    }

    /// True if it spans long enough to prove something.
    pub(super) fn may_prove(&self) -> bool {
        self.span >= TUNING.proving
    }

    /// Greatest error of the line's rate, s/s.
    pub(super) fn most(&self) -> f64 {
        self.gain.abs() + TUNING.significant * self.sigma
    }
}

/// The middles of the quicker half of exchanges.
struct Quick {
    points: [(f64, f64); KEPT],
    len: usize,
    /// Time since the oldest of all, s.
    span: f64,
}

impl Quick {
    fn points(&self) -> impl Iterator<Item = (f64, f64)> + Clone {
        self.points[..self.len].iter().copied()
    }
}

fn quick(recent: &Recent<'_>) -> Option<Quick> {
    let Recent { exchanges, now, .. } = *recent;
    let span = recent.span();
    if exchanges.len() < TUNING.enough {
        return None;
    }
    let mut took = [Span::ZERO; KEPT];
    for (place, exchange) in took.iter_mut().zip(exchanges) {
        *place = under_way(exchange);
    }
    let took = &mut took[..exchanges.len()];
    // The quicker half: the error of a middle is at most half of what an exchange took longer than the least.
    let (_, median, _) = took.select_nth_unstable(exchanges.len() / 2);
    let mut quick = Quick {
        points: [(0.0, 0.0); KEPT],
        len: 0,
        span,
    };
    for exchange in exchanges
        .iter()
        .filter(|exchange| under_way(exchange) <= *median)
    {
        let time = (exchange.stamps.requested - now).as_secs_f64();
        // Middle of an exchange: whatever both ways have alike cancels.
        quick.points[quick.len] = (time, 0.5 * (exchange.there - exchange.back));
        quick.len += 1;
    }
    Some(quick)
}

/// Time that a request and its response were under way.
fn under_way(exchange: &Exchange) -> Span {
    let stamps = &exchange.stamps;
    (stamps.arrived - stamps.requested) - (stamps.responded - stamps.received)
}
