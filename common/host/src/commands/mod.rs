//! The way in for orders to a node's slaves, and the way back for what becomes of them.
//!
//! ```text
//! query ─▶ [Zenoh's thread] ─▶ clerk: decode ─▶ orders ─▶ cycle thread: the node's execute()
//! reply ◀───────────────────── clerk: encode ◀─ outcomes ◀───┘
//! ```
//!
//! The clerk is a thread of its own: it may allocate, and it answers in time whatever the cycle
//! does. Between it and the cycle lie two bounded, wait-free rings; a number ties each outcome to
//! its query.

mod clerk;
mod desk;
#[cfg(test)]
mod tests;

use coaxle_clock::{Instant, Span};
use coaxle_node::command::{CommandOrder, CommandOutcome};
use rtrb::RingBuffer;

pub(crate) use clerk::{Asker, Clerk, Counter, Incoming};
pub(crate) use desk::Desk;

use crate::machine::Machine;

/// Most orders that wait for an outcome; more are refused.
pub(crate) const MAX_WAITING: usize = 16;

/// Within this time an order has its answer, whatever the cycle does.
const ANSWER_WITHIN: Span = Span::from_secs(1);

/// An order that is older is not executed: its asker is told at that time, or a moment later, that
/// it will not be.
const EXECUTE_WITHIN: Span = Span::from_millis(900);

/// An order on its way to the cycle.
#[derive(Clone, Copy, Debug)]
struct Ticket {
    number: u64,
    arrival: Instant<Machine>,
    order: CommandOrder,
}

/// An outcome on its way back.
#[derive(Clone, Copy, Debug)]
struct Done {
    number: u64,
    outcome: CommandOutcome,
}

/// The cycle's end and the clerk's end, and where queries are handed in.
pub(crate) fn commands<A: Asker>() -> (Desk, Clerk<A>, Counter<A>) {
    let (order_in, order_out) = RingBuffer::new(MAX_WAITING);
    let (outcome_in, outcome_out) = RingBuffer::new(MAX_WAITING);
    let (counter, incoming) = clerk::counter();
    let desk = Desk::new(order_out, outcome_in);
    (desk, Clerk::new(incoming, order_in, outcome_out), counter)
}
