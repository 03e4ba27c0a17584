//! Cycle of the PLC that a sample belongs to: a count from an index that wraps.

use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Span};

/// Tolerance between the count and the time since the newest one: that of a receiver for a sender.
const TOLERANCE: Span = Span::from_millis(100);
/// Additional tolerance, as a part of that time.
// 0.5 % is far more than clocks drift: a gap of 20 s doubles the tolerance.
const TOLERANCE_PER_TIME: f64 = 0.005;
/// Least number of samples that continue each other, but not the run before, that begin another run.
// At 1 ms a stray index fits another by chance in 200 of 65 536 cases, and four in a row with a probability of 10⁻¹⁰.
const SAMPLES_OF_A_RUN: u32 = 5;
/// Least time between the first and the last of them.
// Late samples come at once, such as the notifications that a lost segment of TCP has held back for 200 ms. They are of the run before, and the newest
// of them shows it.
const TIME_OF_A_RUN: Span = Span::from_millis(100);

/// Counts the cycles of a PLC by its index, a `WORD`, and the elapsed time.
///
/// The count begins with the first index, so that the index is its low 16 bits, and increases with the
/// index. Whole turns of the index follow from the elapsed time. A sample whose index does not match the
/// time is not a cycle of this run. Five such samples that match each other, over a tenth of a second, are a restarted PLC.
#[derive(Clone, Debug)]
pub struct IndexCounter {
    cycle_time: CycleTime,
    newest: Option<CountedSample>,
    run: u64,
    suspect: Option<SuspectedRun>,
    /// True if the next sample begins a run in any case.
    begins: bool,
}

#[derive(Clone, Copy, Debug)]
struct CountedSample {
    count: u64,
    index: CycleIndex,
    at: Instant<Local>,
}

/// A run that may have begun.
#[derive(Clone, Copy, Debug)]
struct SuspectedRun {
    since: Instant<Local>,
    newest: CountedSample,
    samples: u32,
}

impl SuspectedRun {
    const fn new(first: CountedSample) -> Self {
        Self {
            since: first.at,
            newest: first,
            samples: 1,
        }
    }

    /// True if it is one.
    fn is_sure(&self) -> bool {
        self.samples >= SAMPLES_OF_A_RUN && self.newest.at - self.since >= TIME_OF_A_RUN
    }
}

/// Classification of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleClass {
    /// A new cycle of the run.
    New {
        /// Count of the cycle.
        count: u64,
    },
    /// The first cycle of a run, independent of previous counts.
    Begun {
        /// Count of the cycle: its index.
        count: u64,
        /// Number of the run, from 0.
        run: u64,
    },
    /// A repetition of the newest cycle.
    Repeated,
    /// An older cycle than the newest.
    Outdated,
    /// Cycle of another run.
    Foreign,
}

impl IndexCounter {
    /// Counts the cycles of a PLC with this nominal cycle time.
    #[must_use]
    pub const fn new(cycle_time: CycleTime) -> Self {
        Self {
            cycle_time,
            newest: None,
            run: 0,
            suspect: None,
            begins: false,
        }
    }

    /// Discards the state of the PLC's count: the next sample begins a run.
    pub const fn reset(&mut self) {
        self.begins = true;
        self.suspect = None;
    }

    /// Classifies a sample with this index that arrived at `at`.
    pub fn classify(&mut self, index: CycleIndex, at: Instant<Local>) -> SampleClass {
        // The count begins with the first index.
        let Some(newest) = self.newest else {
            return self.begin(index, at);
        };
        if self.begins {
            self.run += 1;
            return self.begin(index, at);
        }
        match self.steps(newest, index, at) {
            Some(0) => SampleClass::Repeated,
            Some(steps) if steps < 0 => SampleClass::Outdated,
            Some(steps) => {
                // Saturating: no PLC counts that far, and a wrap would publish an old cycle.
                let count = newest.count.saturating_add(steps.unsigned_abs());
                self.newest = Some(CountedSample { count, index, at });
                // A sample of the run shows that the others were strays.
                self.suspect = None;
                SampleClass::New { count }
            }
            None => self.suspect(index, at),
        }
    }

