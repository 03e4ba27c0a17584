//! Presentation delay that the sender's frames state: a figure, or what its followers want.

use coaxle_clock::{SlewedSpan, Span};
use coaxle_node::PresentAfter;
use coaxle_node::config::PresentAfterRange;

/// Presentation delay of the sender's frames.
#[derive(Debug)]
pub(crate) struct StatedDelay {
    range: PresentAfterRange,
    cycle: Span,
    by: SlewedSpan,
    /// Delay that it is led to.
    target: Span,
    /// Time for which all axes have stood.
    rest: Span,
    /// Time for which all followers have been in sync.
    in_sync: Span,
}

/// Cycles by which the delay stays longer than wanted, and a sixteenth of it: the measured need rises and falls by the
/// resolution of its statistics.
const RESERVE_CYCLES: i64 = 4;
/// Time for which all followers are in sync before what they want counts as known: they measure it for a second, and report it
/// with the next report.
const SETTLING: Span = Span::from_secs(2);

impl StatedDelay {
    /// Creates one that permits these delays, of a cycle or more.
    pub(crate) fn new(range: PresentAfterRange, cycle: Span) -> Self {
        let range = PresentAfterRange {
            least: range.least.max(cycle),
            ..range
        };
        Self {
            range,
            cycle,
            by: SlewedSpan::new(range.least),
            target: range.least,
            rest: Span::ZERO,
            in_sync: Span::ZERO,
        }
    }

    /// Delay of the newest cycle.
    pub(crate) fn field(&self) -> Option<PresentAfter> {
        PresentAfter::new(self.by.now())
    }

    /// True if followers decide on it.
    pub(crate) fn is_led(&self) -> bool {
        self.range.is_led()
    }

    /// Runs one cycle, `passed` after the one before: towards what followers want, if they do. It changes at once while nothing moves that is shown, or is
    /// to be shown, and slowly otherwise.
    pub(crate) fn advance(&mut self, passed: Span, wanted: Option<Span>, do_axes_stand: bool) {
        self.rest = match do_axes_stand {
            true => self.rest + passed,
            false => Span::ZERO,
        };
        self.aim(wanted);
        let (now, target) = (self.by.now(), self.target);
        // Until then a follower still shows, or would show again, what has moved.
        let is_at_rest = self.rest > now.max(target) + self.cycle;
        // Receivers take a change of up to a cycle for one that is slewed.
        if is_at_rest && (target - now).abs() > self.cycle {
            self.by.set(target);
        } else if !self.by.advance(passed) && now != target {
            self.by.lead_to(target, SlewedSpan::MOST_AT_ONCE);
        }
    }

    /// True if axes may begin to move as far as the delay goes: what followers want is known and granted. In motion it is granted slowly, and
    /// nobody waits.
    pub(crate) fn is_settled(&self) -> bool {
        let is_granted = self.by.now() == self.target || self.rest == Span::ZERO;
        !self.is_led() || (self.in_sync >= SETTLING && is_granted)
    }

    /// Takes whether all followers are in sync, `passed` after the cycle before.
    pub(crate) fn take_sync(&mut self, passed: Span, are_in_sync: bool) {
        self.in_sync = match are_in_sync {
            true => self.in_sync + passed,
            false => Span::ZERO,
        };
    }

    fn aim(&mut self, wanted: Option<Span>) {
        let Some(wanted) = wanted.map(|wanted| self.range.nearest(wanted)) else {
            return;
        };
        let reserve = self.cycle * RESERVE_CYCLES + self.target / 16;
        if wanted > self.target || wanted + reserve < self.target {
            self.target = wanted;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);

    fn ms(millis: i64) -> Span {
        Span::from_millis(millis)
    }

    fn delay() -> StatedDelay {
        let range = PresentAfterRange {
            least: Span::ZERO,
            most: ms(100),
        };
        StatedDelay::new(range, CYCLE)
    }

    fn stated(delay: &StatedDelay) -> Span {
        delay.field().expect("a delay").span()
    }

    #[test]
    fn nobody_who_wants_one_leaves_the_shortest() {
        let mut delay = delay();
        for _ in 0..10_000 {
            delay.advance(CYCLE, None, true);
            assert_eq!(stated(&delay), CYCLE);
        }
    }

    #[test]
    fn at_rest_it_is_there_once_nothing_shown_has_moved() {
        let mut delay = delay();
        delay.advance(CYCLE, Some(ms(20)), false);
        for _ in 0..21 {
            delay.advance(CYCLE, Some(ms(20)), true);
            assert!(stated(&delay) < ms(2));
        }
        delay.advance(CYCLE, Some(ms(20)), true);
        assert_eq!(stated(&delay), ms(20));
        // A little less is left alone, much less is not, and no more than permitted is stated.
        for (wanted, expected) in [(18, 20), (14, 14), (16, 16), (500, 16)] {
            delay.advance(CYCLE, Some(ms(wanted)), true);
            assert_eq!(stated(&delay), ms(expected), "{wanted}");
        }
        for _ in 0..100 {
            delay.advance(CYCLE, Some(ms(500)), true);
        }
        assert_eq!(stated(&delay), ms(100));
    }

    #[test]
    fn axes_may_begin_once_what_is_wanted_is_known_and_granted() {
        let mut delay = delay();
        let mut run = |cycles, wanted, are_in_sync, do_axes_stand| {
            for _ in 0..cycles {
                delay.take_sync(CYCLE, are_in_sync);
                delay.advance(CYCLE, wanted, do_axes_stand);
            }
            delay.is_settled()
        };
        assert!(!run(5_000, None, false, true));
        assert!(!run(1_990, None, true, true));
        assert!(run(10, None, true, true), "nobody wants one");
        assert!(run(1, Some(ms(5_000)), true, false), "in motion");
        assert!(!run(101, Some(ms(5_000)), true, true));
        assert!(run(1, Some(ms(5_000)), true, true));
        assert!(!run(1, None, false, true));
        let fixed = StatedDelay::new(PresentAfterRange::only(ms(3)), CYCLE);
        assert!(fixed.is_settled());
    }

    #[test]
    fn in_motion_it_changes_by_less_than_a_thousandth() {
        let mut delay = delay();
        for wanted in [12, 3] {
            let (mut before, mut cycles) = (stated(&delay), 0);
            while stated(&delay) != ms(wanted) {
                delay.advance(CYCLE, Some(ms(wanted)), false);
                let change = (stated(&delay) - before).abs();
                assert!(change <= Span::from_nanos(940), "{change}");
                before = stated(&delay);
                cycles += 1;
                assert!(cycles < 40_000, "{before}");
            }
        }
    }
}
