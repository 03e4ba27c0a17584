//! The pace of a sender: length of its cycles by the own clock, compared with its frames.

use coaxle_clock::{CycleTime, Instant, Local, Span};

/// The largest difference that is followed, ppm in both directions: beyond that of any two
/// quartzes, and of clocks that are slewed (500 ppm by NTP, 2 000 in the scenario faults/drift).
/// Such a sender does not have its stated cycle time.
pub(crate) const LARGEST_PPM: f64 = 2_500.0;
/// The least delayed frames of one such span and of the next give the pace: 5 ms of other delay are 5 000 ppm, …
const BLOCK: Span = Span::from_secs(1);
/// … which is accepted once this number of consecutive blocks agree.
// Four on one side need a delay that grows by more than 2.5 ms in each second, 10 ms in all.
const BLOCKS: u32 = 4;

/// Measures the pace of one run of a sender.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    cycle_time: CycleTime,
    start: Instant<Local>,
    least_delayed: PaceMark,
    before: Option<PaceMark>,
    ppm: Option<f64>,
    /// Consecutive blocks that were too slow (negative) or too fast.
    beyond: i32,
    is_refused: bool,
}

/// A frame, by the arrival of count 0 with its delay.
#[derive(Clone, Copy, Debug)]
struct PaceMark {
    at: Instant<Local>,
    of_count_zero: Instant<Local>,
}

impl Pace {
    /// Starts with a run whose first frame has this count and arrived at `at`.
    pub(super) fn starting(at: Instant<Local>, count: u64, cycle_time: CycleTime) -> Self {
        Self {
            cycle_time,
            start: at,
            least_delayed: PaceMark::of(at, count, cycle_time),
            before: None,
            ppm: None,
            beyond: 0,
            is_refused: false,
        }
    }

    /// Takes a frame.
    pub(super) fn take(&mut self, at: Instant<Local>, count: u64) {
        let mark = PaceMark::of(at, count, self.cycle_time);
        if at - self.start >= BLOCK {
            self.end_block();
            self.start = at;
            self.least_delayed = mark;
        // The arrival of count 0 is early where the delay is short, whatever the count of the frame.
        } else if mark.of_count_zero < self.least_delayed.of_count_zero {
            self.least_delayed = mark;
        }
    }

    /// Deviation of the sender's cycles per own time from its stated ones; positive: it is fast.
    /// None in its first seconds.
    pub(super) const fn ppm(&self) -> Option<f64> {
        self.ppm
    }

    /// True if the pace is too far off to be followed.
    pub(super) const fn is_refused(&self) -> bool {
        self.is_refused
    }

    fn end_block(&mut self) {
        let now = self.least_delayed;
        let Some(before) = self.before.replace(now) else {
            return;
        };
        let passed = (now.at - before.at).as_secs_f64();
        // Messages that overtake each other can put the marks of two blocks into the wrong order.
        if passed <= 0.0 {
            return;
        }
        let later = (now.of_count_zero - before.of_count_zero).as_secs_f64();
        // A count 0 that seems to arrive later and later belongs to cycles that are longer than stated: a slow
        // sender.
        let ppm = -1e6 * later / passed;
        self.ppm = Some(ppm);
        self.beyond = if ppm > LARGEST_PPM {
            // A change of sides starts over: delays that go up and down again are no pace.
            self.beyond.max(0).saturating_add(1)
        } else if ppm < -LARGEST_PPM {
            self.beyond.min(0).saturating_sub(1)
        } else {
            0
        };
        self.is_refused = self.beyond.unsigned_abs() >= BLOCKS;
    }
}

impl PaceMark {
    fn of(at: Instant<Local>, count: u64, cycle_time: CycleTime) -> Self {
        Self {
            at,
            // The product saturates, so that a count without meaning gives a far instant and no panic.
            of_count_zero: at - cycle_time.span() * count as i64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace() -> Pace {
        let cycle_time = CycleTime::new(Span::from_millis(1)).unwrap();
        Pace::starting(Instant::EPOCH, 0, cycle_time)
    }

    /// Ten seconds of frames, each a number of nanoseconds of the own clock after the one before.
    fn run(nanos: i64, delay: impl Fn(i64) -> i64) -> Pace {
        let mut pace = pace();
        for count in 1..10_000 {
            let at = Instant::EPOCH + Span::from_nanos(nanos * count + delay(count));
            pace.take(at, count as u64);
        }
        pace
    }

    #[test]
    fn a_pace_out_of_range_is_refused_and_one_within_is_not() {
        for (nanos, expected) in [
            (1_003_009, -3_000.0),
            (997_009, 3_000.0),
            (1_050_000, -47_619.0),
        ] {
            let pace = run(nanos, |_| 0);
            assert!(pace.is_refused(), "{nanos}");
            let ppm = pace.ppm().unwrap();
            assert!((ppm / expected - 1.0).abs() < 0.06, "{nanos}: {ppm}");
        }
        for nanos in [1_000_000, 1_002_200, 997_800] {
            assert!(!run(nanos, |_| 0).is_refused(), "{nanos}");
        }
    }

    #[test]
    fn neither_jitter_nor_a_backlog_is_a_pace() {
        let jitter = |count: i64| (count * 7_919 % 20_011) * 1_000;
        assert!(!run(1_000_000, jitter).is_refused());
        // Reception pauses for three seconds, then catches up.
        let backlog = |count: i64| match count {
            4_000..7_000 => (7_000 - count) * 1_000_000,
            _ => 0,
        };
        assert!(!run(1_000_000, backlog).is_refused());
    }

    #[test]
    fn a_pace_that_is_right_again_is_followed_again() {
        let mut pace = run(1_003_000, |_| 0);
        for count in 10_000..13_000_i64 {
            let at = Span::from_nanos(1_003_000 * 10_000 + 1_000_000 * (count - 10_000));
            pace.take(Instant::EPOCH + at, count as u64);
        }
        assert!(!pace.is_refused());
    }
}
