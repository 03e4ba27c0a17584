//! Common time: a clock that two machines have in common, as PTP or receivers of satellites give them.
//!
//! Each node reads it together with its own clock, and tells the other one. Two own readings around the far one give the local
//! instant of that, so that no way of a message is in it:
//!
//! ```text
//! own readings    ·────────·          local clock and common time
//! far reading         ·               far clock and common time: the local instant is between the two
//! ```
//!
//! That is an exchange whose ways take nothing, but for the errors that both nodes state. So it makes a second
//! [timing channel](crate::timing), and the first one, which measures ways, watches it: a clock of which two machines think that
//! they have it in common is wrong beyond its stated error after a boundary clock in free run, a mis-set asymmetry or a
//! grandmaster that leaps.

use crate::delay::TimeResponse;
use crate::instant::{Domain, Instant, Local, Span};

/// International atomic time, or any other that both machines have.
pub enum Tai {}

impl Domain for Tai {
    const NAME: &'static str = "TAI";
}

/// Reading of a common time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommonReading {
    /// Time that was read.
    pub time: Instant<Tai>,
    /// Greatest error against the grandmaster.
    pub bound: Span,
    /// Identity of the clock that the time comes from.
    pub grandmaster: u64,
}

/// Reading of a far node: on its own clock, and in common time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FarCommonReading {
    /// Run of the node.
    pub epoch: u64,
    /// Time since the ideal start of its cycle 0.
    pub at: Span,
    /// Common time at that.
    pub common: CommonReading,
}

/// Reason why two nodes have no common time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum CommonTimeLack {
    /// They have one.
    #[default]
    None,
    /// The own clock is not disciplined, or its grandmaster is not known.
    NotHere,
    /// The far node states none.
    NotThere,
    /// The two have different grandmasters.
    OtherGrandmaster,
    /// The two differ by more than a second: one of them does not know the offset of TAI from UTC.
    SecondsApart,
}

/// Greatest difference between the common times of two nodes in one exchange.
// No exchange lasts longer, and TAI without its offset from UTC is 37 s away.
const MOST_APART: Span = Span::from_secs(1);
/// Greatest time between two own readings that a far one is placed between.
// Beacons come once a second at least, and some may be lost. Within that a quartz changes by some hundredths of a ppm.
const MOST_BETWEEN: Span = Span::from_millis(3_500);
/// Greatest stated error that is of use.
// An exchange that takes longer than a second is refused, and each error counts twice.
const GREATEST_BOUND: Span = Span::from_millis(100);

/// Readings of two nodes, turned into exchanges.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CommonTime {
    before: Option<BothReadings>,
    lack: Option<CommonTimeLack>,
}

/// Readings in one exchange.
#[derive(Clone, Copy, Debug)]
struct BothReadings {
    here: Instant<Local>,
    own: CommonReading,
    far: FarCommonReading,
}

impl CommonTime {
    /// Takes the readings of an exchange. Returns the exchange before it as if its ways took nothing, with the arrival of its response.
    pub(crate) fn take(
        &mut self,
        here: Instant<Local>,
        own: Option<CommonReading>,
        far: Option<FarCommonReading>,
    ) -> Option<(Instant<Local>, TimeResponse)> {
        let lack = lack_of(own, far);
        self.lack = Some(lack);
        let (Some(own), Some(far), CommonTimeLack::None) = (own, far, lack) else {
            self.before = None;
            return None;
        };
        let before = self.before.replace(BothReadings { here, own, far })?;
        before.placed(here, own)
    }

    /// Reason why the two nodes have no common time; none before the first exchange.
    pub(crate) const fn lack(&self) -> Option<CommonTimeLack> {
        self.lack
    }
}

fn lack_of(own: Option<CommonReading>, far: Option<FarCommonReading>) -> CommonTimeLack {
    let of_use = |common: &CommonReading| (Span::ZERO..=GREATEST_BOUND).contains(&common.bound);
    let Some(own) = own.filter(of_use) else {
        return CommonTimeLack::NotHere;
    };
    let Some(far) = far.map(|far| far.common).filter(of_use) else {
        return CommonTimeLack::NotThere;
    };
    if own.grandmaster != far.grandmaster {
        CommonTimeLack::OtherGrandmaster
    } else if !(-MOST_APART..=MOST_APART).contains(&(far.time - own.time)) {
        CommonTimeLack::SecondsApart
    } else {
        CommonTimeLack::None
    }
}

