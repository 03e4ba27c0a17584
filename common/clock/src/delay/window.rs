//! The last exchanges.

use super::TUNING as EXCHANGE;
use super::step::{TELLING, Ways, median};
use crate::instant::{Instant, Local, Seconds, Span};
use crate::observer::FarLine;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the window.
    ExchangeWindowTuning {
        /// Number of ways of which one is early.
        // With a tenth of them, on recordings of complete nodes, far time is 7.3 µs rms off.
        ways_per_early: usize = 32,
    }
}

/// Exchanges kept: ten seconds' worth at ten per second, and some of the hasty ones.
pub(super) const KEPT: usize = 128;

/// Measurement of one exchange against the line of its time, s. A line that has been corrected since corrects it,
/// too.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange {
    pub(super) at: Instant<Local>,
    /// Sender's lead plus the way there.
    pub(super) there: f64,
    /// Way back less the sender's lead.
    pub(super) back: f64,
    /// See [`FarLine::corrected`].
    pub(super) corrected: Seconds,
    /// The stamps it was measured by.
    pub(super) stamps: ExchangeStamps,
}

/// Times when a request left and its response arrived, and when the sender received the one and sent the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExchangeStamps {
    pub(super) requested: Instant<Local>,
    pub(super) received: Span,
    pub(super) responded: Span,
    pub(super) arrived: Instant<Local>,
}

impl Exchange {
    /// Measures the stamps against the line as it is now.
    pub(super) fn measured(stamps: ExchangeStamps, line: &FarLine) -> Self {
        Self {
            at: stamps.arrived,
            there: line.offset_at(stamps.received, stamps.requested).0,
            back: -line.offset_at(stamps.responded, stamps.arrived).0,
            corrected: line.corrected,
            stamps,
        }
    }

    fn there(&self, line: &FarLine) -> f64 {
        self.there + (line.corrected - self.corrected).0
    }

    fn back(&self, line: &FarLine) -> f64 {
        self.back - (line.corrected - self.corrected).0
    }
}

/// Exchanges, the newest first, measured against the line as it is now.
#[derive(Clone, Copy)]
pub(super) struct Recent<'a> {
    pub(super) exchanges: &'a [Exchange],
    pub(super) now: Instant<Local>,
    pub(super) line: &'a FarLine,
}

impl Recent<'_> {
    /// Time since the oldest, s.
    pub(super) fn span(&self) -> f64 {
        let oldest = self.exchanges.last();
        oldest.map_or(0.0, |oldest| (self.now - oldest.at).as_secs_f64())
    }
}

/// Ways of one direction over the whole window, s. The very least hangs on a single message; a few are the surer
/// measure where jitter has no sharp lower bound, and no more than a few meet no obstacle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Early {
    pub(super) least: f64,
    /// Way that one in `ways_per_early` does not exceed.
    pub(super) early: f64,
    /// Standard deviation of the early ones, if what is above them is exponential: then twice as many
    /// come within `deviation·√rank` after them.
    pub(super) deviation: f64,
}

/// A bounded number of exchanges, none too old.
#[derive(Clone, Debug)]
pub(super) struct Window {
    kept: [Exchange; KEPT],
    oldest: usize,
    len: usize,
}

impl Window {
    pub(super) const fn new() -> Self {
        const BLANK: Exchange = Exchange {
            at: Instant::EPOCH,
            there: 0.0,
            back: 0.0,
            corrected: Seconds::ZERO,
            stamps: ExchangeStamps {
                requested: Instant::EPOCH,
                received: Span::ZERO,
                responded: Span::ZERO,
                arrived: Instant::EPOCH,
            },
        };
        Self {
            kept: [BLANK; KEPT],
            oldest: 0,
            len: 0,
        }
    }

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    pub(super) const fn clear(&mut self) {
        self.len = 0;
    }

