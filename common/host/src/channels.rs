//! What a node publishes and what it hears.

use coaxle_node::config::LinkConfig;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, Reader};

/// A channel that a node publishes.
pub struct Publication {
    /// Whose channel: its own, but for questions, which go to the node that is asked.
    pub node: NodeName,
    /// The channel.
    pub channel: Channel,
    /// Faults laid over the link.
    pub faults: LinkConfig,
}

impl Publication {
    /// A channel without faults.
    #[must_use]
    pub fn new(node: &NodeName, channel: Channel) -> Self {
        Self {
            node: node.clone(),
            channel,
            faults: LinkConfig::default(),
        }
    }
}

/// A channel that a node hears.
pub struct Subscription {
    /// Whose channel.
    pub node: NodeName,
    /// The channel.
    pub channel: Channel,
    /// Turns its frames into messages.
    pub reader: Reader,
    /// Faults laid over the link.
    pub faults: LinkConfig,
}

impl Subscription {
    /// What `node` is asked by others.
    #[must_use]
    pub fn questions_to(node: &NodeName) -> Self {
        Self {
            node: node.clone(),
            channel: Channel::Questions,
            reader: Reader::questions_to(node),
            faults: LinkConfig::default(),
        }
    }
}