    fn begin(&mut self, index: CycleIndex, at: Instant<Local>) -> SampleClass {
        let count = u64::from(index.0);
        self.newest = Some(CountedSample { count, index, at });
        self.begins = false;
        self.suspect = None;
        let run = self.run;
        SampleClass::Begun { count, run }
    }

    /// Remembers a sample that is not of this run.
    fn suspect(&mut self, index: CycleIndex, at: Instant<Local>) -> SampleClass {
        let count = u64::from(index.0);
        let this = CountedSample { count, index, at };
        let suspect = match self.suspect {
            Some(suspect) => match self.steps(suspect.newest, index, at) {
                // Samples of the new run continue each other.
                Some(steps) if steps > 0 => SuspectedRun {
                    newest: this,
                    samples: suspect.samples + 1,
                    ..suspect
                },
                // A repetition of the suspect adds nothing, and an older one neither.
                Some(_) => suspect,
                // Fits neither the run nor the suspect: the newest stray is the more likely beginning.
                None => SuspectedRun::new(this),
            },
            None => SuspectedRun::new(this),
        };
        if suspect.is_sure() {
            self.run += 1;
            return self.begin(index, at);
        }
        self.suspect = Some(suspect);
        SampleClass::Foreign
    }

    /// Returns the number of cycles from a counted one to an index; none if it does not match the time.
    fn steps(&self, from: CountedSample, index: CycleIndex, at: Instant<Local>) -> Option<i64> {
        let passed = (at - from.at).as_secs_f64();
        let expected = passed / self.cycle_time.as_secs_f64();
        // Modulo 2¹⁶: 0 to 65 535 steps forward.
        let least = f64::from(index.0.wrapping_sub(from.index.0));
        const TURN: f64 = 65_536.0;
        // The number of steps with this index that is nearest to the elapsed time; negative for an older one.
        let steps = least + TURN * ((expected - least) / TURN).round();
        let off = (steps - expected).abs() * self.cycle_time.as_secs_f64();
        // Once the tolerance exceeds a turn, every index matches.
        let allowed = TOLERANCE.as_secs_f64() + TOLERANCE_PER_TIME * passed.abs();
        // A quarter of a turn either way: after any silence at least half of all indices are refused.
        let quarter_turn = 0.25 * TURN * self.cycle_time.as_secs_f64();
        (off <= allowed.min(quarter_turn)).then_some(steps as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn counter() -> IndexCounter {
        IndexCounter::new(CycleTime::new(Span::from_millis(1)).unwrap())
    }

    fn ms(millis: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_millis(millis)
    }

    #[test]
    fn the_index_is_the_low_bits_of_the_count_through_wraps_and_gaps() {
        let mut counter = counter();
        let first = counter.classify(CycleIndex(65_530), ms(0));
        // Six cycles before the wrap at 65 536.
        let (count, run) = (65_530, 0);
        assert_eq!(first, SampleClass::Begun { count, run });
        // Ten cycles, then two turns and a short silence.
        // 140 s are more than two turns of 65.5 s.
        for passed in [1, 2, 5, 6, 10, 11, 12, 140_000, 140_001] {
            let count = 65_530 + passed as u64;
            let seen = counter.classify(CycleIndex(count as u16), ms(passed));
            assert_eq!(seen, SampleClass::New { count }, "after {passed} ms");
        }
    }

    #[test]
    fn a_repeated_and_an_older_index_are_told_apart_from_new_ones() {
        let mut counter = counter();
        let _ = counter.classify(CycleIndex(7), ms(0));
        assert_eq!(
            counter.classify(CycleIndex(7), ms(0)),
            SampleClass::Repeated
        );
        assert_eq!(
            counter.classify(CycleIndex(9), ms(2)),
            SampleClass::New { count: 9 }
        );
        assert_eq!(
            counter.classify(CycleIndex(8), ms(2)),
            SampleClass::Outdated
        );
        assert_eq!(
            counter.classify(CycleIndex(9), ms(3)),
            SampleClass::Repeated
        );
    }

    #[test]
    fn another_index_is_followed_only_after_it_came_for_a_tenth_of_a_second() {
        let mut counter = counter();
        let _ = counter.classify(CycleIndex(5_000), ms(0));
        for k in 1..=100 {
            let seen = counter.classify(CycleIndex(k), ms(i64::from(k)));
            assert_eq!(seen, SampleClass::Foreign);
        }
        // This one begins the run, with its own index as the count.
        let (count, run) = (101, 1);
        assert_eq!(
            counter.classify(CycleIndex(101), ms(101)),
            SampleClass::Begun { count, run }
        );
        assert_eq!(
            counter.classify(CycleIndex(102), ms(102)),
            SampleClass::New { count: 102 }
        );
    }

    #[test]
    fn samples_that_were_held_back_and_come_at_once_are_no_other_run() {
        let mut counter = counter();
        let _ = counter.classify(CycleIndex(0), ms(0));
        // All of 250 ms, at their end: those that are too late are left out, and the newest go on.
        for k in 1..=250 {
            let seen = counter.classify(CycleIndex(k), ms(250));
            // The tolerance is 0.1 s, and 0.5 % of the 0.25 s.
            match k < 149 {
                true => assert_eq!(seen, SampleClass::Foreign, "{k}"),
                false => assert!(matches!(seen, SampleClass::New { .. }), "{k}"),
            }
        }
        let seen = counter.classify(CycleIndex(251), ms(251));
        assert_eq!(seen, SampleClass::New { count: 251 });
        assert_eq!(counter.run, 0);
    }

    #[test]
    fn single_foreign_samples_are_left_out() {
        let mut counter = counter();
        let _ = counter.classify(CycleIndex(0), ms(0));
        for k in 1..1_000_i64 {
            let good = counter.classify(CycleIndex(k as u16), ms(k));
            assert_eq!(good, SampleClass::New { count: k as u64 });
            // Far from this run, and from each other.
            // 7919 is prime: the strays neither repeat nor continue each other within five.
            let wild = k + 20_000 + k * 7_919 % 20_000;
            let seen = counter.classify(CycleIndex(wild as u16), ms(k));
            assert_eq!(seen, SampleClass::Foreign);
        }
        assert_eq!(counter.run, 0);
    }

    #[test]
    fn after_track_was_lost_the_next_sample_begins_a_run() {
        let mut counter = counter();
        counter.reset();
        let _ = counter.classify(CycleIndex(3), ms(0));
        counter.reset();
        let (count, run) = (4, 1);
        assert_eq!(
            counter.classify(CycleIndex(4), ms(1)),
            SampleClass::Begun { count, run }
        );
    }

    proptest! {
        /// For any gaps (of less than a minute), jitter and drift, the count is that of the cycle.
        #[test]
        fn the_count_is_right_whatever_is_missed(
            // Any start of the index, so that wraps lie anywhere.
            first in any::<u16>(),
            // Over a minute the tolerance is 0.1 s and 0.5 %, 0.4 s: jitter of 5 ms and 2000 ppm take 0.125 s of it.
            gaps in proptest::collection::vec(1_i64..60_000, 1..40),
            jitter in proptest::collection::vec(0_i64..5_000_000, 40),
            drift_ppm in -2_000_i64..2_000,
        ) {
            let mut counter = counter();
            let mut count = i64::from(first);
            let at = |count: i64, jitter: i64| {
                Instant::from_nanos(count * (1_000_000 + drift_ppm) + jitter)
            };
            let _ = counter.classify(CycleIndex(first), at(count, 0));
            for (gap, jitter) in gaps.iter().zip(&jitter) {
                count += gap;
                let seen = counter.classify(CycleIndex::of_count(count as u64), at(count, *jitter));
                prop_assert_eq!(seen, SampleClass::New { count: count as u64 });
            }
        }
    }
}
