//! The contract between a node and the world that drives it.
//!
//! One invariant: between two scans a node only stores. So the canonical loop is
//!
//! ```text
//! loop {
//!     wait until node.next_cycle()             (the world's clock, absolute)
//!     node.receive(at, subscription, message)  (for each message that came, stamped on arrival)
//!     node.execute_with(order, cargo)          (for each order that came, with its cargo: the scan begins)
//!     node.cycle(now)                          (one scan; decides everything)
//!     while let Some(outgoing) = node.transmit() { hand it to the publisher }
//!     while let Some(arrival) = node.arrival() { hand it to telemetry }
//!     copy node.snapshot() into a record of telemetry's
//! }
//! ```
//!
//! and nothing in it allocates, locks, logs or waits.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local};

use coaxle_wire::command::{CommandOrder, CommandOutcome, OrderCargo};
pub use coaxle_wire::{Channel, Message, Outgoing};

use crate::arrival::Arrival;
use crate::circles::CircleChange;

/// A node: one PLC scan per cycle of its own clock, no I/O.
pub trait Node {
    /// What the node shows of itself after each cycle: plain data, of a size that its config gives.
    /// `clone_from` between two of one node does not allocate.
    type Snapshot: Clone + Send + 'static;

    /// Stores a message of the subscription with this number. `at` is when it arrived, in this node's own clock; arrivals may lie after
    /// the start of the cycle that is due and then belong to the next one.
    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>);

    /// Tells one of its slaves something, or the node about one that it follows, at the beginning of a
    /// scan: the [`Self::cycle`] that follows is the first to see it. Only nodes with slaves or far
    /// nodes take orders.
    ///
    /// `cargo` is [that of the order](CommandOrder::cargo): what it brings, and takes back to be freed elsewhere.
    fn execute_with(&mut self, order: &CommandOrder, _cargo: &mut OrderCargo) -> CommandOutcome {
        order.for_nobody()
    }

    /// The same where there is time to allocate what the order needs, and to free it.
    fn execute(&mut self, order: &CommandOrder) -> CommandOutcome {
        self.execute_with(order, &mut order.cargo())
    }

    /// One scan. `now` is when it really begins; the answer says which cycle that was and when it
    /// ideally should have begun.
    fn cycle(&mut self, now: Instant<Local>) -> Tick;

    /// Whether anybody subscribes to what it publishes on a channel of its own. Until that is said, somebody
    /// does. What nobody takes need not be encoded.
    fn set_subscribed(&mut self, channel: Channel, is_subscribed: bool) {
        let _ = (channel, is_subscribed);
    }

    /// Reports the circle that one of the axes it publishes is in, over other nodes. Until it is reported there is none.
    fn set_circle(&mut self, change: CircleChange) {
        let _ = change;
    }

    /// The next thing to send after a cycle, until there is nothing left.
    fn transmit(&mut self) -> Option<Outgoing<'_>>;

    /// What the last cycle took in of the followed clock, one after the other in the order in which
    /// it was used, until there is nothing left. For recordings: nobody needs to fetch it.
    fn arrival(&mut self) -> Option<Arrival> {
        None
    }

    /// When the next cycle is due.
    fn next_cycle(&self) -> Instant<Local>;

    /// When the cycle that begins at `now` should ideally have begun: [`Self::cycle`] says the same. That
    /// is the next one that is due, but for a node that skips those it is too late for.
    fn ideal_start(&self, _now: Instant<Local>) -> Instant<Local> {
        self.next_cycle()
    }

    /// What the node shows of itself.
    fn snapshot(&self) -> &Self::Snapshot;

    /// Bytes of memory that takes, with what it has on the heap.
    fn snapshot_size(&self) -> usize {
        size_of::<Self::Snapshot>()
    }
}