impl BothReadings {
    /// Places the far reading on the local clock, by the own reading before it and the one after it.
    fn placed(
        &self,
        here: Instant<Local>,
        own: CommonReading,
    ) -> Option<(Instant<Local>, TimeResponse)> {
        let passed_here = here - self.here;
        let passed = own.time - self.own.time;
        let is_near = |passed| (Span::from_nanos(1)..=MOST_BETWEEN).contains(&passed);
        let is_same = own.grandmaster == self.own.grandmaster;
        if !(is_same && is_near(passed_here) && is_near(passed)) {
            return None;
        }
        let rate = passed_here.as_nanos() as f64 / passed.as_nanos() as f64;
        let since = (self.far.common.time - self.own.time).as_nanos();
        let beside = Span::from_secs_f64(since as f64 * (rate - 1.0) * 1e-9);
        let at = self.here + Span::from_nanos(since) + beside;
        let bound = self.own.bound.max(own.bound) + self.far.common.bound;
        // As long there as back, and half of both is what the far clock may be off by.
        let exchange = TimeResponse {
            run: 0,
            number: 0,
            requested: at - bound,
            epoch: self.far.epoch,
            received: self.far.at,
            responded: self.far.at,
        };
        Some((at + bound, exchange))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRANDMASTER: u64 = 0x0011_22ff_fe33_4455;

    /// A node that reads common time at `tai` µs; the far clock is 3 ms ahead.
    fn reading(tai: i64) -> CommonReading {
        CommonReading {
            time: Instant::from_nanos(tai * 1_000),
            bound: Span::from_nanos(400),
            grandmaster: GRANDMASTER,
        }
    }

    fn far(tai: i64) -> FarCommonReading {
        FarCommonReading {
            epoch: 7,
            at: Span::from_micros(tai + 3_000),
            common: reading(tai),
        }
    }

    /// The local clock runs 100 ppm fast.
    fn here(tai: i64) -> Instant<Local> {
        Instant::from_nanos(tai * 1_000 + tai / 10)
    }

    #[test]
    fn a_far_reading_is_placed_between_two_own_ones() {
        let mut common = CommonTime::default();
        assert_eq!(common.lack(), None);
        let mut take = |own, of_far| common.take(here(own), Some(reading(own)), Some(far(of_far)));
        assert_eq!(take(1_000_000, 1_000_700), None);
        let (arrived, exchange) = take(1_020_000, 1_020_900).unwrap();
        // Bounds of both, there and back.
        let bound = Span::from_nanos(800);
        assert_eq!(arrived - bound, here(1_000_700));
        assert_eq!(exchange.requested + bound, here(1_000_700));
        assert_eq!(
            (exchange.epoch, exchange.received),
            (7, Span::from_micros(1_003_700))
        );
        assert_eq!(exchange.received, exchange.responded);
    }

    #[test]
    fn what_is_lacking_is_named_and_nothing_is_placed_across_it() {
        let of_other = |tai| CommonReading {
            grandmaster: 1,
            ..reading(tai)
        };
        let unbounded = |tai| CommonReading {
            bound: Span::from_secs(1),
            ..reading(tai)
        };
        let cases = [
            (None, Some(far(500)), CommonTimeLack::NotHere),
            (Some(unbounded(0)), Some(far(500)), CommonTimeLack::NotHere),
            (Some(reading(0)), None, CommonTimeLack::NotThere),
            (
                Some(of_other(0)),
                Some(far(500)),
                CommonTimeLack::OtherGrandmaster,
            ),
            (
                Some(reading(0)),
                Some(far(-37_000_000)),
                CommonTimeLack::SecondsApart,
            ),
        ];
        for (own, there, expected) in cases {
            let mut common = CommonTime::default();
            let _ = common.take(here(-20_000), Some(reading(-20_000)), Some(far(-19_000)));
            assert_eq!(common.take(here(0), own, there), None);
            assert_eq!(common.lack(), Some(expected));
            assert_eq!(
                common.take(here(20_000), Some(reading(20_000)), Some(far(20_500))),
                None
            );
            assert_eq!(common.lack(), Some(CommonTimeLack::None));
        }
    }

    #[test]
    fn own_readings_far_apart_or_out_of_order_place_nothing() {
        for next in [1_004_000_000, 0, -20_000] {
            let mut common = CommonTime::default();
            let _ = common.take(here(0), Some(reading(0)), Some(far(700)));
            assert_eq!(
                common.take(here(next), Some(reading(next)), Some(far(next))),
                None
            );
        }
    }
}
