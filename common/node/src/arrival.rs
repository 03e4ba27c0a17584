//! Raw arrivals: measurements of the followed clock, as they arrived.
//!
//! From a recording, another estimator, or the same one with other parameters, can be run over the
//! actual arrivals. [`ArrivalRow`] and [`ExchangeRow`] are the lines of such a recording.

use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{Instant, Local};
use serde::{Deserialize, Serialize};

use crate::frame::FrameHeader;

/// A message that a node took in during a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Number of the source among the nodes received, counted from 0: the followed nodes, then
    /// their standbys.
    pub far: usize,
    /// Arrival, in the node's own clock.
    pub at: Instant<Local>,
    /// Contents of the message.
    pub what: Arrived,
}

/// Contents of a message taken in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrived {
    /// A frame of followed axes.
    Message(FrameHeader),
    /// The response to a time request of this run of the node.
    Exchange(TimeResponse),
}

/// A line of the file of messages. Duplicates and messages too old to use are not in it.
///
/// All fields but `at_ns` are in the clock of the receiving or of the sending node: the two drift
/// apart, and their zeros are unrelated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArrivalRow {
    /// Ideal start of the cycle that took the message in, ns of the world's reference clock, as in
    /// the trace: true time in the simulation, the machine's monotonic clock in the real one.
    pub at_ns: i64,
    /// Number of that cycle, as in the trace.
    pub cycle: u64,
    /// Ideal start of that cycle, ns of the receiving node's clock: estimators were evaluated at
    /// this instant once they had all messages of the cycle.
    pub cycle_start_ns: i64,
    /// The sender's run.
    pub epoch: u64,
    /// The sender's cycle count.
    pub count: u64,
    /// The sender's nominal cycle time, ns.
    pub cycle_time_ns: i64,
    /// Arrival, ns of the receiving node's clock.
    pub arrival_ns: i64,
    /// Send delay after the ideal start of the message's cycle, ns of the sender's clock; none from
    /// senders without send stamps.
    pub send_stamp_ns: Option<i64>,
    /// Number of the source in the receiver's config, counted from 1: the far nodes, then their standbys.
    #[serde(default = "first")]
    pub far: u16,
}

/// A line of the file of time exchanges: the four stamps of a request and its response, used by the
/// estimator or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExchangeRow {
    /// Ideal start of the cycle that took the response in; as in [`ArrivalRow`].
    pub at_ns: i64,
    /// Number of that cycle.
    pub cycle: u64,
    /// Ideal start of that cycle, ns of the requesting node's clock.
    pub cycle_start_ns: i64,
    /// The run of the node that responded.
    pub epoch: u64,
    /// Sequence number of the request in this run.
    pub number: u32,
    /// The request left, ns of the requesting node's clock.
    pub t1_ns: i64,
    /// The request arrived, ns of the responding node's clock since the ideal start of its cycle 0.
    pub t2_ns: i64,
    /// The response left, likewise.
    pub t3_ns: i64,
    /// The response arrived, ns of the requesting node's clock.
    pub t4_ns: i64,
    /// Number of the source in the receiver's config, counted from 1: the far nodes, then their standbys.
    #[serde(default = "first")]
    pub far: u16,
}

/// Default for files of receivers that followed one node, which have no such column.
const fn first() -> u16 {
    1
}

impl ArrivalRow {
    /// The line of a message that the cycle `tick` took in, at `at_ns` of the world's clock; `far`
    /// is the number of the source node, counted from 0.
    #[must_use]
    pub const fn new(
        at_ns: i64,
        tick: &Tick,
        arrived: Instant<Local>,
        header: &FrameHeader,
        far: usize,
    ) -> Self {
        // A `match`, since `map` is no const function.
        let send_stamp_ns = match header.send_stamp {
            Some(stamp) => Some(stamp.as_nanos()),
            None => None,
        };
        Self {
            at_ns,
            cycle: tick.count,
            cycle_start_ns: tick.ideal_start.as_nanos(),
            epoch: header.epoch,
            count: header.count,
            cycle_time_ns: header.cycle_time.span().as_nanos(),
            arrival_ns: arrived.as_nanos(),
            send_stamp_ns,
            // From 1, as people count the nodes of a config. A receiver has 128 of them at most.
            far: far as u16 + 1,
        }
    }
}

impl ExchangeRow {
    /// The line of a response that the cycle `tick` took in, at `at_ns` of the world's clock; `far`
    /// is the number of the source node, counted from 0.
    #[must_use]
    pub const fn new(
        at_ns: i64,
        tick: &Tick,
        arrived: Instant<Local>,
        response: &TimeResponse,
        far: usize,
    ) -> Self {
        Self {
            at_ns,
            cycle: tick.count,
            cycle_start_ns: tick.ideal_start.as_nanos(),
            epoch: response.epoch,
            number: response.number,
            t1_ns: response.requested.as_nanos(),
            t2_ns: response.received.as_nanos(),
            t3_ns: response.responded.as_nanos(),
            t4_ns: arrived.as_nanos(),
            far: far as u16 + 1,
        }
    }
}
