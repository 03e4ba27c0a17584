//! Cycles: their time, their index, and when the next one is due.

use crate::instant::{Instant, Local, Span};

/// The counter a sender increments with every message: a PLC `WORD`, so it wraps after 65 535.
///
/// TS5066, chapter 3.1, `iCycleIndex`.
#[doc(alias = "iCycleIndex")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct CycleIndex(pub u16);

impl CycleIndex {
    /// The index of cycle number `count` of a sender that counts from zero.
    #[must_use]
    pub const fn of_count(count: u64) -> Self {
        Self(count as u16)
    }

    /// Signed steps from `earlier` to this index, the short way round: −32 768…32 767.
    #[must_use]
    pub const fn steps_since(self, earlier: Self) -> i16 {
        self.0.wrapping_sub(earlier.0) as i16
    }
}

/// A nominal cycle time between 100 µs and 100 ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CycleTime(Span);

impl CycleTime {
    /// The shortest cycle time.
    pub const MIN: Span = Span::from_micros(100);
    /// The longest cycle time.
    pub const MAX: Span = Span::from_millis(100);

    /// # Errors
    /// [`CycleTimeOutOfRange`] outside [`Self::MIN`]…[`Self::MAX`].
    pub fn new(span: Span) -> Result<Self, CycleTimeOutOfRange> {
        if (Self::MIN..=Self::MAX).contains(&span) {
            Ok(Self(span))
        } else {
            Err(CycleTimeOutOfRange { received: span })
        }
    }

    /// The cycle time as a span.
    #[must_use]
    pub const fn span(self) -> Span {
        self.0
    }

    /// The cycle time in seconds.
    #[must_use]
    pub fn as_secs_f64(self) -> f64 {
        self.0.as_secs_f64()
    }
}

/// A cycle time that no node runs at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a cycle time of {received} is out of range, expected {} to {}",
    CycleTime::MIN,
    CycleTime::MAX
)]
pub struct CycleTimeOutOfRange {
    /// Cycle time asked for.
    pub received: Span,
}

/// Schedule of a node's cycles: cycle `k` starts at `start + k·T`, ideally.
///
/// A node that wakes too late skips the cycles it missed, by time, and counts them. It never
/// catches up with a burst.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    start: Instant<Local>,
    cycle_time: CycleTime,
    next: u64,
    overruns: u64,
}

/// A cycle that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// Cycle number since the node's start, skipped cycles counted.
    pub count: u64,
    /// Ideal start of the cycle.
    pub ideal_start: Instant<Local>,
    /// Cycles since the previous tick: 1, or more when some were skipped.
    pub elapsed: u32,
}

impl Schedule {
    /// The schedule whose cycle 0 starts at `start`.
    #[must_use]
    pub const fn new(start: Instant<Local>, cycle_time: CycleTime) -> Self {
        Self {
            start,
            cycle_time,
            next: 0,
            overruns: 0,
        }
    }

    /// The schedule whose cycle `first` starts at `start`, as if those before it had been taken.
    #[must_use]
    pub fn counting_from(first: u64, start: Instant<Local>, cycle_time: CycleTime) -> Self {
        Self {
            start: start - cycle_time.span() * first as i64,
            cycle_time,
            next: first,
            overruns: 0,
        }
    }

    /// Start of cycle 0, even if it was skipped.
    #[must_use]
    pub const fn start(&self) -> Instant<Local> {
        self.start
    }

    /// Ideal start of the next cycle.
    #[must_use]
    pub fn next_start(&self) -> Instant<Local> {
        self.start_of(self.next)
    }

    /// Cycles skipped so far.
    #[must_use]
    pub const fn overruns(&self) -> u64 {
        self.overruns
    }

    /// The nominal cycle time.
    #[must_use]
    pub const fn cycle_time(&self) -> CycleTime {
        self.cycle_time
    }

    /// Takes the cycle that is due at `now`. Waking early (cycle jitter has both signs, and a clock may
    /// have jumped back) is the due cycle, as if no time had passed: none is taken twice. Waking one or
    /// more whole cycles late skips to the newest one begun.
    #[must_use]
    pub fn take(&mut self, now: Instant<Local>) -> Tick {
        let late = now - self.next_start();
        let missed = late.div_floor(self.cycle_time.span()).max(0) as u64;
        let count = self.next + missed;
        self.overruns = self.overruns.saturating_add(missed);
        self.next = count + 1;
        Tick {
            count,
            ideal_start: self.start_of(count),
            elapsed: (missed + 1).min(u64::from(u32::MAX)) as u32,
        }
    }

    /// Moves the next cycle, and all after it, by this time: less than a cycle either way.
    pub fn shift(&mut self, by: Span) {
        // As if cycle 0 had begun so much later: counts go on by one.
        self.start += by;
    }

