//! Messages that come in batches, as where an access point keeps them back until its next beacon.
//!
//! Of a batch only the last message says when it was sent: it came to the access point after the beacon before and waited
//! for no longer than a cycle and the jitter. All others waited for it. So where most messages come in batches, the last one
//! of each is used, once the next batch shows that it was the last. An access point keeps the order: what comes together in
//! another one came by ways of its own, and any of it may be the quickest.

use crate::instant::{Instant, Local, Span};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the batches.
    BatchesTuning {
        /// Least number of messages of a batch.
        fewest: u16 = 5,
        /// Part of the groups of messages from which they come in batches …
        batched: f64 = 0.8,
        /// … and part from which they no longer do.
        // A machine that stood still, or a queue, is a batch among many messages that come alone.
        not_batched: f64 = 0.4,
        /// Groups of messages that the part is taken over; at the beginning, all so far, of which there have to be as many as `least`.
        // A dozen batches in a row are enough there. Of random delays of up to 20 ms on a way that keeps the order, half of the groups are batches by chance:
        // over the last 8 it was more than four fifths each half a minute, and the line was found again twice within 50 ms.
        memory: f64 = 64.0,
        least: f64 = 8.0,
    }
}

/// A message as it came.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Arrival {
    pub(in crate::observer) count: u64,
    pub(in crate::observer) at: Instant<Local>,
    pub(in crate::observer) send_stamp: Option<Span>,
}

/// Picks the messages to use.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::observer) struct Batches {
    /// Number of messages that came together since the last pause, and whether all of them in their order.
    length: u16,
    is_out_of_order: bool,
    /// The largest count so far.
    largest: u64,
    /// Groups of messages so far, as far as they count, and the part of them that were batches.
    groups: f64,
    part: f64,
    /// The newest message, which may be the last of its batch.
    newest: Option<Arrival>,
    batched: bool,
}

/// The use of a message.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) enum Picked {
    /// No message as yet.
    Nothing,
    /// The message to use.
    Message(Arrival),
    /// Change to batches, or back: everything learnt of the messages is of no use.
    Changed,
}

impl Batches {
    /// True if only the last message of each batch is used.
    pub(in crate::observer) const fn are_picked_from(&self) -> bool {
        self.batched
    }

    /// Takes a message, and whether it came together with the one before.
    pub(in crate::observer) fn take(&mut self, arrival: Arrival, together: bool) -> Picked {
        if together {
            self.length = self.length.saturating_add(1);
        } else {
            let is_batch = self.length >= TUNING.fewest && !self.is_out_of_order;
            self.groups = (self.groups + 1.0).min(TUNING.memory);
            let weight = 1.0 / self.groups.max(TUNING.least);
            self.part += (f64::from(u8::from(is_batch)) - self.part) * weight;
            self.length = 1;
            self.is_out_of_order = false;
        }
        // An access point is a queue. Messages that overtake each other came by ways of their own.
        self.is_out_of_order |= arrival.count < self.largest;
        self.largest = self.largest.max(arrival.count);
        // Hysteresis, as every change makes the lines be found again.
        let bound = if self.batched {
            TUNING.not_batched
        } else {
            TUNING.batched
        };
        let batched = self.part > bound;
        if batched != self.batched {
            self.batched = batched;
            self.newest = None;
            return Picked::Changed;
        }
        if !batched {
            return Picked::Message(arrival);
        }
        let before = self.newest.replace(arrival);
        match before {
            // The last of a batch shows only by the first message of the next.
            Some(before) if !together => Picked::Message(before),
            _ => Picked::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_that_stood_still_is_no_batch() {
        let mut batches = Batches::default();
        for count in 0..10_000 {
            let arrival = Arrival {
                count,
                at: Instant::EPOCH,
                send_stamp: None,
            };
            // For 300 ms every half a second.
            let picked = batches.take(arrival, count % 500 < 300);
            assert!(matches!(picked, Picked::Message(_)), "{count}");
        }
    }

    /// Found in a random schedule: one message in forty takes up to 155 ms, each by a way of its own, and what was held up
    /// comes at once.
    #[test]
    fn what_comes_together_in_any_order_is_no_batch() {
        let mut batches = Batches::default();
        for count in 0..10_000_u64 {
            let arrival = Arrival {
                count: count ^ 1,
                at: Instant::EPOCH,
                send_stamp: None,
            };
            let picked = batches.take(arrival, count % 100 != 0);
            assert!(matches!(picked, Picked::Message(_)), "{count}");
        }
    }

    /// The counts that are used of 4000 messages that come in batches of this length.
    fn used(batch: u64) -> std::vec::Vec<u64> {
        let mut batches = Batches::default();
        let mut used = std::vec::Vec::new();
        for count in 0..4_000 {
            let arrival = Arrival {
                count,
                at: Instant::EPOCH,
                send_stamp: None,
            };
            match batches.take(arrival, count % batch != 0) {
                Picked::Message(arrival) => used.push(arrival.count),
                Picked::Nothing => {}
                Picked::Changed => used.clear(),
            }
        }
        used
    }

    #[test]
    fn the_last_of_each_batch_is_used() {
        // A few that come together are a link that was busy for a moment.
        for batch in [1, 3, 4] {
            assert_eq!(used(batch).len(), 4_000, "{batch}");
        }
        for batch in [6, 10, 100] {
            let used = used(batch);
            assert!(used.len() > 10, "{batch}: {}", used.len());
            assert!(
                used.iter().all(|count| count % batch == batch - 1),
                "{used:?}"
            );
        }
    }

    /// Takes a group of messages from `count` on. Returns whether it changed the way to pick.
    fn take_group(batches: &mut Batches, count: &mut u64, length: u64) -> bool {
        let mut changed = false;
        for n in 0..length {
            let arrival = Arrival {
                count: *count,
                at: Instant::EPOCH,
                send_stamp: None,
            };
            changed |= matches!(batches.take(arrival, n > 0), Picked::Changed);
            *count += 1;
        }
        changed
    }

    /// Takes 200 batches of ten messages, then as many groups of which one in `each` is a batch. Returns whether messages are
    /// still picked from batches at last.
    fn are_picked_where_one_is_a_batch_of(each: u32) -> bool {
        let mut batches = Batches::default();
        let mut count = 0;
        for group in 0..400 {
            let length = if group < 200 || group % each == 0 {
                10
            } else {
                1
            };
            take_group(&mut batches, &mut count, length);
            assert!(batches.are_picked_from() || !(20..200).contains(&group));
        }
        batches.are_picked_from()
    }

    /// Random delays of up to 20 ms on a way that keeps the order: what comes behind the latest comes with it.
    #[test]
    fn groups_that_are_batches_by_chance_change_nothing_once_there_are_many() {
        let mut batches = Batches::default();
        let (mut count, mut random, mut changes) = (0, 7_u32, 0);
        for group in 0..50_000 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let length = if random >> 16 < 36_000 { 8 } else { 3 };
            let changed = take_group(&mut batches, &mut count, length);
            changes += u32::from(group > 200 && changed);
        }
        assert_eq!(changes, 0);
    }

    #[test]
    fn batches_are_left_once_few_groups_are_some() {
        assert!(are_picked_where_one_is_a_batch_of(2));
        assert!(!are_picked_where_one_is_a_batch_of(3));
    }
}
