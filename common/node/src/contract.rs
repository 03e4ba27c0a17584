//! The contract between a node and the world that drives it.
//!
//! One invariant: between two scans a node only stores. So the canonical loop is
//!
//! ```text
//! loop {
//!     wait until node.next_cycle()             (the world's clock, absolute)
//!     node.receive(at, message)                (for each message that came, stamped on arrival)
//!     node.execute(order)                      (for each order that came: the scan begins)
//!     node.cycle(now)                          (one scan; decides everything)
//!     while let Some(outgoing) = node.transmit() { hand it to the publisher }
//!     while let Some(arrival) = node.arrival() { hand it to telemetry }
//!     hand node.snapshot() to telemetry
//! }
//! ```
//!
//! and nothing in it allocates, locks, logs or waits.

use coaxle_clock::cycle::Turn;
use coaxle_clock::delay::Answer;
use coaxle_clock::{Instant, Local};

use crate::arrival::Arrival;
use crate::command::{CommandOrder, CommandOutcome, NotTaken};
use crate::exchange::Question;
use crate::frame::Sample;
use crate::intake::Rejection;

/// A node: one PLC scan per cycle of its own clock, no I/O.
pub trait Node {
    /// What the node shows of itself after each cycle: plain data.
    type Snapshot: Copy + Send + 'static;

    /// Stores a message. `at` is when it arrived, in this node's own clock; arrivals may lie after
    /// the start of the cycle that is due and then belong to the next one.
    fn receive(&mut self, at: Instant<Local>, message: &Message);

    /// Tells one of its slaves something, at the beginning of a scan: the [`Self::cycle`] that
    /// follows is the first to see it. Only nodes with slaves take orders.
    fn execute(&mut self, order: &CommandOrder) -> CommandOutcome {
        let _ = order;
        CommandOutcome::NotTaken(NotTaken::NoSlaves)
    }

    /// One scan. `now` is when it really begins; the answer says which cycle that was and when it
    /// ideally should have begun.
    fn cycle(&mut self, now: Instant<Local>) -> Turn;

    /// The next thing to send after a cycle, until there is nothing left.
    fn transmit(&mut self) -> Option<Outgoing<'_>>;

    /// What the last cycle took in of the followed clock, one after the other in the order in which
    /// it was used, until there is nothing left. For recordings: nobody needs to fetch it.
    fn arrival(&mut self) -> Option<Arrival> {
        None
    }

    /// When the next cycle is due.
    fn next_cycle(&self) -> Instant<Local>;

    /// What the node shows of itself.
    fn snapshot(&self) -> Self::Snapshot;
}

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

/// What a node's frames are about; each kind has a key of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `coaxle/<node>/axes`: a sender's own axes.
    Axes,
    /// `coaxle/<node>/slaves`: a receiver's slave axes.
    Slaves,
    /// `coaxle/<node>/questions`: what others ask the node, published by them.
    Questions,
    /// `coaxle/<node>/answers`: what the node answers.
    Answers,
}

impl Channel {
    /// Every channel.
    pub const ALL: [Self; 4] = [Self::Axes, Self::Slaves, Self::Questions, Self::Answers];

    /// The last part of its key.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axes => "axes",
            Self::Slaves => "slaves",
            Self::Questions => "questions",
            Self::Answers => "answers",
        }
    }

    /// Whether its frames hold axes and come once per cycle. The others are stamped whenever they
    /// leave, whatever is configured: they are of no use without.
    #[must_use]
    pub const fn carries_axes(self) -> bool {
        matches!(self, Self::Axes | Self::Slaves)
    }
}
