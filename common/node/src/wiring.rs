//! Publications and subscriptions of the nodes, computed once from configs, for both worlds.
//!
//! Each node's config determines its [`Wiring`]: the channels it publishes and those it subscribes
//! to, in an order that the node relies on ([`Node::receive`](crate::Node::receive) takes the
//! number of the subscription). Where all nodes are known, [`links`] returns every link from one of
//! them to another.

use coaxle_wire::keys::NodeName;
use coaxle_wire::{BeaconIntake, Channel, Reader};

use crate::config::LinkConfig;
use crate::faults::{link_seed, seed_of};

/// Publications and subscriptions of one node.
#[derive(Clone, Debug)]
pub struct Wiring {
    /// The node.
    pub node: NodeName,
    /// Channels that it publishes.
    pub publications: Vec<Publication>,
    /// Channels that it subscribes to.
    pub subscriptions: Vec<Subscription>,
}

/// A channel that a node publishes.
#[derive(Clone, Debug)]
pub struct Publication {
    /// Owner of the channel: the node itself, or for time requests the requested node.
    pub node: NodeName,
    /// The channel.
    pub channel: Channel,
    /// Faults applied to the link.
    pub faults: LinkConfig,
    /// Number of the far node among those received, counted from 0: the followed nodes, then their
    /// standbys.
    pub far: usize,
}

/// A channel that a node subscribes to.
#[derive(Clone, Debug)]
pub struct Subscription {
    /// Owner of the channel.
    pub node: NodeName,
    /// The channel.
    pub channel: Channel,
    /// Reader that turns its frames into messages.
    pub reader: Reader,
    /// Faults applied to the link.
    pub faults: LinkConfig,
    /// Number of the far node among those received, counted from 0: the followed nodes, then their
    /// standbys.
    pub far: usize,
}

/// A link from a publication of one node to a subscription of another, all by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WiringLink {
    /// The node that publishes.
    pub from: usize,
    /// Number of its publication.
    pub publication: usize,
    /// The node that subscribes.
    pub to: usize,
    /// Number of its subscription.
    pub subscription: usize,
}

impl Publication {
    /// A channel of the node itself, without faults.
    #[must_use]
    pub fn new(node: &NodeName, channel: Channel) -> Self {
        Self {
            node: node.clone(),
            channel,
            faults: LinkConfig::default(),
            far: 0,
        }
    }
}

impl Subscription {
    /// The time requests of others to `node`.
    #[must_use]
    pub fn time_requests_to(node: &NodeName) -> Self {
        Self {
            node: node.clone(),
            channel: Channel::TimeRequests,
            reader: Reader::time_requests_to(node),
            faults: LinkConfig::default(),
            far: 0,
        }
    }
}

impl Wiring {
    /// Adds a timing server, which responds to beacons.
    #[must_use]
    pub fn with_timing_server(mut self) -> Self {
        let node = &self.node;
        let publication = Publication::new(node, Channel::BeaconResponses);
        self.publications.push(publication);
        self.subscriptions.push(Subscription {
            node: node.clone(),
            channel: Channel::BeaconRequests,
            reader: BeaconIntake::requests_to(node).into(),
            faults: LinkConfig::default(),
            far: 0,
        });
        self
    }

    /// Adds a timing link, which sends beacons to `of`, the node with the number `far` among all
    /// that it receives from.
    #[must_use]
    pub fn with_timing_link(mut self, of: &NodeName, far: usize, faults: &LinkConfig) -> Self {
        self.publications.push(Publication {
            faults: faults.clone(),
            far,
            ..Publication::new(of, Channel::BeaconRequests)
        });
        self.subscriptions.push(Subscription {
            node: of.clone(),
            channel: Channel::BeaconResponses,
            reader: BeaconIntake::responses_of(of, &self.node).into(),
            faults: faults.clone(),
            far,
        });
        self
    }
}

/// Every link between these nodes, in the order of the subscribers.
#[must_use]
pub fn links(nodes: &[Wiring]) -> Vec<WiringLink> {
    let mut ways = Vec::new();
    for (to, hearer) in nodes.iter().enumerate() {
        for (subscription, received) in hearer.subscriptions.iter().enumerate() {
            for (from, speaker) in nodes.iter().enumerate() {
                let fits = |publication: &Publication| {
                    publication.node == received.node && publication.channel == received.channel
                };
                // The first that fits: a node publishes a channel once.
                if let Some(publication) = speaker.publications.iter().position(fits) {
                    ways.push(WiringLink {
                        from,
                        publication,
                        to,
                        subscription,
                    });
                }
            }
        }
    }
    ways
}

/// Derives the seed of the faults of the link to the n-th far node on one channel, in the run of
/// the follower with this seed: each has numbers of its own.
#[must_use]
pub fn far_link_seed(run: u64, part: &str, channel: Channel, far: usize) -> u64 {
    let run = match far {
        0 => run,
        far => seed_of(run, &format!("far {far}")),
    };
    link_seed(run, part, channel)
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_wire::Intake;

    fn name(name: &str) -> NodeName {
        NodeName::new(name).unwrap()
    }

    fn sender(node: &str) -> Wiring {
        let node = name(node);
        Wiring {
            publications: [Channel::Axes, Channel::TimeResponses]
                .map(|channel| Publication::new(&node, channel))
                .into(),
            subscriptions: vec![Subscription::time_requests_to(&node)],
            node,
        }
    }

    fn receiver(node: &str, of: &[&str]) -> Wiring {
        let node = name(node);
        let mut wiring = Wiring {
            publications: Vec::new(),
            subscriptions: Vec::new(),
            node: node.clone(),
        };
        for (far, of) in of.iter().enumerate() {
            let of = name(of);
            wiring.publications.push(Publication {
                far,
                ..Publication::new(&of, Channel::TimeRequests)
            });
            let key = of.channel_key(Channel::Axes);
            wiring.subscriptions.push(Subscription {
                reader: Intake::new(&key, &of, &[1]).into(),
                node: of.clone(),
                channel: Channel::Axes,
                faults: LinkConfig::default(),
                far,
            });
            wiring.subscriptions.push(Subscription {
                reader: Reader::time_responses_of(&of, &node),
                node: of,
                channel: Channel::TimeResponses,
                faults: LinkConfig::default(),
                far,
            });
        }
        wiring
    }

    #[test]
    fn who_asks_is_heard_and_answered() {
        let nodes = [
            sender("a"),
            sender("b"),
            receiver("r", &["b"]),
            receiver("s", &["a", "b"]),
        ];
        let ways: Vec<_> = links(&nodes)
            .iter()
            .map(|way| {
                let channel = nodes[way.to].subscriptions[way.subscription].channel;
                let publication = &nodes[way.from].publications[way.publication];
                assert_eq!(publication.channel, channel);
                (way.from, channel.name(), way.to)
            })
            .collect();
        assert_eq!(
            // By receiver, then by its subscription, then by the sender.
            ways,
            [
                (3, "time-requests", 0),
                (2, "time-requests", 1),
                (3, "time-requests", 1),
                (1, "axes", 2),
                (1, "time-responses", 2),
                (0, "axes", 3),
                (0, "time-responses", 3),
                (1, "axes", 3),
                (1, "time-responses", 3),
            ]
        );
    }

    #[test]
    fn every_far_node_has_a_link_of_its_own() {
        let seed = |far| far_link_seed(7, "network", Channel::Axes, far);
        assert_eq!(seed(0), link_seed(7, "network", Channel::Axes));
        assert!(seed(1) != seed(0) && seed(2) != seed(1));
    }
}
