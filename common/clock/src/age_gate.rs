//! Age of a message, judged by its cycle count, never by its arrival.
//!
//! A receiver that was stopped finds thousands of messages in its mailbox, all just arrived and up
//! to seconds old. The gate remembers how early a count can arrive at best, and so knows what a
//! message's age is at any later instant.
//!
//! A mailbox that is emptied in pieces comes below the limit before it is empty. What is taken out then is still part of
//! the backlog, and its counts pass faster than the sender's cycles do: a clock that starts with it learns a wrong
//! pace. So it counts as stale until messages come at the sender's pace again.

use crate::cycle::CycleTime;
use crate::instant::{Instant, Local, Span};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the gate.
    AgeGateTuning {
        /// Rate at which the best arrival is forgotten, so that a slower sender does not grow old.
        // Its pace is judged elsewhere, and one far beyond what quartzes do must be received to be named. A backlog is older by three orders.
        forgetting_ppm: i64 = 20_000,
        /// Silence forgets nothing beyond this, or a backlog would seem younger the longer it is.
        longest_forgetting: Span = Span::from_millis(100),
        /// Time at its regular pace after which a sender whose count fell behind for good (its machine slept) is believed
        /// again.
        regular_for: Span = Span::from_secs(1),
        /// A backlog is over once this number of messages in a row came no less late than the least late one since it began.
        // Pieces of a few messages that are read by bytes are uneven by one.
        paced: u8 = 4,
        /// Part of a cycle, as its divisor, beyond which a message counts as less late.
        // Below it is jitter.
        fallen: i64 = 8,
    }
}

/// Judges the age of one sender's messages.
#[derive(Clone, Copy, Debug)]
pub struct AgeGate {
    cycle_time: CycleTime,
    limit: Span,
    best: Option<Arrival>,
    late_since: Option<Late>,
    /// Arrival of the newest message that was fresh.
    fresh_at: Option<Instant<Local>>,
    backlog: Option<Backlog>,
}

/// Messages that waited while nothing was fresh for longer than the limit.
#[derive(Clone, Copy, Debug)]
struct Backlog {
    /// Arrival of count 0 by the least late of them: its lateness against the best arrival does not matter, as that
    /// is forgotten while a large backlog is emptied.
    least: Instant<Local>,
    /// Messages in a row since then that were no less late.
    paced: u8,
}

/// Arrival of count 0 by the earliest message known; and the time when that was found out.
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

/// Age of a message, as the gate judges it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Age {
    /// Young enough to use.
    Fresh,
    /// Older than the limit, by the sender's count.
    Stale,
}

impl AgeGate {
    /// Makes a gate for a sender of the given nominal cycle time. Messages older than `limit` are stale.
    #[must_use]
    pub const fn new(cycle_time: CycleTime, limit: Span) -> Self {
        Self {
            cycle_time,
            limit,
            best: None,
            late_since: None,
            fresh_at: None,
            backlog: None,
        }
    }

