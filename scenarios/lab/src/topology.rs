//! Topology: every axis that leads slaves, resolved to the node at the root of its motion:
//! a sender, or a receiver with a virtual axis.

use coaxle_node::Channel;
use coaxle_node::circles::{CIRCLE_CODE, circles};
use coaxle_node::config::{Wrong, did_you_mean};
use coaxle_node::keys::NodeName;
use coaxle_receiver::config::{FarAxisConfig, FarChannel, FarConfig, GearConfig, MasterRef};
use coaxle_receiver::{ReceiverConfig, SignalRow};

use crate::scenario::Scenario;

/// Nodes are numbered: senders first, then receivers, each in the order of the file.
#[derive(Debug)]
pub struct Topology {
    names: Vec<NodeName>,
    views: Vec<View>,
}

/// A far or a virtual axis of a receiver, and the root of its motion. A receiver is judged
/// by each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Name: the receiver's, where it follows only one axis.
    pub name: String,
    /// The receiver, counted among the receivers.
    pub receiver: usize,
    /// Axis of the receiver.
    pub of: ReceiverAxis,
    /// The receiver's slaves that follow it in the end.
    pub slaves: Vec<usize>,
    /// The axis that truly leads it.
    pub root: Root,
    /// Roots of a far axis's motion while a standby is followed.
    pub standbys: Vec<Root>,
    /// Indices of the nodes that it is read from, among all that the receiver receives: none for a virtual axis.
    pub nodes: Vec<usize>,
}

/// Place of the followed one of these nodes; the first, before the first cycle.
pub fn followed_of(nodes: &[usize], signals: &SignalRow) -> usize {
    let mut followed = nodes.iter().map(|node| signals.far[*node].followed);
    followed.position(|followed| followed).unwrap_or(0)
}

/// An axis of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiverAxis {
    /// A far axis.
    Far {
        /// Index of the far node.
        far: usize,
        /// Index among all far axes.
        axis: usize,
    },
    /// A virtual axis.
    Virtual(usize),
}

/// Root of an axis's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Index of the followed node; for a virtual axis, of its own.
    pub source: usize,
    /// Index of the node at the root: a sender, or a receiver with a virtual axis.
    pub node: usize,
    /// The axis of that node.
    pub axis: u32,
    /// Received position as a function of that axis: the gears before it in one. Absent where
    /// a coupling other than a gear moves a slave before it: then the function is unknown.
    pub gear: Option<GearConfig>,
}

impl Topology {
    /// Resolves the axes of a scenario.
    ///
    /// # Errors
    /// [`Wrong`] names the field that refers to a missing node or axis.
    pub fn of(scenario: &Scenario) -> Result<Self, Wrong> {
        let names: Vec<NodeName> = scenario
            .senders
            .iter()
            .map(|sender| sender.name.clone())
            .chain(scenario.receivers.iter().map(|r| r.name.clone()))
            .collect();
        for (n, name) in names.iter().enumerate() {
            if names[..n].contains(name) {
                let received = format!("{:?} twice", name.as_str());
                let expected = "a name of its own for each node";
                return Err(Wrong::of(field_of(scenario, n, "name"), received, expected));
            }
        }
        // Before any axis is resolved, which goes from node to node and would not end in a circle.
        check_circles(&scenario.receivers)?;
        let mut topology = Self {
            names,
            views: Vec::new(),
        };
        for receiver in 0..scenario.receivers.len() {
            let views = topology.views_in(scenario, receiver)?;
            topology.views.extend(views);
        }
        Ok(topology)
    }

    fn views_in(&self, scenario: &Scenario, receiver: usize) -> Result<Vec<View>, Wrong> {
        let config = &scenario.receivers[receiver];
        let view = |(name, of)| {
            let (mut standbys, mut nodes) = (Vec::new(), Vec::new());
            let root = match of {
                ReceiverAxis::Far { far, axis } => {
                    nodes = config.numbers_of(far);
                    for node in &config.far[far].standby {
                        standbys.push(self.resolve(scenario, receiver, axis, node)?);
                    }
                    self.resolve(scenario, receiver, axis, &config.far[far].node)?
                }
                ReceiverAxis::Virtual(axis) => {
                    let own = scenario.senders.len() + receiver;
                    virtual_root(config, axis, own, own, &[])
                }
            };
            Ok(View {
                name,
                receiver,
                of,
                slaves: slaves_of(config, of),
                root,
                standbys,
                nodes,
            })
        };
        named(config).into_iter().map(view).collect()
    }

