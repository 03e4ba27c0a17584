//! Axes of all nodes, numbered, with the axes that each follows.

use std::collections::{BTreeMap, VecDeque};

use coaxle_clock::CycleTime;
use coaxle_node::circles::{AxisAddress, Circle, Follower, circles};

use crate::plant::{AxisOrigin, FarReference, PlantAxis, PlantNode};
use crate::way::WayDelay;

/// Number of an axis among all axes of all nodes.
pub(crate) type AxisNumber = usize;

/// Axes of all nodes, and who follows whom.
pub(crate) struct AxisGraph<'a> {
    pub(crate) nodes: &'a [PlantNode],
    /// Node and place in it, by number.
    places: Vec<(usize, usize)>,
    /// Number of the first axis of each node.
    first: Vec<AxisNumber>,
    /// Published axes by the texts of their addresses.
    published: BTreeMap<String, AxisNumber>,
    /// Masters of each axis: those of its own node, or the first choice on another one.
    masters: Vec<Vec<AxisNumber>>,
    followers: Vec<Vec<AxisNumber>>,
    /// Axes, masters before followers; without those in circles and behind them.
    order: Vec<AxisNumber>,
    /// Delay of the messages with each far axis.
    ways: Vec<Option<WayDelay>>,
}

impl<'a> AxisGraph<'a> {
    pub(crate) fn of(nodes: &'a [PlantNode]) -> Self {
        let mut graph = Self {
            nodes,
            places: Vec::new(),
            first: Vec::new(),
            published: BTreeMap::new(),
            masters: Vec::new(),
            followers: Vec::new(),
            order: Vec::new(),
            ways: Vec::new(),
        };
        for (n, node) in nodes.iter().enumerate() {
            graph.first.push(graph.places.len());
            for (k, axis) in node.axes.iter().enumerate() {
                if let Some((channel, id)) = axis.published {
                    let address = AxisAddress {
                        node: node.name.clone(),
                        channel,
                        id,
                    };
                    // Of two nodes of one name the first is followed; the other is a finding.
                    let number = graph.places.len();
                    graph.published.entry(address.to_string()).or_insert(number);
                }
                graph.places.push((n, k));
            }
        }
        let masters = (0..graph.places.len()).map(|axis| graph.masters_in(axis));
        graph.masters = masters.collect();
        graph.followers = vec![Vec::new(); graph.places.len()];
        for (axis, masters) in graph.masters.iter().enumerate() {
            for master in masters {
                graph.followers[*master].push(axis);
            }
        }
        graph.order = graph.sorted();
        graph.ways = graph.measured_ways();
        graph
    }

    /// Number of axes.
    pub(crate) fn count(&self) -> usize {
        self.places.len()
    }

    pub(crate) fn node_of(&self, axis: AxisNumber) -> usize {
        self.places[axis].0
    }

