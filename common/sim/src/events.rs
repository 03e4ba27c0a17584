//! The event queue.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use coaxle_clock::Instant;

use crate::true_time::True;

/// Events in the order of true time; those of one instant in insertion order.
#[derive(Debug)]
pub(crate) struct EventQueue<E> {
    heap: BinaryHeap<Reverse<(Instant<True>, u64, usize)>>,
    /// The events themselves, so that the heap moves only small entries.
    slots: Vec<Option<E>>,
    free: Vec<usize>,
    added: u64,
}

impl<E> EventQueue<E> {
    pub(crate) const fn new() -> Self {
        Self {
            heap: BinaryHeap::new(),
            slots: Vec::new(),
            free: Vec::new(),
            added: 0,
        }
    }

    pub(crate) fn add(&mut self, at: Instant<True>, event: E) {
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                self.slots.push(None);
                self.slots.len() - 1
            }
        };
        self.slots[slot] = Some(event);
        // The running number decides between equal instants: the order of a heap's equals is not defined, and the
        // same seed must give the same bytes.
        self.heap.push(Reverse((at, self.added, slot)));
        self.added += 1;
    }

    pub(crate) fn len(&self) -> usize {
        self.heap.len()
    }

    /// Events in arbitrary order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &E> {
        self.slots.iter().flatten()
    }

    pub(crate) fn next_at(&self) -> Option<Instant<True>> {
        self.heap.peek().map(|Reverse((at, _, _))| *at)
    }

    pub(crate) fn pop(&mut self) -> Option<(Instant<True>, E)> {
        let Reverse((at, _, slot)) = self.heap.pop()?;
        self.free.push(slot);
        self.slots[slot].take().map(|event| (at, event))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn events_come_by_time_then_by_order() {
        let mut queue = EventQueue::new();
        for (at, event) in [(5, 'c'), (1, 'a'), (5, 'd'), (2, 'b')] {
            queue.add(Instant::from_nanos(at), event);
        }
        let order: String = std::iter::from_fn(|| queue.pop()).map(|(_, e)| e).collect();
        assert_eq!(order, "abcd");
        assert_eq!(queue.next_at(), None);
    }

    proptest! {
        /// Comparison with a list that is sorted for each event; none: the next event is taken.
        #[test]
        fn it_does_what_a_sorted_list_would(
            what in prop::collection::vec(prop::option::weighted(0.6, 0..8i64), 0..200),
        ) {
            let mut queue = EventQueue::new();
            let mut list: Vec<(Instant<True>, usize)> = Vec::new();
            for (event, at) in what.into_iter().enumerate() {
                match at.map(Instant::from_nanos) {
                    Some(at) => {
                        queue.add(at, event);
                        list.push((at, event));
                        list.sort();
                    }
                    None => {
                        let next = (!list.is_empty()).then(|| list.remove(0));
                        prop_assert_eq!(queue.pop(), next);
                    }
                }
                prop_assert_eq!(queue.next_at(), list.first().map(|(at, _)| *at));
            }
            // Every slot is free again.
            let most = queue.slots.len();
            while queue.pop().is_some() {}
            prop_assert_eq!(queue.free.len(), most);
        }
    }
}
