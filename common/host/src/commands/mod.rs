//! The way in for orders to a node's slaves, and the way back for what becomes of them.
//!
//! ```text
//! request ─▶ [transport's thread] ─▶ server: decode ─▶ orders ─▶ cycle thread: the node's execute()
//! reply ◀─────────────────────────── server: encode ◀─ outcomes ◀───┘
//! ```
//!
//! The command server has a thread of its own: it may allocate, and it answers in time whatever the
//! cycle does. Between it and the cycle lie two bounded, wait-free rings; a number ties each outcome
//! to its request.

mod journal;
mod queue;
mod server;
#[cfg(test)]
mod tests;

use coaxle_node::keys::NodeName;
use rtrb::RingBuffer;

pub(crate) use queue::OrderQueue;
pub(crate) use server::{CommandServer, RequestSender, answer};

/// Most orders that wait for an outcome; more are refused.
const MAX_WAITING: usize = 16;

/// The cycle's end and the server's end of a node, and where requests are handed in.
pub(crate) fn commands(node: &NodeName) -> (OrderQueue, CommandServer, RequestSender) {
    let (order_in, order_out) = RingBuffer::new(MAX_WAITING);
    let (outcome_in, outcome_out) = RingBuffer::new(MAX_WAITING);
    let (sender, requests) = server::requests(MAX_WAITING);
    let queue = OrderQueue::new(order_out, outcome_in);
    (
        queue,
        CommandServer::new(node.clone(), requests, order_in, outcome_out),
        sender,
    )
}