    /// Measures every exchange again.
    pub(super) fn measure_again(&mut self, line: &FarLine) {
        // Places that are not in use, too: that is cheaper than to skip them, and does no harm.
        for exchange in &mut self.kept {
            *exchange = Exchange::measured(exchange.stamps, line);
        }
    }

    /// Returns the [`Self::len`] exchanges, the newest first, measured against the line as it is now.
    pub(super) fn measured_now(&self, line: &FarLine) -> [Exchange; KEPT] {
        let mut measured = self.kept;
        for (place, exchange) in measured.iter_mut().zip(self.all().rev()) {
            *place = Exchange::measured(exchange.stamps, line);
        }
        measured
    }

    /// Puts the newest in; the oldest goes if there is no room.
    pub(super) fn push(&mut self, exchange: Exchange) {
        if self.len == KEPT {
            self.drop_oldest();
        }
        self.kept[(self.oldest + self.len) % KEPT] = exchange;
        self.len += 1;
        // The newest is never too old beside itself, so one stays.
        while exchange.at - self.kept[self.oldest].at > EXCHANGE.longest_age {
            self.drop_oldest();
        }
    }

    /// The way there and the way back; none of an empty window.
    pub(super) fn early(&self, line: &FarLine) -> Option<(Early, Early)> {
        let there = self.early_of(|exchange| exchange.there(line))?;
        let back = self.early_of(|exchange| exchange.back(line))?;
        Some((there, back))
    }

    /// Usual ways, whatever happened to the last few; none of too few exchanges.
    pub(super) fn usual(&self, line: &FarLine) -> Option<Ways> {
        (self.len >= TELLING).then(|| Ways {
            there: self.median_of(|exchange| exchange.there(line)),
            back: self.median_of(|exchange| exchange.back(line)),
        })
    }

    /// Median ways of the newest few.
    pub(super) fn newest(&self, line: &FarLine) -> Option<Ways> {
        let mut ways = [[0.0; TELLING]; 2];
        if self.len < TELLING {
            return None;
        }
        for (n, exchange) in self.all().rev().take(TELLING).enumerate() {
            [ways[0][n], ways[1][n]] = [exchange.there(line), exchange.back(line)];
        }
        let [there, back] = &mut ways;
        Some(Ways {
            there: median(there),
            back: median(back),
        })
    }

    /// Iterates over the exchanges, the oldest first.
    pub(super) fn all(&self) -> impl DoubleEndedIterator<Item = &Exchange> + Clone {
        (0..self.len).map(|n| &self.kept[(self.oldest + n) % KEPT])
    }

    const fn drop_oldest(&mut self) {
        self.oldest = (self.oldest + 1) % KEPT;
        self.len -= 1;
    }

    /// Ways of every exchange, in the first places.
    fn ways(&self, way: impl Fn(&Exchange) -> f64) -> [f64; KEPT] {
        let mut ways = [0.0; KEPT];
        for (n, place) in ways[..self.len].iter_mut().enumerate() {
            *place = way(&self.kept[(self.oldest + n) % KEPT]);
        }
        ways
    }

    fn median_of(&self, way: impl Fn(&Exchange) -> f64) -> f64 {
        median(&mut self.ways(way)[..self.len])
    }

    fn early_of(&self, way: impl Fn(&Exchange) -> f64) -> Option<Early> {
        let mut ways = self.ways(way);
        let ways = &mut ways[..self.len];
        let least = ways.iter().copied().reduce(f64::min)?;
        let rank = (self.len / TUNING.ways_per_early).max(1);
        let next = (2 * rank).min(self.len) - 1;
        // The later rank first: the earlier one is then among the values before it.
        let later = *ways.select_nth_unstable_by(next, f64::total_cmp).1;
        let early = *ways[..=next]
            .select_nth_unstable_by(rank - 1, f64::total_cmp)
            .1;
        Some(Early {
            least,
            early,
            // The gap between the ranks r and 2·r is a sum of r spacings, and that of the early one scatters by its root.
            deviation: (later - early) / libm::sqrt(rank as f64),
        })
    }
}