    /// Index of a node.
    pub fn node(&self, name: &NodeName) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// The name of each node, senders first.
    #[must_use]
    pub fn names(&self) -> &[NodeName] {
        &self.names
    }

    /// Every far and virtual axis of every receiver, receiver after receiver.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Root of a far axis in `first`: the node that is followed, or a standby.
    fn resolve(
        &self,
        scenario: &Scenario,
        receiver: usize,
        axis: usize,
        first: &NodeName,
    ) -> Result<Root, Wrong> {
        let mut gears = Vec::new();
        let (mut at, mut axis) = (receiver, axis);
        let mut first_source = None;
        let mut first = Some(first);
        loop {
            let config = &scenario.receivers[at];
            let Some((n, far, FarAxisConfig { id, .. })) = config.far_axes().nth(axis) else {
                unreachable!("the axis is one of the config's");
            };
            let within = |wrong: Wrong| wrong.within(format_args!("receiver[{at}].far[{n}]"));
            // Only the first hop may be a standby: nodes before it follow their first choice.
            let node_name = first.take().unwrap_or(&far.node);
            let known = self.node(node_name);
            let senders = scenario.senders.len();
            match (known, far.channel) {
                (Some(node), FarChannel::Axes) if node < senders => {
                    let axes = scenario.senders[node].axes.iter().map(|axis| axis.id.get());
                    if !axes.clone().any(|other| other == *id) {
                        return Err(within(not_among(*id, node_name, axes)));
                    }
                    return Ok(Root {
                        source: first_source.unwrap_or(node),
                        node,
                        axis: *id,
                        gear: in_one(&gears),
                    });
                }
                (Some(node), FarChannel::Slaves) if node >= senders => {
                    let before = node - senders;
                    let followed = &scenario.receivers[before];
                    let Some(slave) = followed.slave_with_id(*id) else {
                        let ids = (0..followed.slaves.len()).map(|n| followed.slave_id(n));
                        return Err(within(not_among(*id, node_name, ids)));
                    };
                    gears.push(followed.gear_to(slave));
                    first_source.get_or_insert(node);
                    match followed.root_of(slave) {
                        Some(MasterRef::Far(root)) => (at, axis) = (before, root),
                        Some(MasterRef::Virtual(root)) => {
                            let source = first_source.unwrap_or(node);
                            return Ok(virtual_root(followed, root, node, source, &gears));
                        }
                        Some(MasterRef::Slave(_)) | None => {
                            let received =
                                format!("a slave of {node_name} without an axis at its root");
                            let expected = "one that follows a far or virtual axis in the end";
                            return Err(within(Wrong::of("axes", received, expected)));
                        }
                    }
                }
                (Some(node), FarChannel::FarAxes) if node >= senders => {
                    let before = node - senders;
                    let published = scenario.receivers[before].published_far_axes();
                    let place = (*id as usize).checked_sub(1);
                    let Some(followed) = place.and_then(|place| published.get(place)) else {
                        let ids = 1..=published.len() as u32;
                        return Err(within(not_among(*id, node_name, ids)));
                    };
                    gears.push(Some(GearConfig::default()));
                    first_source.get_or_insert(node);
                    (at, axis) = (before, *followed);
                }
                (Some(node), channel) => {
                    let kind = if node < senders { "sender" } else { "receiver" };
                    let received = format!("{:?} with a {kind}", Channel::from(channel).name());
                    let expected =
                        "\"axes\" with a sender, \"slaves\" or \"far-axes\" with a receiver";
                    return Err(within(Wrong::of("channel", received, expected)));
                }
                (None, _) => {
                    let names = self.names.iter().map(NodeName::as_str);
                    return Err(within(unknown_node(node_name, names)));
                }
            }
        }
    }
}

/// The axes of a receiver, the far ones first, with their names: the receiver's, where there is
/// only one.
fn named(config: &ReceiverConfig) -> Vec<(String, ReceiverAxis)> {
    let far_axes = config.far_axes().enumerate();
    let far = far_axes.map(|(axis, (far, _, _))| ReceiverAxis::Far { far, axis });
    let virtual_axes = (0..config.virtual_axes.len()).map(ReceiverAxis::Virtual);
    let names = config.far_axis_names().into_iter();
    let names = names.chain(config.virtual_axis_names());
    let mut axes: Vec<_> = names.zip(far.chain(virtual_axes)).collect();
    let is_one = axes.len() == 1;
    for (name, _) in &mut axes {
        *name = if is_one {
            config.name.to_string()
        } else {
            format!("{}/{name}", config.name)
        };
    }
    axes
}