    pub(crate) fn axis(&self, axis: AxisNumber) -> &'a PlantAxis {
        let (node, place) = self.places[axis];
        &self.nodes[node].axes[place]
    }

    /// Numbers of the axes of a node.
    pub(crate) fn axes_of(&self, node: usize) -> std::ops::Range<AxisNumber> {
        let first = self.first[node];
        first..first + self.nodes[node].axes.len()
    }

    /// The axis with an address.
    pub(crate) fn at(&self, address: &AxisAddress) -> Option<AxisNumber> {
        self.published.get(&address.to_string()).copied()
    }

    pub(crate) fn masters(&self, axis: AxisNumber) -> &[AxisNumber] {
        &self.masters[axis]
    }

    pub(crate) fn followers(&self, axis: AxisNumber) -> &[AxisNumber] {
        &self.followers[axis]
    }

    /// Axes, masters before followers; without those in circles and behind them.
    pub(crate) fn order(&self) -> &[AxisNumber] {
        &self.order
    }

    /// Reference of an axis to another node.
    pub(crate) fn far(&self, axis: AxisNumber) -> Option<&'a FarReference> {
        far_of(self.axis(axis))
    }

    /// Delay of the messages with a far axis; none if it is unknown.
    pub(crate) fn way(&self, axis: AxisNumber) -> Option<WayDelay> {
        self.ways[axis]
    }

    /// True if an axis leads slaves of its own node, or is published for others.
    pub(crate) fn leads(&self, axis: AxisNumber) -> bool {
        let node = self.node_of(axis);
        let mut followers = self.followers(axis).iter();
        self.axis(axis).published.is_some() || followers.any(|other| self.node_of(*other) == node)
    }

    /// True if a node has a slave of an axis, directly or behind other slaves of its own.
    pub(crate) fn has_slave_of(&self, node: usize, axis: AxisNumber) -> bool {
        let own = |axis: &AxisNumber| self.node_of(*axis) == node;
        let mut due: Vec<_> = self.followers(axis).iter().copied().filter(own).collect();
        let mut seen = due.clone();
        while let Some(axis) = due.pop() {
            if matches!(self.axis(axis).origin, AxisOrigin::Slave { .. }) {
                return true;
            }
            let next = self.followers(axis).iter().copied().filter(own);
            let next: Vec<_> = next.filter(|axis| !seen.contains(axis)).collect();
            seen.extend(&next);
            due.extend(next);
        }
        false
    }

    /// Circles over all nodes.
    pub(crate) fn circles(&self) -> Vec<Circle> {
        let numbers = 0..self.count();
        let published = numbers.filter_map(|axis| self.follower(axis));
        circles(&published.collect::<Vec<_>>())
    }

    /// A published axis with the axes of other nodes that it follows in the end.
    fn follower(&self, axis: AxisNumber) -> Option<Follower> {
        let (channel, id) = self.axis(axis).published?;
        let node = self.nodes[self.node_of(axis)].name.clone();
        let (mut due, mut seen) = (vec![axis], vec![axis]);
        let mut masters = Vec::new();
        while let Some(next) = due.pop() {
            match &self.axis(next).origin {
                AxisOrigin::Far(far) => masters.extend(far.sources.iter().cloned()),
                AxisOrigin::Slave { .. } => {
                    let new = self.masters(next).iter();
                    let new: Vec<_> = new.copied().filter(|n| !seen.contains(n)).collect();
                    seen.extend(&new);
                    due.extend(new);
                }
                AxisOrigin::Root { .. } | AxisOrigin::Output(_) => {}
            }
        }
        Some(Follower {
            axis: AxisAddress { node, channel, id },
            masters,
            // A circle counts if it can be closed at all.
            is_coupled: true,
        })
    }

    fn masters_in(&self, axis: AxisNumber) -> Vec<AxisNumber> {
        let (node, _) = self.places[axis];
        match &self.axis(axis).origin {
            AxisOrigin::Root { .. } => Vec::new(),
            AxisOrigin::Far(far) | AxisOrigin::Output(far) => {
                // Standbys follow the same root: their ways are not those of ordinary operation.
                let first = far.sources.first().and_then(|source| self.at(source));
                first.into_iter().collect()
            }
            AxisOrigin::Slave { masters } => {
                let known = self.axes_of(node);
                let masters = masters.iter().map(|place| known.start + place);
                masters.filter(|number| known.contains(number)).collect()
            }
        }
    }

    /// Delay of each way, once for all axes that come over it: a simulated link takes milliseconds.
    fn measured_ways(&self) -> Vec<Option<WayDelay>> {
        let mut known: BTreeMap<(usize, &str, CycleTime), Option<WayDelay>> = BTreeMap::new();
        let mut way = |axis| {
            let far = self.far(axis)?;
            let node = self.node_of(axis);
            let own = self.nodes[node].cycle_time?;
            let source = self.masters(axis).first();
            let source = source.and_then(|source| self.nodes[self.node_of(*source)].cycle_time);
            // A publisher that nobody described may be as fast as the follower.
            let from = source.unwrap_or(own);
            let key = (node, far.field.as_str(), from);
            *known
                .entry(key)
                .or_insert_with(|| far.way.delay([from, own]))
        };
        (0..self.count()).map(&mut way).collect()
    }

    /// Kahn's order: an axis follows once all of its masters have.
    fn sorted(&self) -> Vec<AxisNumber> {
        let mut open: Vec<usize> = self.masters.iter().map(Vec::len).collect();
        let free = (0..self.count()).filter(|axis| open[*axis] == 0);
        let mut due: VecDeque<_> = free.collect();
        let mut order = Vec::with_capacity(self.count());
        while let Some(axis) = due.pop_front() {
            order.push(axis);
            for follower in self.followers(axis) {
                open[*follower] -= 1;
                if open[*follower] == 0 {
                    due.push_back(*follower);
                }
            }
        }
        order
    }
}

/// Reference of an axis to another node.
pub(crate) fn far_of(axis: &PlantAxis) -> Option<&FarReference> {
    match &axis.origin {
        AxisOrigin::Far(far) | AxisOrigin::Output(far) => Some(far),
        AxisOrigin::Root { .. } | AxisOrigin::Slave { .. } => None,
    }
}
