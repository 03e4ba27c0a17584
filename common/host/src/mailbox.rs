//! The mailbox: what arrived, on its way from the network's thread into the cycle thread.
//!
//! A bounded, wait-free ring of plain records. When it is full a message is rejected and counted;
//! neither side ever waits for the other.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use coaxle_clock::Instant;
use coaxle_node::Message;
use rtrb::{Consumer, Producer, RingBuffer};

use crate::machine::Machine;

/// One message with its arrival.
#[derive(Clone, Copy, Debug)]
pub struct Letter {
    /// When it arrived; with faults laid over the link this may lie in the future.
    pub arrival: Instant<Machine>,
    /// What arrived.
    pub message: Message,
}

/// The end that the network fills.
#[derive(Debug)]
pub struct Inbox {
    ring: Producer<Letter>,
    rejected: Arc<AtomicU64>,
}

/// The end that the cycle thread empties.
#[derive(Debug)]
pub struct Mailbox {
    ring: Consumer<Letter>,
}

/// A mailbox for `capacity` letters. Every letter that finds it full adds one to `rejected`.
#[must_use]
pub fn mailbox(capacity: usize, rejected: Arc<AtomicU64>) -> (Inbox, Mailbox) {
    let (producer, consumer) = RingBuffer::new(capacity);
    let inbox = Inbox {
        ring: producer,
        rejected,
    };
    (inbox, Mailbox { ring: consumer })
}

impl Inbox {
    /// Puts a letter in, or counts it as rejected.
    pub fn push(&mut self, letter: Letter) {
        if self.ring.push(letter).is_err() {
            self.rejected.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Mailbox {
    /// Takes what is in it now. Letters that come in meanwhile wait for the next time, so a flood
    /// cannot hold up the cycle for longer than a full ring takes.
    pub fn drain(&mut self, mut each: impl FnMut(Letter)) {
        for _ in 0..self.ring.slots() {
            match self.ring.pop() {
                Ok(letter) => each(letter),
                Err(_) => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::Rejection;

    fn letter(nanos: i64) -> Letter {
        Letter {
            arrival: Instant::from_nanos(nanos),
            message: Message::Rejected(Rejection::Malformed),
        }
    }

    #[test]
    fn letters_come_out_in_order_and_a_full_box_counts() {
        let rejected = Arc::new(AtomicU64::new(0));
        let (mut inbox, mut mailbox) = mailbox(4, Arc::clone(&rejected));
        (0..7).for_each(|k| inbox.push(letter(k)));
        assert_eq!(rejected.load(Ordering::Relaxed), 3);

        let mut arrivals = Vec::new();
        mailbox.drain(|letter| arrivals.push(letter.arrival.as_nanos()));
        assert_eq!(arrivals, [0, 1, 2, 3]);
    }

    #[test]
    fn draining_ends_although_letters_keep_coming() {
        let (mut inbox, mut mailbox) = mailbox(4, Arc::default());
        (0..3).for_each(|k| inbox.push(letter(k)));
        let mut drained = 0;
        mailbox.drain(|letter| {
            drained += 1;
            inbox.push(letter);
        });
        assert_eq!(drained, 3);
    }
}
