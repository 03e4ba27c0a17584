//! Detection of circles by one node of a running network.
//!
//! A node sees only the nodes that it follows: no frames are forwarded between two peers. So each
//! status forwards the known data of the upstream axes, and a circle of n nodes is found after n
//! statuses, a quarter of a second each.

use std::collections::BTreeMap;

use coaxle_slave::CircleState;
use coaxle_wire::keys::NodeName;
use coaxle_wire::{Channel, CircleChange};
use serde_json::{Map, Value, json};

use super::reading::{Upstream, followers_of, upstream_of, upstream_to_json};
use super::{AxisAddress, Circle, Follower, circles_through};

/// Greatest number of hops: data forwarded more often is stale and circulates in a circle whose
/// axis has changed since. As RIP counts to infinity (RFC 2453, 3.4.2), with more than its 15
/// because a line may have many nodes.
const MOST_HOPS: u32 = 64;
/// The greatest number of axes read from one status, so that none can fill the memory.
const MOST_AXES: usize = 4096;

/// Watch for circles through the axes of one node, by the statuses of the nodes that it follows.
#[derive(Clone, Debug)]
pub struct CircleWatch {
    node: NodeName,
    /// The nodes that it follows, with the known axes of each.
    heard: BTreeMap<NodeName, Option<Vec<Upstream>>>,
}

/// Result of a search for circles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CircleFinding {
    /// The circles that axes of the node are in, closed ones first.
    pub circles: Vec<Circle>,
    /// The state of each axis of the node.
    pub states: Vec<CircleChange>,
    /// Nodes that are followed, directly or through others, and whose axes are not known.
    pub unknown: Vec<NodeName>,
    upstream: Vec<Upstream>,
}

impl CircleWatch {
    /// Creates the watch of a node that follows axes of these receivers, which follow others themselves.
    pub fn new(node: NodeName, follows: impl IntoIterator<Item = NodeName>) -> Self {
        let others = follows.into_iter().filter(|other| *other != node);
        // A node that follows its own axes knows them.
        let heard = others.map(|other| (other, None)).collect();
        Self { node, heard }
    }

    /// The nodes whose statuses it reads.
    pub fn nodes(&self) -> impl Iterator<Item = &NodeName> {
        self.heard.keys()
    }

    /// Takes the status of a node.
    pub fn take(&mut self, node: &NodeName, status: &Map<String, Value>) {
        if let Some(known) = self.heard.get_mut(node) {
            let own = followers_of(node, status).into_iter().take(MOST_AXES);
            // A hop is added by each reader: the node itself is one away.
            let own = own.map(|follower| Upstream { follower, hops: 1 });
            let passed_on = upstream_of(status, MOST_AXES).into_iter();
            let passed_on = passed_on.filter_map(|Upstream { follower, hops }| {
                // The number comes from another node, and may be the greatest.
                let hops = hops.saturating_add(1);
                let is_known_better =
                    // Axes of that node and of this one are known at first hand.
                    follower.axis.node == *node || follower.axis.node == self.node;
                (hops <= MOST_HOPS && !is_known_better).then_some(Upstream { follower, hops })
            });
            *known = Some(own.chain(passed_on).collect());
        }
    }

    /// Forgets a node that is silent.
    pub fn forget(&mut self, node: &NodeName) {
        if let Some(known) = self.heard.get_mut(node) {
            *known = None;
        }
    }

    /// Searches for circles through the axes of this node, as listed in its own status.
    #[must_use]
    pub fn look(&self, own: &Map<String, Value>) -> CircleFinding {
        // From the status and not from the config: only it says what is coupled now.
        let own = followers_of(&self.node, own);
        let upstream = self.before(&own);
        let all = own
            .iter()
            .chain(upstream.iter().map(|before| &before.follower));
        let coupled = |follower: &&Follower| follower.is_coupled;
        let closed: Vec<_> = all.clone().filter(coupled).cloned().collect();
        // Own axes stand first, so that their count bounds the search to circles through them.
        let closed = circles_through(&closed, own.iter().filter(coupled).count());
        let all: Vec<_> = all.cloned().collect();
        let possible = circles_through(&all, own.len());
        let is_in = |circles: &[Circle], axis| circles.iter().any(|of| of.axes().contains(axis));
        let states = own.iter().map(|Follower { axis, .. }| CircleChange {
            channel: axis.channel,
            id: axis.id,
            state: match axis {
                // Closed first: an axis may be in an open circle as well.
                axis if is_in(&closed, axis) => CircleState::Closed,
                axis if is_in(&possible, axis) => CircleState::Open,
                _ => CircleState::None,
            },
        });
        let states = states.collect();
        let unknown = self.unknown(&all);
        let mut circles = closed;
        for circle in possible {
            // A closed circle is found as a possible one as well.
            if !circles.contains(&circle) {
                circles.push(circle);
            }
        }
        CircleFinding {
            circles,
            states,
            unknown,
            upstream,
        }
    }

    /// The axes of other nodes that these follow, directly or indirectly, each by the entry with
    /// the fewest hops.
    fn before(&self, own: &[Follower]) -> Vec<Upstream> {
        let mut known: BTreeMap<_, &Upstream> = BTreeMap::new();
        for entry in self.heard.values().flatten().flatten() {
            let nearest = known.entry(entry.follower.axis.key()).or_insert(entry);
            // The nearest entry is the youngest.
            if entry.hops < nearest.hops {
                *nearest = entry;
            }
        }
        let mut due: Vec<_> = own.iter().flat_map(|follower| &follower.masters).collect();
        let mut found = Vec::new();
        while let Some(master) = due.pop() {
            // Taken out, so that a circle does not run for ever.
            if let Some(entry) = known.remove(&master.key()) {
                due.extend(&entry.follower.masters);
                found.push(entry.clone());
            }
        }
        found
    }

    /// Nodes with axes that these follow whose statuses are not known.
    fn unknown(&self, known: &[Follower]) -> Vec<NodeName> {
        // A followed node is known by its own status, a further one by any entry about it.
        let is_known = |node: &NodeName| match self.heard.get(node) {
            Some(heard) => heard.is_some(),
            None => known.iter().any(|follower| follower.axis.node == *node),
        };
        let masters = known.iter().flat_map(|follower| &follower.masters);
        let mut unknown: Vec<_> = masters
            .filter(|master| follows_others(master) && !is_known(&master.node))
            .map(|master| master.node.clone())
            .collect();
        // `dedup` joins neighbours only.
        unknown.sort();
        unknown.dedup();
        unknown
    }
}

impl CircleFinding {
    /// The circle that an axis is in, if it is in one.
    #[must_use]
    pub fn circle_of(&self, axis: &AxisAddress) -> Option<&Circle> {
        self.circles.iter().find(|of| of.axes().contains(axis))
    }

    /// The circles' part of the node's status, with the axes to forward.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let texts = |circles: &[Circle]| -> Vec<String> {
            circles.iter().map(ToString::to_string).collect()
        };
        json!({
            "found": texts(&self.circles),
            "unknown": self.unknown,
            "upstream": upstream_to_json(&self.upstream),
        })
    }
}

/// True for a receiver's axis: axes published by a sender or a gateway follow no other.
const fn follows_others(axis: &AxisAddress) -> bool {
    // Senders and gateways publish on the other channels.
    matches!(axis.channel, Channel::Slaves | Channel::FarAxes)
}

#[cfg(test)]
mod tests;
