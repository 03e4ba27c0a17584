//! The backlog that a run may begin with.
//!
//! A receiver that stood still finds all that a sender has sent meanwhile, and takes it in at once. Each of these messages
//! waited, the first one for longest: phases that fall by a second per second, which neither line would get over for
//! minutes. Only the last of them says when it was sent.

use super::Arrival;

/// Picks the messages of a run's beginning.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::observer) enum Backlog {
    /// No message as yet.
    #[default]
    Empty,
    /// The first message alone, which may have waited.
    First,
    /// All messages came together so far. The last of them waits for the first that does not.
    Lasts(Arrival),
    /// Messages come at their pace, now or from the start.
    Over,
}

/// The use of a message.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) enum Begun {
    /// It is used.
    Message,
    /// It is kept back, and the one before was of no use.
    Forget,
    /// It is kept back, too.
    Nothing,
    /// The last one of the backlog is used, and then this one.
    After(Arrival),
}

impl Backlog {
    /// Takes a message, and whether it came together with the one before.
    pub(in crate::observer) const fn take(&mut self, arrival: Arrival, together: bool) -> Begun {
        match *self {
            Self::Empty => {
                *self = Self::First;
                Begun::Message
            }
            Self::First if together => {
                *self = Self::Lasts(arrival);
                Begun::Forget
            }
            Self::Lasts(last) if together => {
                // They need not come in their order.
                if arrival.count > last.count {
                    *self = Self::Lasts(arrival);
                }
                Begun::Nothing
            }
            Self::Lasts(last) => {
                *self = Self::Over;
                Begun::After(last)
            }
            Self::First | Self::Over => {
                *self = Self::Over;
                Begun::Message
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::Instant;

    fn arrival(count: u64) -> Arrival {
        Arrival {
            count,
            at: Instant::EPOCH,
            send_stamp: None,
        }
    }

    #[test]
    fn of_a_backlog_the_largest_count_is_used() {
        let mut backlog = Backlog::default();
        assert!(matches!(backlog.take(arrival(10), true), Begun::Message));
        assert!(matches!(backlog.take(arrival(11), true), Begun::Forget));
        for count in [13, 12] {
            assert!(matches!(backlog.take(arrival(count), true), Begun::Nothing));
        }
        let after = backlog.take(arrival(14), false);
        assert!(matches!(after, Begun::After(last) if last.count == 13));
        // Later ones are none of a beginning.
        assert!(matches!(backlog.take(arrival(15), true), Begun::Message));
    }

    #[test]
    fn messages_at_their_pace_are_all_used() {
        let mut backlog = Backlog::default();
        for count in 11..20 {
            assert!(matches!(
                backlog.take(arrival(count), count > 14),
                Begun::Message
            ));
        }
    }
}
