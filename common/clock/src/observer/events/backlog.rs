//! A backlog that comes while a line is still being found.
//!
//! A receiver that stood still finds all that a sender has sent meanwhile, and takes it in at once. Each of these messages
//! waited, the first one for longest: phases that fall by a second per second. A line that is known is not misled by
//! them, while one that is not would not get over them for minutes. Only the last of them says when it was sent.

use super::Arrival;
use crate::instant::Span;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of a backlog.
    BacklogTuning {
        /// Least time, s, by which the phases of messages that come together fall in a backlog.
        // Jitter and pauses of a thread are shorter: with 0.01 s a recording of a busy machine is 0.31 µs off (its bound is 0.18). With 0.03 s a pause of
        // as much at the very start leaves a line locking for more than 5 s.
        fallen: f64 = 0.02,
    }
}

/// Picks the messages of a run, as long as its line is being found.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::observer) enum Backlog {
    /// No message as yet.
    #[default]
    Empty,
    /// Messages as they come, with the first of those that came together last.
    None(Arrival),
    /// All messages since then came together. The last of them waits for the first that does not.
    Lasts(Arrival),
    /// No more of it: a path on which that comes again and again is another matter.
    Over,
}

/// The use of a message.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) enum Pace {
    /// Use: it came at its time.
    Usual,
    /// Begin of a backlog: kept back, and those before were of no use.
    Backlog,
    /// More of the backlog: kept back, too.
    More,
    /// Use of the last one of the backlog, and then of this one.
    After(Arrival),
}

impl Backlog {
    /// Takes a message, and whether it came together with the one before. Messages are sent in this `cycle`.
    pub(in crate::observer) fn take(
        &mut self,
        arrival: Arrival,
        together: bool,
        cycle: Span,
    ) -> Pace {
        match *self {
            Self::None(first) if together => {
                if !first.is_late_beside(&arrival, cycle) {
                    return Pace::Usual;
                }
                *self = Self::Lasts(arrival);
                Pace::Backlog
            }
            Self::Lasts(last) if together => {
                // They need not come in their order.
                if arrival.count > last.count {
                    *self = Self::Lasts(arrival);
                }
                Pace::More
            }
            Self::Lasts(last) => {
                *self = Self::Over;
                Pace::After(last)
            }
            Self::Empty | Self::None(_) => {
                *self = Self::None(arrival);
                Pace::Usual
            }
            Self::Over => Pace::Usual,
        }
    }

    /// Notes that the line is known.
    pub(in crate::observer) const fn end(&mut self) {
        if !matches!(self, Self::Lasts(_)) {
            *self = Self::Over;
        }
    }
}

impl Arrival {
    /// True if it came so much later than a following one, as seen from when both were sent, that it was in a backlog.
    pub(in crate::observer) fn is_late_beside(&self, last: &Self, cycle: Span) -> bool {
        let sent = last.count.saturating_sub(self.count) as f64 * cycle.as_secs_f64();
        sent - (last.at - self.at).as_secs_f64() >= TUNING.fallen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::Instant;

    const CYCLE: Span = Span::from_millis(2);

    fn take(backlog: &mut Backlog, count: u64, together: bool) -> Pace {
        let arrival = Arrival {
            count,
            at: Instant::EPOCH,
            send_stamp: None,
        };
        backlog.take(arrival, together, CYCLE)
    }

    #[test]
    fn of_a_backlog_the_largest_count_is_used() {
        let mut backlog = Backlog::default();
        for count in 3..13 {
            assert!(matches!(take(&mut backlog, count, count > 3), Pace::Usual));
        }
        assert!(matches!(take(&mut backlog, 13, true), Pace::Backlog));
        for count in [15, 14] {
            assert!(matches!(take(&mut backlog, count, true), Pace::More));
        }
        backlog.end();
        let after = take(&mut backlog, 16, false);
        assert!(matches!(after, Pace::After(last) if last.count == 15));
        // Later ones are none of a beginning.
        for count in 17..100 {
            assert!(matches!(take(&mut backlog, count, true), Pace::Usual));
        }
    }

    #[test]
    fn messages_that_fall_by_less_are_all_used() {
        let mut backlog = Backlog::default();
        for count in 0..1_000 {
            assert!(matches!(
                take(&mut backlog, count, count % 10 != 0),
                Pace::Usual
            ));
        }
        // Nor are those of a line that is known any backlog.
        backlog.end();
        for count in 1_000..2_000 {
            assert!(matches!(take(&mut backlog, count, true), Pace::Usual));
        }
    }
}
