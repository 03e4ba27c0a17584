//! How old is a message? Judged by its cycle count, never by its arrival.
//!
//! A receiver that was stopped finds thousands of messages in its mailbox, all just arrived and up
//! to seconds old. The gate remembers how early a count can arrive at best, and so knows what a
//! message's age is at any later instant.

use crate::cycle::CycleTime;
use crate::instant::{Instant, Local, Span};

/// The best arrival is forgotten this fast, so that a slower sender does not grow old: its pace is judged
/// elsewhere, and one far beyond what quartzes do must be heard to be named. A backlog is older by three orders.
const FORGETTING_PPM: i64 = 20_000;
/// Silence forgets nothing beyond this, or a backlog would seem younger the longer it is.
const LONGEST_FORGETTING: Span = Span::from_millis(100);

/// A sender whose count fell behind for good (its machine slept) is believed again after so long at
/// its regular pace.
const PATIENCE: Span = Span::from_secs(1);

/// Judges the age of one sender's messages.
#[derive(Clone, Copy, Debug)]
pub struct AgeGate {
    cycle_time: CycleTime,
    limit: Span,
    best: Option<Arrival>,
    late_since: Option<Late>,
}

/// When count 0 would have arrived, by the earliest message known; and when that was found out.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    of_count_zero: Instant<Local>,
    known_at: Instant<Local>,
}

/// The first of an unbroken row of late messages.
#[derive(Clone, Copy, Debug)]
struct Late {
    at: Instant<Local>,
    of_count_zero: Instant<Local>,
}

/// What the gate says of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Age {
    /// Young enough to use.
    Fresh,
    /// Older than the limit, by the sender's count.
    Stale,
}

impl AgeGate {
    /// A gate for a sender of the given nominal cycle time. Messages older than `limit` are stale.
    #[must_use]
    pub const fn new(cycle_time: CycleTime, limit: Span) -> Self {
        Self {
            cycle_time,
            limit,
            best: None,
            late_since: None,
        }
    }

    /// Judges message number `count`, which arrived at `arrived`, at the instant `now` of its use.
    pub fn judge(&mut self, count: u64, arrived: Instant<Local>, now: Instant<Local>) -> Age {
        let of_count_zero = arrived - self.cycle_time.span() * count as i64;
        let best = self.best_at(arrived, of_count_zero);
        let lateness = of_count_zero - best;
        let age = lateness + (now - arrived);
        if age <= self.limit {
            self.late_since = None;
            return Age::Fresh;
        }
        if lateness > self.limit && self.is_regular(arrived, of_count_zero) {
            // Not a backlog but a sender whose count fell behind: start over with it.
            *self = Self::new(self.cycle_time, self.limit);
            return self.judge(count, arrived, now);
        }
        Age::Stale
    }

    fn best_at(
        &mut self,
        arrived: Instant<Local>,
        of_count_zero: Instant<Local>,
    ) -> Instant<Local> {
        let best = match self.best {
            None => of_count_zero,
            Some(best) => {
                let passed = (arrived - best.known_at).clamp(Span::ZERO, LONGEST_FORGETTING);
                let forgotten = passed * FORGETTING_PPM / 1_000_000;
                of_count_zero.min(best.of_count_zero + forgotten)
            }
        };
        self.best = Some(Arrival {
            of_count_zero: best,
            known_at: arrived,
        });
        best
    }

    /// Late messages that keep the sender's pace for long enough. A backlog comes far faster.
    fn is_regular(&mut self, at: Instant<Local>, of_count_zero: Instant<Local>) -> bool {
        let late = *self.late_since.get_or_insert(Late { at, of_count_zero });
        if (of_count_zero - late.of_count_zero).abs() > self.limit {
            self.late_since = Some(Late { at, of_count_zero });
            return false;
        }
        at - late.at >= PATIENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Span = Span::from_millis(7);

    fn gate() -> AgeGate {
        AgeGate::new(CycleTime::new(Span::from_millis(1)).unwrap(), LIMIT)
    }

    fn at_micros(micros: i64) -> Instant<Local> {
        Instant::EPOCH + Span::from_micros(micros)
    }

    #[test]
    fn regular_messages_are_fresh_whatever_the_drift() {
        for cycle_micros in [990, 999, 1_000, 1_001, 1_003, 1_015] {
            let mut gate = gate();
            for count in 0..100_000 {
                let arrived = at_micros(300 + cycle_micros * count);
                assert_eq!(gate.judge(count as u64, arrived, arrived), Age::Fresh);
            }
        }
    }

    #[test]
    fn a_backlog_is_stale_but_for_its_newest() {
        let mut gate = gate();
        for count in 0..1_000 {
            let arrived = at_micros(1_000 * count);
            assert_eq!(gate.judge(count as u64, arrived, arrived), Age::Fresh);
        }
        // Stopped for three seconds; then all of it within a millisecond.
        let fresh = (1_000..4_000)
            .filter(|count| {
                let arrived = at_micros(4_000_000 + (count - 1_000) / 3);
                gate.judge(*count as u64, arrived, arrived) == Age::Fresh
            })
            .count();
        assert!((1..=8).contains(&fresh), "{fresh}");
    }

    #[test]
    fn a_message_ages_while_it_waits() {
        let mut gate = gate();
        let arrived = at_micros(0);
        assert_eq!(gate.judge(0, arrived, arrived), Age::Fresh);
        assert_eq!(gate.judge(0, arrived, arrived + LIMIT), Age::Fresh);
        let later = arrived + LIMIT + Span::from_nanos(1);
        assert_eq!(gate.judge(0, arrived, later), Age::Stale);
    }

    #[test]
    fn a_sender_that_slept_is_believed_again_after_a_second() {
        let mut gate = gate();
        for count in 0..1_000 {
            let _ = gate.judge(
                count,
                at_micros(1_000 * count as i64),
                at_micros(1_000 * count as i64),
            );
        }
        let first_fresh = (1_000..9_000_u64).find(|count| {
            let arrived = at_micros(10_000_000 + 1_000 * *count as i64);
            gate.judge(*count, arrived, arrived) == Age::Fresh
        });
        assert!(
            first_fresh.is_some_and(|count| (1_990..2_010).contains(&count)),
            "{first_fresh:?}"
        );
    }
}