    /// Judges message number `count`, which arrived at `arrived`, at the instant `now` of its use.
    pub fn judge(&mut self, count: u64, arrived: Instant<Local>, now: Instant<Local>) -> Age {
        let of_count_zero = arrived - self.cycle_time.span() * count as i64;
        let best = self.best_at(arrived, of_count_zero);
        let lateness = of_count_zero - best;
        let is_backlog = self.is_backlog(arrived, of_count_zero, lateness > self.limit);
        // Late by its count when it came, and older by every cycle that it waits.
        let age = lateness + (now - arrived);
        if age <= self.limit {
            self.late_since = None;
            if is_backlog {
                return Age::Stale;
            }
            self.fresh_at = Some(arrived);
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
                let passed = (arrived - best.known_at).clamp(Span::ZERO, TUNING.longest_forgetting);
                let forgotten = passed * TUNING.forgetting_ppm / 1_000_000;
                of_count_zero.min(best.of_count_zero + forgotten)
            }
        };
        self.best = Some(Arrival {
            of_count_zero: best,
            known_at: arrived,
        });
        best
    }

    /// True if the message is part of a backlog after a silence, and messages do not keep the sender's pace yet.
    fn is_backlog(
        &mut self,
        arrived: Instant<Local>,
        of_count_zero: Instant<Local>,
        is_late: bool,
    ) -> bool {
        let was_silent = || (self.fresh_at).is_some_and(|fresh| arrived - fresh > self.limit);
        if self.backlog.is_none() && !(is_late && was_silent()) {
            return false;
        }
        let fallen = self.cycle_time.span() / TUNING.fallen;
        let backlog = match self.backlog {
            Some(Backlog { least, paced }) if of_count_zero > least - fallen => Backlog {
                least: least.min(of_count_zero),
                paced: paced + 1,
            },
            _ => Backlog {
                least: of_count_zero,
                paced: 0,
            },
        };
        self.backlog = Some(backlog).filter(|backlog| backlog.paced < TUNING.paced);
        self.backlog.is_some()
    }

    /// Reports late messages that keep the sender's pace for long enough. A backlog comes far faster.
    fn is_regular(&mut self, at: Instant<Local>, of_count_zero: Instant<Local>) -> bool {
        let late = *self.late_since.get_or_insert(Late { at, of_count_zero });
        // Faster or slower than the sender's pace: part of a backlog, or another gap.
        if (of_count_zero - late.of_count_zero).abs() > self.limit {
            self.late_since = Some(Late { at, of_count_zero });
            return false;
        }
        at - late.at >= TUNING.regular_for
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
    fn a_backlog_is_stale_until_messages_keep_pace_again() {
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
        assert_eq!(fresh, 0);
        // Then they keep pace, but the first of them do not show that yet.
        let fresh = (4_000..4_010).filter(|count| {
            let arrived = at_micros(1_000 * count + 2_000);
            gate.judge(*count as u64, arrived, arrived) == Age::Fresh
        });
        assert_eq!(fresh.min(), Some(4_003));
    }

    /// A receiver that stood for three seconds and then takes this number of messages per cycle out of its mailbox: how many
    /// messages are left in there when the first fresh one comes.
    fn left_at_first_fresh(piece: u64, limit: Span) -> u64 {
        let mut gate = AgeGate::new(CycleTime::new(Span::from_millis(1)).unwrap(), limit);
        for count in 0..1_000 {
            let arrived = at_micros(1_000 * count);
            assert_eq!(gate.judge(count as u64, arrived, arrived), Age::Fresh);
        }
        let mut next = 1_000;
        for cycle in 4_000_u64.. {
            let arrived = at_micros(1_000 * cycle as i64);
            for _ in 0..piece {
                if next <= cycle {
                    if gate.judge(next, arrived, arrived) == Age::Fresh {
                        return cycle - next;
                    }
                    next += 1;
                }
            }
        }
        unreachable!("cycles go on for ever");
    }

    #[test]
    fn nothing_of_a_backlog_that_is_emptied_in_pieces_is_fresh() {
        for limit in [7, 100, 500].map(Span::from_millis) {
            for piece in [2, 3, 5, 40, 400, 5_000] {
                assert_eq!(left_at_first_fresh(piece, limit), 0, "{piece} {limit:?}");
            }
        }
    }

    #[test]
    fn messages_that_come_in_bunches_are_fresh_again_after_two_of_them() {
        let mut gate = gate();
        let mut fresh_from = None;
        for count in 0..3_000_u64 {
            // Four at a time; nothing for two seconds.
            let bunch = count / 4 * 4 + 3;
            let arrived = at_micros(1_000 * bunch.max(if count < 500 { 0 } else { 2_500 }) as i64);
            match gate.judge(count, arrived, arrived) {
                Age::Stale => fresh_from = None,
                Age::Fresh => fresh_from = fresh_from.or(Some(count)),
            }
        }
        assert!(
            fresh_from.is_some_and(|from| (2_500..2_512).contains(&from)),
            "{fresh_from:?}"
        );
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
