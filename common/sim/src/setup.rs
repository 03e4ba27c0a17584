//! Set-up of the simulation.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::{ClockConfig, CommonTimeConfig, LinkConfig};
use coaxle_node::{Channel, Reader};

/// Builds a node whose first cycle is due at a local instant, in its n-th run.
pub type Factory<N> = Box<dyn Fn(Instant<Local>, u64) -> N>;

/// A node to put into the world.
pub struct NodeSetup<N> {
    /// Name, for messages.
    pub name: String,
    /// Seed of all its randomness, like in the real world.
    pub seed: u64,
    /// Clock of the node.
    pub clock: ClockConfig,
    /// Time that it has in common with other nodes.
    pub common_time: Option<CommonTimeConfig>,
    /// True if its frames of axes carry their departure.
    pub send_stamps: bool,
    /// Builds the node, at the start and after each restart.
    pub build: Factory<N>,
}

/// A link to put into the world: one subscription.
pub struct LinkSetup {
    /// Number of the node that publishes.
    pub from: usize,
    /// Channel of the publication.
    pub channel: Channel,
    /// Number of the far node that the publisher sends to; 0 for its own channels.
    pub far: usize,
    /// Key of the messages.
    pub key: String,
    /// Number of the node that subscribes.
    pub to: usize,
    /// Number of its subscription.
    pub subscription: usize,
    /// Reader of the subscriber.
    pub reader: Reader,
    /// Behaviours of the link, in series, and the seed of each.
    pub behaviour: Vec<(LinkConfig, u64)>,
}

/// A router to put into the world.
#[derive(Clone, Debug)]
pub struct RouterSetup {
    /// Name, for reports.
    pub name: String,
    /// Time to forward a message; messages are forwarded one after the other.
    pub forwarding: Span,
    /// Time of a byte on each of its links, ns.
    pub ns_per_byte: f64,
    /// Longest wait for forwarding or for a link; messages that would wait longer are dropped.
    pub longest_queue: Span,
}
