//! The path of orders to a node's slaves, and of their results back.
//!
//! ```text
//! request ─▶ [transport's thread] ─▶ server: decode ─▶ orders ─▶ cycle thread: the node's execute()
//! reply ◀─────────────────────────── server: encode ◀─ outcomes ◀───┘
//! ```
//!
//! The command server has a thread of its own: it may allocate, and it responds in time even if the
//! cycle hangs. Two bounded, wait-free rings connect it to the cycle; a number matches each outcome
//! to its request.

mod journal;
mod queue;
mod server;
#[cfg(test)]
mod tests;

use coaxle_node::keys::NodeName;
use rtrb::RingBuffer;

use crate::node::audit::Audit;

pub(crate) use journal::ambiguous;
pub(crate) use queue::OrderQueue;
pub(crate) use server::{CommandServer, RequestSender, answer};

/// Greatest number of orders waiting for an outcome; further ones are rejected as busy.
const MAX_WAITING: usize = 16;

/// The cycle's end and the server's end of a node, and the sender that accepts requests.
pub(crate) fn commands(
    node: &NodeName,
    audit: &Audit,
) -> (OrderQueue, CommandServer, RequestSender) {
    let (order_in, order_out) = RingBuffer::new(MAX_WAITING);
    // As many places as for orders, so that executed orders find one.
    let (outcome_in, outcome_out) = RingBuffer::new(MAX_WAITING);
    let (sender, requests) = server::requests(MAX_WAITING, audit);
    let queue = OrderQueue::new(order_out, outcome_in);
    (
        queue,
        CommandServer::new(node.clone(), requests, order_in, outcome_out, audit.clone()),
        sender,
    )
}
