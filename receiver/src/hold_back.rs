//! How much later the slaves are shown than they are calculated.
//!
//! An axis that is shown later by D is evaluated with a lag of no more than D. What is left is the hold-back: the drives
//! are given their set values that much later, and frames of slaves and far axes state it, so that followers have it for
//! their own way. Whatever is labelled with an instant of the root is shown D after it, at any lag: so the hold-back may
//! change at any time without moving what is shown.
//!
//! There is one for the whole node, the least that its axes leave: its frames state one delay for all axes in them, a
//! slave of several masters sees all of them at one instant, and slaves of different masters are alike. An axis that
//! leaves more has a longer lag instead.

use coaxle_clock::{SlewedSpan, Span};
use coaxle_slave::MOST_HELD_BACK;

/// What an axis leaves of the time by which it is shown later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Spare {
    /// Not received: it has no say.
    Absent,
    /// Not known yet.
    Pending,
    /// At most this time, which others may need.
    Is(Span),
}

impl Spare {
    /// Returns what two axes leave together: the lesser time, or pending while one of them is.
    pub(crate) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Absent, one) | (one, Self::Absent) => one,
            (Self::Is(one), Self::Is(other)) => Self::Is(one.min(other)),
            (Self::Pending, _) | (_, Self::Pending) => Self::Pending,
        }
    }
}

/// The hold-back of a node.
#[derive(Debug)]
pub(crate) struct HoldBack {
    cycle: Span,
    /// False if it is zero by the config.
    is_possible: bool,
    /// True if others follow far axes, which move while the slaves stand.
    moves_always: bool,
    by: SlewedSpan,
    /// Hold-back that it is led to.
    target: Span,
    is_decided: bool,
}

/// Cycles by which the hold-back stays shorter than it might be, and a sixteenth of it: the measured lag rises and falls by
/// the resolution of its statistics.
const RESERVE_CYCLES: i64 = 4;

impl HoldBack {
    pub(crate) const fn new(cycle: Span, is_possible: bool, moves_always: bool) -> Self {
        Self {
            cycle,
            is_possible,
            moves_always,
            by: SlewedSpan::new(Span::ZERO),
            target: Span::ZERO,
            is_decided: !is_possible,
        }
    }

    /// False if it is zero by the config.
    pub(crate) const fn is_possible(&self) -> bool {
        self.is_possible
    }

    /// The hold-back of the newest cycle.
    pub(crate) const fn by(&self) -> Span {
        self.by.now()
    }

    /// True once it is known how long it is to be at first. Until then no slave follows an axis that is shown later: the
    /// first hold-back would move it.
    pub(crate) const fn is_decided(&self) -> bool {
        self.is_decided
    }

    /// Runs one cycle, `passed` after the one before. It is slewed while slaves move, and changes at once, if by much, while
    /// they stand.
    pub(crate) fn advance(&mut self, passed: Span, spare: Spare, stand: impl FnOnce() -> bool) {
        if !self.is_possible || self.by.advance(passed) {
            return;
        }
        let Spare::Is(spare) = spare else {
            return;
        };
        let is_first = !std::mem::replace(&mut self.is_decided, true);
        let spare = self.whole(spare);
        let reserve = self.cycle * RESERVE_CYCLES + self.target / 16;
        if spare < self.target || spare >= self.target + reserve || is_first {
            self.target = spare;
        }
        let change = self.target - self.by.now();
        if change == Span::ZERO {
            return;
        }
        // A jump interrupts the far axes: a small one is not worth it.
        let may_jump = is_first || (!self.moves_always && change.abs() > SlewedSpan::MOST_AT_ONCE);
        if may_jump && stand() {
            self.by.set(self.target);
            return;
        }
        let most = self.whole(SlewedSpan::MOST_AT_ONCE).max(self.cycle);
        self.by.lead_to(self.target, most);
    }

    /// Whole cycles of a time: set values that wait for whole cycles are shown with their own bits.
    fn whole(&self, time: Span) -> Span {
        let cycles = time.as_nanos().max(0) / self.cycle.as_nanos().max(1);
        self.cycle * cycles.min(i64::from(MOST_HELD_BACK))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: Span = Span::from_millis(1);

    fn ms(millis: i64) -> Span {
        Span::from_millis(millis)
    }

    fn hold_back() -> HoldBack {
        HoldBack::new(CYCLE, true, false)
    }

    #[test]
    fn the_least_of_all_counts_and_what_is_not_there_has_no_say() {
        use Spare::{Absent, Is, Pending};
        let two = Is(ms(2));
        assert_eq!(Absent.and(Absent), Absent);
        assert_eq!(Absent.and(two), two);
        assert_eq!(two.and(Is(ms(3))), two);
        assert_eq!(two.and(Pending), Pending);
        assert_eq!(Absent.and(Pending), Pending);
    }

    #[test]
    fn at_rest_it_is_there_at_once_and_in_whole_cycles() {
        let mut hold_back = hold_back();
        hold_back.advance(CYCLE, Spare::Absent, || true);
        hold_back.advance(CYCLE, Spare::Pending, || true);
        assert!(!hold_back.is_decided());
        hold_back.advance(CYCLE, Spare::Is(Span::from_micros(17_900)), || true);
        assert!(hold_back.is_decided());
        assert_eq!(hold_back.by(), ms(17));
        // A little more is left alone, and less is not.
        hold_back.advance(CYCLE, Spare::Is(ms(20)), || true);
        assert_eq!(hold_back.by(), ms(17));
        hold_back.advance(CYCLE, Spare::Is(ms(11)), || true);
        assert_eq!(hold_back.by(), ms(11));
        hold_back.advance(CYCLE, Spare::Is(ms(30)), || true);
        assert_eq!(hold_back.by(), ms(30));
        // Room for a thousand cycles.
        hold_back.advance(CYCLE, Spare::Is(ms(3_000)), || true);
        assert_eq!(hold_back.by(), ms(1_000));
    }

    #[test]
    fn in_motion_it_is_slewed_by_less_than_a_thousandth() {
        let mut hold_back = hold_back();
        hold_back.advance(CYCLE, Spare::Is(ms(20)), || true);
        for target in [8, 33] {
            let (mut before, mut cycles) = (hold_back.by(), 0);
            while hold_back.by() != ms(target) {
                hold_back.advance(CYCLE, Spare::Is(ms(target)), || false);
                let change = (hold_back.by() - before).abs();
                assert!(change <= Span::from_nanos(940), "{change}");
                before = hold_back.by();
                cycles += 1;
                assert!(cycles < 60_000, "{}", hold_back.by());
            }
            // 2 s for each millisecond.
            assert!(cycles >= 24_000, "{cycles}");
        }
    }

    #[test]
    fn far_axes_that_others_follow_are_moved_at_once_only_before_anything_else() {
        let mut hold_back = HoldBack::new(CYCLE, true, true);
        hold_back.advance(CYCLE, Spare::Is(ms(20)), || true);
        assert_eq!(hold_back.by(), ms(20));
        for _ in 0..100 {
            hold_back.advance(CYCLE, Spare::Is(ms(10)), || true);
        }
        assert!(hold_back.by() > ms(19));
    }

    #[test]
    fn without_a_lag_by_the_config_there_is_none() {
        let mut hold_back = HoldBack::new(CYCLE, false, false);
        assert!(hold_back.is_decided());
        hold_back.advance(CYCLE, Spare::Is(ms(20)), || true);
        assert_eq!(hold_back.by(), Span::ZERO);
    }
}
