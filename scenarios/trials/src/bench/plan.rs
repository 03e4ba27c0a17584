//! What a process of the measurement is to do, and what it tells at its end. Both travel as JSON.

use std::net::SocketAddr;

use coaxle_node::config::{RealTimeConfig, TransportConfig};
use serde::{Deserialize, Serialize};

/// The line that says that messages can be sent, or received, from now on.
pub(super) const READY: &str = "ready";

/// The command, not shown in the help, that makes this program one of them.
pub const PEER: &str = "bench-peer";

/// What a process does until it is asked to end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Plan {
    /// Sends datagrams, one a cycle.
    UdpSender { to: SocketAddr, pace: Pace },
    /// Receives them.
    UdpReceiver { at: SocketAddr, looks: Option<Pace> },
    /// Publishes in a Zenoh session like that of a node, one message a cycle, and nothing else.
    ZenohSender {
        transport: TransportConfig,
        pace: Pace,
    },
    /// Subscribes to that.
    ZenohReceiver {
        transport: TransportConfig,
        real_time: RealTimeConfig,
        looks: Option<Pace>,
    },
    /// Is a sender with this config.
    Sender { config: String, stamps: bool },
    /// The same without a network.
    SenderAlone { config: String },
    /// Is a receiver with this config.
    Receiver { config: String },
}

/// How a bare loop goes round.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Pace {
    pub(super) cycle_ns: i64,
    /// Length of a message.
    pub(super) bytes: usize,
    pub(super) real_time: RealTimeConfig,
}

/// What it tells. All instants are ns of the machine's clock, which all processes read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct Told {
    /// Cycles of a sender that is a node.
    pub(super) cycles: Vec<Cycle>,
    /// Frames that came to a receiver that is a node.
    pub(super) frames: Vec<FrameCame>,
    /// Bare messages that came.
    pub(super) messages: Vec<MessageCame>,
    /// How old the newest was whenever somebody looked.
    pub(super) looks: Vec<Look>,
    /// Axes that a receiver followed in its last cycle.
    pub(super) followed: usize,
    /// What the system did not grant.
    pub(super) denied: Vec<String>,
}

/// A cycle of a sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Cycle {
    pub(super) count: u64,
    /// When it should have begun.
    pub(super) ideal: i64,
    /// When it did.
    pub(super) woke: i64,
    /// When its frame was on the way to the publisher.
    pub(super) handed_over: i64,
}

/// A frame at a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct FrameCame {
    /// The sender's cycle.
    pub(super) count: u64,
    /// How long after the ideal start of that it left, as it says.
    pub(super) left_after: i64,
    pub(super) arrived: i64,
    /// When the scan began that took it in.
    pub(super) used: i64,
}

/// A message of a bare loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct MessageCame {
    pub(super) count: u64,
    /// When its loop woke.
    pub(super) woke: i64,
    /// When it was handed to the network.
    pub(super) left: i64,
    pub(super) arrived: i64,
}

/// Somebody looked at the newest message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Look {
    pub(super) at: i64,
    /// How long ago the loop woke that sent it.
    pub(super) age: i64,
}

impl MessageCame {
    /// Bytes that a message has at least.
    pub(super) const BYTES: usize = 3 * 8;

    /// Writes what a message says into its beginning.
    pub(super) fn write(count: u64, woke: i64, left: i64, message: &mut [u8]) {
        let words = [count, woke as u64, left as u64];
        for (place, word) in message.chunks_exact_mut(8).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    /// Reads it again; none if it is too short.
    pub(super) fn read(arrived: i64, message: &[u8]) -> Option<Self> {
        let (words, _) = message.as_chunks::<8>();
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
        let mut message = [0; MessageCame::BYTES + 3];
        MessageCame::write(7, -8, 9, &mut message);
        let came = MessageCame::read(10, &message).unwrap();
        assert_eq!(
            (came.count, came.woke, came.left, came.arrived),
            (7, -8, 9, 10)
        );
        assert_eq!(MessageCame::read(10, &message[..23]), None);
    }

    #[test]
    fn plans_and_what_is_told_travel_as_json() {
        let plan = Plan::ZenohReceiver {
            transport: TransportConfig::default(),
            real_time: RealTimeConfig::default(),
            looks: None,
        };
        let json = serde_json::to_string(&plan).unwrap();
        assert_eq!(serde_json::from_str::<Plan>(&json).unwrap(), plan);
        assert_eq!(serde_json::from_str::<Told>("{}").unwrap(), Told::default());
    }
}
