//! What is put into the simulation.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::{ClockConfig, LinkConfig};
use coaxle_node::{Channel, Reader};

/// Builds a node whose first cycle is due at a local instant, in its n-th run.
pub type Factory<N> = Box<dyn Fn(Instant<Local>, u64) -> N>;

/// A node to put into the world.
pub struct NodeSetup<N> {
    /// Its name, for messages.
    pub name: String,
    /// Seed of everything random in it, as the real world would have it.
    pub seed: u64,
    /// Its clock.
    pub clock: ClockConfig,
    /// Whether its frames of axes say when they left.
    pub send_stamps: bool,
    /// Makes the node, at the start and after each restart.
    pub build: Factory<N>,
}

/// A link to put into the world: one subscription.
pub struct LinkSetup {
    /// Number of the node that publishes.
    pub from: usize,
    /// What it publishes.
    pub channel: Channel,
    /// Which of the nodes that the publisher follows it goes to; 0 for its own channels.
    pub far: usize,
    /// The key that travels under.
    pub key: String,
    /// Number of the node that subscribes.
    pub to: usize,
    /// Which of its subscriptions this is.
    pub subscription: usize,
    /// What the subscriber makes of it.
    pub reader: Reader,
    /// What the link does to messages, one behaviour after the other, and the seed of each.
    pub behaviour: Vec<(LinkConfig, u64)>,
}

/// A router to put into the world.
#[derive(Clone, Debug)]
pub struct RouterSetup {
    /// Its name, for what is told of it.
    pub name: String,
    /// How long it takes for each message that it sends on, one after the other.
    pub forwarding: Span,
    /// How long a byte takes over each of its links, ns.
    pub ns_per_byte: f64,
    /// What would wait for longer than this, to be sent on or to go over a link, is dropped.
    pub longest_queue: Span,
}