    fn start_of(&self, count: u64) -> Instant<Local> {
        self.start + self.cycle_time.span() * count as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(micros: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_micros(micros)
    }

    fn schedule() -> Schedule {
        Schedule::new(at(0), CycleTime::new(Span::from_millis(1)).unwrap())
    }

    #[test]
    fn the_index_steps_the_short_way_round_its_wrap() {
        assert_eq!(CycleIndex(2).steps_since(CycleIndex(65_534)), 4);
        assert_eq!(CycleIndex(65_534).steps_since(CycleIndex(2)), -4);
        assert_eq!(CycleIndex::of_count(65_536 + 7), CycleIndex(7));
    }

    #[test]
    fn cycle_times_end_at_their_bounds() {
        assert!(CycleTime::new(Span::from_micros(99)).is_err());
        assert!(CycleTime::new(Span::from_micros(100)).is_ok());
        assert!(CycleTime::new(Span::from_millis(100)).is_ok());
        assert!(CycleTime::new(Span::from_millis(101)).is_err());
    }

    #[test]
    fn a_punctual_node_takes_every_cycle() {
        let mut schedule = schedule();
        for k in 0..5 {
            let tick = schedule.take(at(1_000 * k + 20));
            assert_eq!((tick.count, tick.elapsed), (k as u64, 1));
            assert_eq!(tick.ideal_start, at(1_000 * k));
        }
        assert_eq!(schedule.overruns(), 0);
    }

    #[test]
    fn counts_may_begin_anywhere_and_the_index_wraps_with_them() {
        let cycle_time = CycleTime::new(Span::from_millis(1)).unwrap();
        for first in [65_535, u64::from(u32::MAX), 40_000_000_000] {
            let mut schedule = Schedule::counting_from(first, at(5_000), cycle_time);
            let zero = schedule.start();
            for k in 0..3 {
                let tick = schedule.take(at(5_000 + 1_000 * k));
                assert_eq!((tick.count, tick.elapsed), (first + k as u64, 1));
                assert_eq!(tick.ideal_start, at(5_000 + 1_000 * k));
                assert_eq!(
                    tick.ideal_start - zero,
                    cycle_time.span() * tick.count as i64
                );
                let index = CycleIndex::of_count(tick.count);
                assert_eq!(index.steps_since(CycleIndex::of_count(first)), k as i16);
            }
        }
    }

    #[test]
    fn more_skipped_cycles_than_elapsed_holds_are_skipped_all_the_same() {
        let mut schedule = schedule();
        let _ = schedule.take(at(0));
        let cycles = i64::from(u32::MAX) + 5;
        let tick = schedule.take(at(1_000 * cycles));
        assert_eq!((tick.count, tick.elapsed), (cycles as u64, u32::MAX));
        assert_eq!(tick.ideal_start, at(1_000 * cycles));
        let tick = schedule.take(schedule.next_start());
        assert_eq!((tick.count, tick.elapsed), (cycles as u64 + 1, 1));
    }

    #[test]
    fn a_late_node_skips_by_time_and_never_bursts() {
        let mut schedule = schedule();
        let _ = schedule.take(at(0));
        let tick = schedule.take(at(4_300));
        assert_eq!((tick.count, tick.elapsed), (4, 4));
        assert_eq!(tick.ideal_start, at(4_000));
        assert_eq!(schedule.overruns(), 3);
        assert_eq!(schedule.next_start(), at(5_000));
    }

    #[test]
    fn a_shift_moves_all_that_comes_and_no_count() {
        let mut schedule = schedule();
        let _ = schedule.take(at(0));
        schedule.shift(Span::from_micros(-300));
        assert_eq!(schedule.next_start(), at(700));
        let tick = schedule.take(at(705));
        assert_eq!((tick.count, tick.elapsed), (1, 1));
        assert_eq!(tick.ideal_start, at(700));
        assert_eq!(schedule.next_start(), at(1_700));
    }

    #[test]
    fn waking_early_is_still_the_due_cycle() {
        let mut schedule = schedule();
        let _ = schedule.take(at(0));
        let tick = schedule.take(at(990));
        assert_eq!((tick.count, tick.elapsed), (1, 1));
    }

    #[test]
    fn a_clock_that_jumps_back_takes_no_cycle_twice() {
        let mut schedule = schedule();
        let _ = schedule.take(at(5_000));
        for (now, count) in [(-4_000, 6), (-3_000, 7), (8_000, 8), (i64::MIN / 1_000, 9)] {
            let tick = schedule.take(at(now));
            assert_eq!((tick.count, tick.elapsed), (count, 1));
            assert_eq!(tick.ideal_start, at(1_000 * count as i64));
        }
        assert_eq!(schedule.next_start(), at(10_000));
    }
}
