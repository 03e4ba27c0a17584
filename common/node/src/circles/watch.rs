//! Circles as one node of a running network finds them.
//!
//! A node sees only those that it follows: nothing is forwarded between two peers. So the status of each passes on what it knows
//! of the axes before its own, and a circle is found however many nodes are in it: after as many statuses, a quarter of a second
//! each.

use std::collections::BTreeMap;

use coaxle_slave::CircleState;
use coaxle_wire::Channel;
use coaxle_wire::keys::NodeName;
use serde_json::{Map, Value, json};

use super::reading::{Upstream, followers_of, upstream_of, upstream_to_json};
use super::{AxisAddress, Circle, Follower, circles_through};

/// What is passed on more often is stale: it goes round in a circle whose axis has changed since. As RIP counts to infinity
/// (RFC 2453, 3.4.2), with more than its 15 because nodes in a line are many.
const MOST_HOPS: u32 = 64;
/// The most axes that are taken of one status, so that none can fill the memory.
const MOST_AXES: usize = 4096;

/// The circles that the axes of one node are in, by the statuses of the nodes that it follows.
#[derive(Clone, Debug)]
pub struct CircleWatch {
    node: NodeName,
    /// The nodes that it follows, with what is known of them and by them.
    heard: BTreeMap<NodeName, Option<Vec<Upstream>>>,
}

/// What a node finds of circles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CircleFinding {
    /// The circles that axes of the node are in, closed ones first.
    pub circles: Vec<Circle>,
    /// The state of each axis of the node.
    pub states: Vec<CircleChange>,
    /// Nodes that are followed, be it by others in between, and whose axes are not known.
    pub unknown: Vec<NodeName>,
    upstream: Vec<Upstream>,
}

/// The circle that an axis of a node is in from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CircleChange {
    /// In which of its frames the node publishes the axis.
    pub channel: Channel,
    /// Its axis id there.
    pub id: u32,
    /// The circle.
    pub state: CircleState,
}

impl CircleWatch {
    /// For a node that follows axes which these other nodes follow others with: those of receivers.
    pub fn new(node: NodeName, follows: impl IntoIterator<Item = NodeName>) -> Self {
        let others = follows.into_iter().filter(|other| *other != node);
        let heard = others.map(|other| (other, None)).collect();
        Self { node, heard }
    }

    /// The nodes whose status it takes.
    pub fn nodes(&self) -> impl Iterator<Item = &NodeName> {
        self.heard.keys()
    }

    /// Takes the status of a node.
    pub fn take(&mut self, node: &NodeName, status: &Map<String, Value>) {
        if let Some(known) = self.heard.get_mut(node) {
            let own = followers_of(node, status).into_iter().take(MOST_AXES);
            let own = own.map(|follower| Upstream { follower, hops: 1 });
            let passed_on = upstream_of(status, MOST_AXES).into_iter();
            let passed_on = passed_on.filter_map(|Upstream { follower, hops }| {
                let hops = hops.saturating_add(1);
                let is_known_better =
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

    /// What follows for the axes of this node, as its own status has them.
    #[must_use]
    pub fn look(&self, own: &Map<String, Value>) -> CircleFinding {
        let own = followers_of(&self.node, own);
        let upstream = self.before(&own);
        let all = own
            .iter()
            .chain(upstream.iter().map(|before| &before.follower));
        let coupled = |follower: &&Follower| follower.is_coupled;
        let closed: Vec<_> = all.clone().filter(coupled).cloned().collect();
        let closed = circles_through(&closed, own.iter().filter(coupled).count());
        let all: Vec<_> = all.cloned().collect();
        let possible = circles_through(&all, own.len());
        let is_in = |circles: &[Circle], axis| circles.iter().any(|of| of.axes().contains(axis));
        let states = own.iter().map(|Follower { axis, .. }| CircleChange {
            channel: axis.channel,
            id: axis.id,
            state: match axis {
                axis if is_in(&closed, axis) => CircleState::Closed,
                axis if is_in(&possible, axis) => CircleState::Open,
                _ => CircleState::None,
            },
        });
        let states = states.collect();
        let unknown = self.unknown(&all);
        let mut circles = closed;
        for circle in possible {
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

    /// The axes of other nodes that these follow in the end, each as it is known by the fewest hops.
    fn before(&self, own: &[Follower]) -> Vec<Upstream> {
        let mut known: BTreeMap<_, &Upstream> = BTreeMap::new();
        for entry in self.heard.values().flatten().flatten() {
            let nearest = known.entry(entry.follower.axis.key()).or_insert(entry);
            if entry.hops < nearest.hops {
                *nearest = entry;
            }
        }
        let mut due: Vec<_> = own.iter().flat_map(|follower| &follower.masters).collect();
        let mut found = Vec::new();
        while let Some(master) = due.pop() {
            if let Some(entry) = known.remove(&master.key()) {
                due.extend(&entry.follower.masters);
                found.push(entry.clone());
            }
        }
        found
    }

    /// Nodes with axes that these follow, of which nothing is known.
    fn unknown(&self, known: &[Follower]) -> Vec<NodeName> {
        let is_known = |node: &NodeName| match self.heard.get(node) {
            Some(heard) => heard.is_some(),
            None => known.iter().any(|follower| follower.axis.node == *node),
        };
        let masters = known.iter().flat_map(|follower| &follower.masters);
        let mut unknown: Vec<_> = masters
            .filter(|master| follows_others(master) && !is_known(&master.node))
            .map(|master| master.node.clone())
            .collect();
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

    /// What the status of the node says of it, and passes on.
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

/// Whether an axis is a receiver's: what a sender or a gateway publishes follows nothing.
const fn follows_others(axis: &AxisAddress) -> bool {
    matches!(axis.channel, Channel::Slaves | Channel::FarAxes)
}

#[cfg(test)]
mod tests;
