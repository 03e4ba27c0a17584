//! What comes to a node, and what goes out from it.

use coaxle_clock::delay::Answer;
use coaxle_clock::{Instant, Local};

use crate::channel::Channel;
use crate::exchange::Question;
use crate::frame::Sample;
use crate::rejection::Rejection;

/// What a node is told about its subscriptions. One variant per kind of event, so that the node is
/// the only place that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// An accepted frame, reduced to the axis this node follows.
    Sample(Sample),
    /// Somebody asks what this node's clock shows.
    Question(Question),
    /// The followed node answers a question of this node.
    Answer(Answer),
    /// A frame that was refused before it got here.
    Rejected(Rejection),
}

/// A frame to send, but for its last two fields.
///
/// The send stamp says how long after `ideal_start` the message really left, so whoever sends it
/// appends that (and the check sum) with [`crate::frame::seal`] at the last moment.
#[derive(Clone, Copy, Debug)]
pub struct Outgoing<'a> {
    /// Where it goes.
    pub channel: Channel,
    /// The ideal start of the cycle it belongs to, in this node's clock.
    pub ideal_start: Instant<Local>,
    /// The frame up to its send stamp.
    pub body: &'a [u8],
}
