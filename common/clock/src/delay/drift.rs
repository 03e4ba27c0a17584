//! Attribution of a change of the drift to the sender's clock or to the path.
//!
//! Messages come later and later, by `c` per second more than before. Against the line that they are on now, requests are
//! under way (see [`super`]) for
//!
//! ```text
//!                                        way there
//! the sender's clock has another drift      0         it is where the messages say
//! all ways become longer                 +2·c·t
//! that of messages becomes longer         +c·t        and that of responses, or not
//! ```
//!
//! Nothing of before is needed for that, when the line may have been wrong for a while.

use super::window::Exchange;
use crate::observer::SuspectedDrift;
use crate::straight_line::StraightLine;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the attribution of a drift.
    DriftCauseTuning {
        /// Least length of a stretch, s.
        // Requests go out at the fast or at the slow interval. Means of stretches of this length weigh alike.
        stretch: f64 = 0.06,
        /// Least number of stretches that is conclusive.
        // The line through them has three degrees of freedom.
        enough: usize = 5,
        /// Least size of the groups whose quickest counts, for a jitter too wide for means.
        each: usize = 6,
        /// Part of the change that counts as nothing.
        nothing: f64 = 0.35,
        /// To distinguish it from all of the change, the slope is to be known to a standard deviation of this part (two standard deviations
        /// for half of the change are wrong once in twenty). A drift that is taken for a path is examined again a second later; a path that
        /// is taken for a drift leads away.
        certain: f64 = 0.15,
        /// Excess over the others of its stretch, s, from which a way is a hold-up, and is ignored.
        held_up: f64 = 0.5e-3,
    }
}

/// Greatest number of stretches, and the least that is conclusive.
const STRETCHES: usize = 64;
const QUICKEST: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Whose {
    Sender,
    Path,
}

/// Attributes the change; none as long as it is not certain.
pub(super) fn whose<'a>(
    suspected: &SuspectedDrift,
    exchanges: impl Iterator<Item = &'a Exchange> + Clone,
) -> Option<Whose> {
    let line = &suspected.line;
    let ways = exchanges.filter_map(|exchange| {
        let stamps = &exchange.stamps;
        let after = (stamps.requested - suspected.since).as_secs_f64();
        // The way there alone: responses travel as messages do, so that against their line the way back is always level.
        let way = line.offset_at(stamps.received, stamps.requested).0;
        // Exchanges of before the change are of the line that was, whose rate may have been wrong.
        (after >= 0.0).then_some((after, way))
    });
    let is_certain =
        |growth: &StraightLine| growth.slope_sigma() < TUNING.certain * suspected.change.abs();
    let growth = growth(ways.clone())
        .filter(is_certain)
        // Only where means say nothing: the quickest of few parts know less of a slope (a path of ±200 µs in 3 s: 1548 µs for
        // 685).
        .or_else(|| growth_of_quickest(ways).filter(is_certain))?;
    Some(
        match libm::fabs(growth.slope / suspected.change) < TUNING.nothing {
            true => Whose::Sender,
            false => Whose::Path,
        },
    )
}

/// The mean of the ways of a stretch.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    count: f64,
    time: f64,
    way: f64,
}

impl Stretch {
    fn take(&mut self, time: f64, way: f64) {
        if self.count > 0.0 && way > self.way + TUNING.held_up {
            return;
        }
        // All before it in this stretch was held up.
        if self.count > 0.0 && way < self.way - TUNING.held_up {
            self.count = 0.0;
        }
        self.count += 1.0;
        self.time += (time - self.time) / self.count;
        self.way += (way - self.way) / self.count;
    }
}

/// Fits a line through the means of stretches, which may be empty; the ways are given as pairs of time and way, s. None of too
/// few.
fn growth(ways: impl Iterator<Item = (f64, f64)> + Clone) -> Option<StraightLine> {
    let span = ways.clone().map(|(time, _)| time).fold(0.0, f64::max);
    // Longer where the exchanges of ten seconds would not fit.
    let length = TUNING.stretch.max(span / (STRETCHES as f64 - 1.0));
    let mut stretches = [Stretch::default(); STRETCHES];
    for (time, way) in ways {
        stretches[(time / length) as usize].take(time, way);
    }
    let known = stretches.iter().filter(|stretch| stretch.count > 0.0);
    let enough = known.clone().count() >= TUNING.enough;
    enough.then(|| StraightLine::through(known.map(|stretch| (stretch.time, stretch.way))))
}

/// Fits a line through the quickest of groups of at least `each`, all of one size, as the quickest of more would be quicker
/// by that alone. None of too few.
fn growth_of_quickest(ways: impl Iterator<Item = (f64, f64)> + Clone) -> Option<StraightLine> {
    let count = ways.clone().count();
    let each = count / QUICKEST;
    if each < TUNING.each {
        return None;
    }
    let mut quickest = [(0.0, f64::INFINITY); QUICKEST];
    for (n, way) in ways.skip(count % QUICKEST).enumerate() {
        let place = &mut quickest[n / each];
        if way.1 < place.1 {
            *place = way;
        }
    }
    Some(StraightLine::through(quickest.into_iter()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ways of requests every 20 ms over `span`, s; they are `way` long, and later by up to `late`.
    fn asked(
        span: f64,
        late: f64,
        way: fn(f64) -> f64,
    ) -> impl Iterator<Item = (f64, f64)> + Clone {
        (0..(span / 0.02) as u32).map(move |k| {
            let time = 0.02 * f64::from(k);
            let part = f64::from(k.wrapping_mul(2_654_435_761) >> 8 & 0xffff) / 65_536.0;
            (time, way(time) + late * part * part)
        })
    }

    fn growth_of(span: f64, way: fn(f64) -> f64) -> Option<StraightLine> {
        growth(asked(span, 20e-6, way))
    }

    #[test]
    fn where_the_jitter_is_wide_the_quickest_tell() {
        let way = |time: f64| 1e-3 + 80e-6 * time;
        let asked = |span| asked(span, 400e-6, way);
        assert!(growth_of_quickest(asked(0.9)).is_none(), "too few");
        let [means, quickest] = [growth(asked(1.5)), growth_of_quickest(asked(1.5))];
        let [means, quickest] = [means, quickest].map(Option::unwrap);
        assert!(quickest.slope_sigma() < 0.5 * means.slope_sigma());
        assert!(
            (quickest.slope - 80e-6).abs() < 3.0 * quickest.slope_sigma(),
            "{} ± {}",
            quickest.slope,
            quickest.slope_sigma()
        );
    }

    #[test]
    fn the_growth_of_ways_is_found() {
        assert!(growth_of(0.2, |_| 1e-3).is_none(), "too few");
        for way in [
            |_| 1e-3,
            |time: f64| 1e-3 + 200e-6 * time,
            |time: f64| 1e-3 - 200e-6 * time,
        ] {
            let true_growth = way(1.0) - way(0.0);
            let growth = growth_of(1.0, way).unwrap();
            assert!(growth.slope_sigma() < 10e-6);
            assert!(
                (growth.slope - true_growth).abs() < 4.0 * growth.slope_sigma(),
                "{}",
                growth.slope
            );
        }
    }

    #[test]
    fn hold_ups_say_nothing() {
        let held_up = |time: f64| {
            1e-3 + if time > 0.7 && time < 0.75 {
                30e-3
            } else {
                0.0
            }
        };
        let growth = growth_of(1.0, held_up).unwrap();
        assert!(
            growth.slope.abs() < 4.0 * growth.slope_sigma(),
            "{}",
            growth.slope
        );
    }
}
