//! Counts of all messages.

use std::cell::Cell;

/// The messages of all links since the start. `sent + added` is the sum of all others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Sent, one for each link that takes it.
    pub sent: u64,
    /// Added on the way: duplicates, forgeries, or several in one.
    pub added: u64,
    /// Lost on the way, replaced by others, or without a recipient.
    pub lost: u64,
    /// Delivered to a node.
    pub delivered: u64,
    /// Arrived at a dead node, or beyond the room for waiting messages.
    pub dropped: u64,
    /// Waiting for a node that is frozen.
    pub waiting: u64,
    /// Under way.
    pub under_way: u64,
}

/// Counts of one link.
#[derive(Debug, Default)]
pub(crate) struct LinkCounts {
    // Cells, because nested closures count while each of them holds the counts.
    sent: Cell<u64>,
    added: Cell<u64>,
    lost: Cell<u64>,
}

impl LinkCounts {
    pub(crate) fn send(&self) {
        self.sent.update(|count| count + 1);
    }

    /// Notes that one message has become this number.
    pub(crate) fn became(&self, messages: u64) {
        // Without any it is lost, one is unchanged, n are n - 1 added: so `sent + added` stays the sum of all
        // others.
        match messages.checked_sub(1) {
            None => self.lost.update(|count| count + 1),
            Some(more) => self.added.update(|count| count + more),
        }
    }

    pub(crate) fn add_to(&self, traffic: &mut Traffic) {
        traffic.sent += self.sent.get();
        traffic.added += self.added.get();
        traffic.lost += self.lost.get();
    }
}
