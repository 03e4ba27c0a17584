//! A hop: from a node to its router, from a router to the next, or from a router to a node.

use coaxle_clock::{Instant, Span};
use coaxle_node::config::{LinkConfig, Wrong};
use coaxle_node::faults::LinkModel;

use crate::true_time::True;

/// Messages and their bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Load {
    /// Messages.
    pub messages: u64,
    /// Payload bytes, without those a transport adds.
    pub bytes: u64,
}

impl Load {
    pub(crate) const fn add(&mut self, other: Self) {
        self.messages += other.messages;
        self.bytes += other.bytes;
    }
}

/// End of a hop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Router(usize),
    Node(usize),
}

/// A link in one direction.
pub(crate) struct Hop {
    pub(crate) to: End,
    model: LinkModel,
    line: Throttle,
    /// Messages sent over it.
    pub(crate) sent: Load,
    /// Messages dropped for lack of room.
    pub(crate) dropped: u64,
}

impl Hop {
    pub(crate) fn new(
        to: End,
        config: &LinkConfig,
        seed: u64,
        line: Throttle,
    ) -> Result<Self, Wrong> {
        Ok(Self {
            to,
            model: LinkModel::new(config, seed)?,
            line,
            sent: Load::default(),
            dropped: 0,
        })
    }

    /// Sends a frame at true time `at`; returns the instants of its arrivals, none if it is lost.
    pub(crate) fn send(
        &mut self,
        at: Instant<True>,
        bytes: usize,
    ) -> impl Iterator<Item = Instant<True>> {
        // The line first, then the delay: a message occupies the line whether or not it is lost further on.
        let left = self.line.pass(at, bytes);
        match left {
            Some(_) => self.sent.add(Load {
                messages: 1,
                bytes: bytes as u64,
            }),
            None => self.dropped += 1,
        }
        let arrivals = left.map(|left| {
            // Delays are those of the instant at which it leaves the line, as its behaviour varies over time.
            let delays = self.model.offer(left.since_epoch());
            delays.map(move |delay| left + delay)
        });
        arrivals.into_iter().flatten()
    }
}

/// A serial line: messages pass one after the other, each in its own time, behind a queue of
/// limited length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Throttle {
    per_message: Span,
    ns_per_byte: f64,
    most_wait: Span,
    free_at: Instant<True>,
}

impl Throttle {
    pub(crate) const fn new(per_message: Span, ns_per_byte: f64, most_wait: Span) -> Self {
        Self {
            per_message,
            ns_per_byte,
            most_wait,
            free_at: Instant::EPOCH,
        }
    }

    /// End of the passage of a message that arrives at `at`; none if it would have to wait too long.
    pub(crate) fn pass(&mut self, at: Instant<True>, bytes: usize) -> Option<Instant<True>> {
        let begin = at.max(self.free_at);
        // A refused message must not move `free_at`: otherwise a full queue would never drain.
        if begin - at > self.most_wait {
            return None;
        }
        let by_size = Span::from_nanos((self.ns_per_byte * bytes as f64).round() as i64);
        self.free_at = begin + self.per_message + by_size;
        Some(self.free_at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(micros: i64) -> Instant<True> {
        Instant::from_nanos(micros * 1_000)
    }

    #[test]
    fn messages_queue_up_and_what_would_wait_too_long_is_dropped() {
        let mut line = Throttle::new(Span::from_micros(10), 1_000.0, Span::from_micros(25));
        // Two microseconds for its bytes, ten in addition.
        assert_eq!(line.pass(at(0), 2), Some(at(12)));
        assert_eq!(line.pass(at(0), 2), Some(at(24)));
        assert_eq!(line.pass(at(0), 2), Some(at(36)));
        assert_eq!(line.pass(at(0), 2), None, "it would wait for 36 µs");
        assert_eq!(line.pass(at(11), 2), Some(at(48)));
        assert_eq!(line.pass(at(100), 0), Some(at(110)));
    }

    proptest! {
        #[test]
        fn nothing_overtakes_nothing_waits_longer_than_the_queue_and_no_more_passes_than_the_rate(
            gaps in prop::collection::vec((0..40i64, 0..300usize), 1..200),
        ) {
            let most = Span::from_micros(50);
            let mut line = Throttle::new(Span::from_micros(7), 50.0, most);
            let (mut now, mut before) = (0, at(0));
            for (gap, bytes) in gaps {
                now += gap;
                let took = Span::from_micros(7) + Span::from_nanos(50 * bytes as i64);
                if let Some(through) = line.pass(at(now), bytes) {
                    prop_assert!(through >= before + took);
                    prop_assert!(through - at(now) <= most + took);
                    before = through;
                }
            }
        }
    }
}
