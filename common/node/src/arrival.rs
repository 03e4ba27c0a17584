//! Raw arrivals: what a node learned of the clock it follows, as it came.
//!
//! Recorded, they let somebody run another estimator, or the same one with other parameters, over
//! what really arrived. [`ArrivalRow`] and [`ExchangeRow`] are the lines of such a recording.

use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{Instant, Local};
use serde::{Deserialize, Serialize};

use crate::frame::FrameHeader;

/// One thing that a node took in during a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Of which of the nodes that it hears, counted from 0: those that it follows, then their standbys.
    pub far: usize,
    /// When it arrived, in the node's own clock.
    pub at: Instant<Local>,
    /// What it was.
    pub what: Arrived,
}

/// What a node took in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrived {
    /// A frame of followed axes.
    Message(FrameHeader),
    /// The response to a time request of this run of the node.
    Exchange(TimeResponse),
}

/// A line of the file of messages. Messages that came twice or were too old to use are not in it.
///
/// All fields but `at_ns` are in the clock of the node that received, or of the one that sent: the
/// two drift apart, and where they were zero has nothing in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArrivalRow {
    /// Ideal start of the cycle that took the message in, ns of the world's reference clock, as in
    /// the trace: true time in the simulation, the machine's monotonic clock in the real one.
    pub at_ns: i64,
    /// Number of that cycle, as in the trace.
    pub cycle: u64,
    /// Its ideal start, ns of the receiving node's clock: estimators were asked for this instant
    /// once they had all messages of the cycle.
    pub cycle_start_ns: i64,
    /// The sender's run.
    pub epoch: u64,
    /// The sender's cycle count.
    pub count: u64,
    /// The sender's nominal cycle time, ns.
    pub cycle_time_ns: i64,
    /// Arrival, ns of the receiving node's clock.
    pub arrival_ns: i64,
    /// How long after the ideal start of its cycle the message left, ns of the sender's clock; none
    /// from senders that do not say.
    pub send_stamp_ns: Option<i64>,
    /// Of which of the nodes in the receiver's config, counted from 1: the far nodes, then their standbys.
    #[serde(default = "first")]
    pub far: u16,
}

/// A line of the file of time exchanges: the four stamps of a request and its response, whatever
/// the estimator thought of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExchangeRow {
    /// Ideal start of the cycle that took the response in; as in [`ArrivalRow`].
    pub at_ns: i64,
    /// Number of that cycle.
    pub cycle: u64,
    /// Its ideal start, ns of the requesting node's clock.
    pub cycle_start_ns: i64,
    /// The run of the node that responded.
    pub epoch: u64,
    /// Which request of this run.
    pub number: u32,
    /// The request left, ns of the requesting node's clock.
    pub t1_ns: i64,
    /// The request arrived, ns of the responding node's clock since the ideal start of its cycle 0.
    pub t2_ns: i64,
    /// The response left, likewise.
    pub t3_ns: i64,
    /// The response arrived, ns of the requesting node's clock.
    pub t4_ns: i64,
    /// Of which of the nodes in the receiver's config, counted from 1: the far nodes, then their standbys.
    #[serde(default = "first")]
    pub far: u16,
}

/// Files of receivers that followed one node do not say which.
const fn first() -> u16 {
    1
}

impl ArrivalRow {
    /// The line of a message that the cycle `tick` took in, which the world dates `at_ns`; `far`
    /// is the number of the node it came from, counted from 0.
    #[must_use]
    pub const fn new(
        at_ns: i64,
        tick: &Tick,
        arrived: Instant<Local>,
        header: &FrameHeader,
        far: usize,
    ) -> Self {
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
            far: far as u16 + 1,
        }
    }
}

impl ExchangeRow {
    /// The line of a response that the cycle `tick` took in, which the world dates `at_ns`; `far`
    /// is the number of the node it came from, counted from 0.
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
