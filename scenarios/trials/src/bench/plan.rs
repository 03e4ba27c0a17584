//! Plans of the processes of a measurement, and their reports. Both travel as JSON.

use std::net::SocketAddr;

use coaxle_node::config::{RealTimeConfig, TransportConfig};
use serde::{Deserialize, Serialize};

/// Line with which a process reports that it can send, or receive.
// On standard output, before the report: the parent reads a single line and then waits.
pub(super) const READY: &str = "ready";

/// The command, not shown in the help, that makes this program one of them.
pub const PEER: &str = "bench-peer";

/// Part of a process until it is ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum PeerPlan {
    /// Sends datagrams, one a cycle.
    UdpSender { to: SocketAddr, pace: LoopPace },
    /// Receives these datagrams.
    UdpReceiver {
        at: SocketAddr,
        looks: Option<LoopPace>,
    },
    /// Publishes in a Zenoh session like that of a node, one message a cycle, and nothing else.
    ZenohSender {
        transport: TransportConfig,
        pace: LoopPace,
    },
    /// Subscribes to these messages.
    ZenohReceiver {
        transport: TransportConfig,
        real_time: RealTimeConfig,
        looks: Option<LoopPace>,
    },
    /// Runs a sender with this config.
    Sender { config: String, stamps: bool },
    /// Runs such a sender without a network.
    SenderAlone { config: String },
    /// Runs a receiver with this config.
    Receiver { config: String },
}

/// Cycle and message of a bare loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LoopPace {
    pub(super) cycle_ns: i64,
    /// Length of a message.
    pub(super) bytes: usize,
    pub(super) real_time: RealTimeConfig,
}

/// Report of a process. All instants are ns of the machine's clock, which all processes read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct PeerReport {
    /// Cycles of a sender that is a node.
    pub(super) cycles: Vec<CycleStamps>,
    /// Frames received by a receiver that is a node.
    pub(super) frames: Vec<FrameArrival>,
    /// Bare messages received.
    pub(super) messages: Vec<MessageArrival>,
    /// Samples of the newest message's age.
    pub(super) looks: Vec<AgeSample>,
    /// Axes that a receiver followed in its last cycle.
    pub(super) followed: usize,
    /// Requests for real time that the system did not grant.
    pub(super) denied: Vec<String>,
}

/// A cycle of a sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct CycleStamps {
    pub(super) count: u64,
    /// Ideal start.
    pub(super) ideal: i64,
    /// Actual start.
    pub(super) woke: i64,
    /// Hand-over of its frame to the publisher.
    pub(super) handed_over: i64,
}

/// A frame at a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FrameArrival {
    /// The sender's cycle.
    pub(super) count: u64,
    /// Departure after the ideal start of that cycle, by its send stamp.
    pub(super) left_after: i64,
    pub(super) arrived: i64,
    /// Start of the scan that took it in.
    pub(super) used: i64,
}

/// A message of a bare loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct MessageArrival {
    pub(super) count: u64,
    /// Wake-up of its loop.
    pub(super) woke: i64,
    /// Hand-over to the network.
    pub(super) left: i64,
    pub(super) arrived: i64,
}

/// A sample of the newest message's age.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct AgeSample {
    pub(super) at: i64,
    /// Age: time since the wake-up of the loop that sent it.
    pub(super) age: i64,
}

impl MessageArrival {
    /// Least length of a message, bytes.
    pub(super) const BYTES: usize = 3 * 8;

    /// Writes the fields of a message into its beginning.
    pub(super) fn write(count: u64, woke: i64, left: i64, message: &mut [u8]) {
        // The cast keeps the bits of an i64; reading casts them back.
        let words = [count, woke as u64, left as u64];
        for (place, word) in message.chunks_exact_mut(8).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    /// Reads the fields of a message; none if it is too short.
    pub(super) fn read(arrived: i64, message: &[u8]) -> Option<Self> {
        let (words, _) = message.as_chunks::<8>();
        // The rest of a message only fills it to the length of a frame.
        let [count, woke, left, ..] = words else {
            return None;
        };
        Some(Self {
            count: u64::from_le_bytes(*count),
            woke: i64::from_le_bytes(*woke),
            left: i64::from_le_bytes(*left),
            arrived,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_says_what_was_written_into_it() {
        let mut message = [0; MessageArrival::BYTES + 3];
        MessageArrival::write(7, -8, 9, &mut message);
        let came = MessageArrival::read(10, &message).unwrap();
        assert_eq!(
            (came.count, came.woke, came.left, came.arrived),
            (7, -8, 9, 10)
        );
        assert_eq!(MessageArrival::read(10, &message[..23]), None);
    }

    #[test]
    fn plans_and_what_is_told_travel_as_json() {
        let plan = PeerPlan::ZenohReceiver {
            transport: TransportConfig::default(),
            real_time: RealTimeConfig::default(),
            looks: None,
        };
        let json = serde_json::to_string(&plan).unwrap();
        assert_eq!(serde_json::from_str::<PeerPlan>(&json).unwrap(), plan);
        assert_eq!(
            serde_json::from_str::<PeerReport>("{}").unwrap(),
            PeerReport::default()
        );
    }
}
