//! The contract between a node and the world that drives it.
//!
//! One invariant: between two scans a node only stores. The canonical loop is
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
//! and no step of it allocates, locks, logs or waits.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local};

use coaxle_wire::command::{CommandOrder, CommandOutcome, OrderCargo};
pub use coaxle_wire::{Channel, Message, Outgoing};

use crate::arrival::Arrival;
use crate::circles::CircleChange;

/// A node: one PLC scan per cycle of its own clock, no I/O.
pub trait Node {
    /// Data that the node shows after each cycle: plain data, of a size given by its config.
    /// `clone_from` between two of one node does not allocate.
    type Snapshot: Clone + Send + 'static;

    /// Stores a message of the subscription with this number. `at` is its arrival in this node's
    /// own clock; arrivals may lie after the start of the cycle that is due and then belong to the
    /// next one.
    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>);

    /// Executes a command for one of its slaves, or for a far node that it follows, at the
    /// beginning of a scan: the [`Self::cycle`] that follows is the first to see it. Only nodes
    /// with slaves or far nodes take orders.
    ///
    /// `cargo` is [that of the order](CommandOrder::cargo): memory that it brings, and takes back
    /// to be freed elsewhere.
    fn execute_with(&mut self, order: &CommandOrder, _cargo: &mut OrderCargo) -> CommandOutcome {
        // A node without slaves answers, too: a client must not wait for its timeout.
        order.without_addressee()
    }

    /// Executes a command where there is time to allocate and free its cargo.
    fn execute(&mut self, order: &CommandOrder) -> CommandOutcome {
        self.execute_with(order, &mut order.cargo())
    }

    /// Runs one scan. `now` is its actual start; the result gives the number of the cycle and its
    /// ideal start.
    fn cycle(&mut self, now: Instant<Local>) -> Tick;

    /// Reports whether a channel of its own has subscribers. Until it is reported there is one.
    /// Data without a subscriber need not be encoded.
    fn set_subscribed(&mut self, channel: Channel, is_subscribed: bool) {
        // A node that encodes everything is right, if slower.
        let _ = (channel, is_subscribed);
    }

    /// Reports the circle across nodes that a published axis is in. Until it is reported there is none.
    fn set_circle(&mut self, change: CircleChange) {
        let _ = change;
    }

    /// The next frame to send after a cycle, until none is left.
    fn transmit(&mut self) -> Option<Outgoing<'_>>;

    /// Measurements of the followed clock taken in by the last cycle, in the order of their use,
    /// until none is left. For recordings; fetching them is optional.
    fn arrival(&mut self) -> Option<Arrival> {
        None
    }

    /// Start of the next cycle.
    fn next_cycle(&self) -> Instant<Local>;

    /// Ideal start of the cycle that begins at `now`, as [`Self::cycle`] returns it. This is the
    /// next cycle due, except in a node that skips cycles it is too late for.
    fn ideal_start(&self, _now: Instant<Local>) -> Instant<Local> {
        self.next_cycle()
    }

    /// Snapshot of the node after the last cycle.
    fn snapshot(&self) -> &Self::Snapshot;

    /// Size of the snapshot, bytes, including its heap memory.
    fn snapshot_size(&self) -> usize {
        size_of::<Self::Snapshot>()
    }
}