/// Indices of the slaves that follow an axis in the end.
fn slaves_of(config: &ReceiverConfig, of: ReceiverAxis) -> Vec<usize> {
    let root = match of {
        ReceiverAxis::Far { axis, .. } => MasterRef::Far(axis),
        ReceiverAxis::Virtual(axis) => MasterRef::Virtual(axis),
    };
    let slaves = 0..config.slaves.len();
    slaves
        .filter(|n| config.root_of(*n) == Some(root))
        .collect()
}

/// A motion that comes from a virtual axis of the receiver `node`, by way of `source`.
fn virtual_root(
    config: &ReceiverConfig,
    axis: usize,
    node: usize,
    source: usize,
    gears: &[Option<GearConfig>],
) -> Root {
    Root {
        source,
        node,
        axis: config.virtual_axes[axis].id.get(),
        gear: in_one(gears),
    }
}

/// Refuses nodes that follow each other: a scenario knows all of them, so that no node of a circle has to find it.
fn check_circles(receivers: &[ReceiverConfig]) -> Result<(), Wrong> {
    let followers: Vec<_> = receivers
        .iter()
        .flat_map(ReceiverConfig::followers)
        .collect();
    let circles = circles(&followers);
    let Some(circle) = circles.first() else {
        return Ok(());
    };
    // The last one follows the first one again.
    let (first, next) = match circle.axes() {
        [] => return Ok(()),
        [only] => (only, only),
        [first, next, ..] => (first, next),
    };
    let receiver = receivers
        .iter()
        .position(|config| config.name == first.node);
    let receiver = receiver.unwrap_or_default();
    let leads = |far: &FarConfig| far.node == next.node || far.standby.contains(&next.node);
    let far = receivers[receiver].far.iter().position(leads);
    let field = format!("receiver[{receiver}].far[{}].node", far.unwrap_or_default());
    let expected = "a sender's axis or a virtual axis at the root";
    let wrong = Wrong::of(field, format_args!("a circle: {circle}"), expected);
    Err(wrong.with_code(CIRCLE_CODE))
}

/// The error about an axis that a node does not have, with those it has.
fn not_among(id: u32, node: &NodeName, known: impl Iterator<Item = u32>) -> Wrong {
    let known: Vec<_> = known.map(|id| id.to_string()).collect();
    let expected = format!("one of {node}: {}", known.join(", "));
    Wrong::of("axes", format_args!("the id {id}"), expected)
}

/// The error about a node that a scenario does not have.
pub(crate) fn unknown_node<'n>(node: &NodeName, known: impl Iterator<Item = &'n str>) -> Wrong {
    let node = node.as_str();
    let expected = format!("a node of this scenario{}", did_you_mean(node, known));
    Wrong::of("node", format_args!("{node:?}"), expected)
}

/// Combines gears one after the other, the last one first.
fn in_one(gears: &[Option<GearConfig>]) -> Option<GearConfig> {
    gears
        .iter()
        .rev()
        .try_fold(GearConfig::default(), |before, gear| {
            let gear = (*gear)?;
            Some(GearConfig {
                // g(f(x)) with f = a·x + b and g = c·x + d is c·a·x + c·b + d. The last gear pushed is the nearest to the root.
                ratio: gear.ratio * before.ratio,
                offset: gear.ratio * before.offset + gear.offset,
            })
        })
}

fn field_of(scenario: &Scenario, node: usize, field: &str) -> String {
    match node.checked_sub(scenario.senders.len()) {
        None => format!("sender[{node}].{field}"),
        Some(receiver) => format!("receiver[{receiver}].{field}"),
    }
}

#[cfg(test)]
impl View {
    /// A receiver called `r` with one far axis, which this many slaves follow.
    pub fn of_first_axis(slaves: usize) -> Self {
        Self {
            name: "r".to_owned(),
            receiver: 0,
            of: ReceiverAxis::Far { far: 0, axis: 0 },
            slaves: (0..slaves).collect(),
            root: Root {
                source: 0,
                node: 0,
                axis: 1,
                gear: None,
            },
            standbys: Vec::new(),
            nodes: vec![0],
        }
    }
}

#[cfg(test)]
mod tests;
