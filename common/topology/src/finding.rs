//! Contradictions between the configs of several nodes, which none of them shows alone.

use std::collections::{BTreeMap, BTreeSet};

use coaxle_axis::Modulo;
use coaxle_node::Channel;
use coaxle_node::circles::{AxisAddress, CIRCLE_CODE};
use coaxle_node::config::{Unit, did_you_mean};
use serde::Serialize;

use crate::graph::{AxisGraph, AxisNumber};
use crate::plant::{AxisOrigin, FarReference, PlantAxis, PlantNode, Showing};

/// A contradiction, or a remark.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PlantFinding {
    /// File with the field.
    pub file: String,
    /// The field.
    pub field: String,
    /// Value received.
    pub received: String,
    /// Values expected.
    pub expected: String,
}

impl std::fmt::Display for PlantFinding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            file,
            field,
            received,
            expected,
        } = self;
        write!(
            f,
            "{file}: {field}: received {received}, expected {expected}"
        )
    }
}

/// Greatest ratio of two cycle times, as the clock of a receiver has it: from 100 µs to 100 ms.
const MOST_CYCLES: i64 = 1_000;

/// Finds all contradictions.
pub(crate) fn findings(graph: &AxisGraph<'_>) -> Vec<PlantFinding> {
    let mut found = same_names(graph.nodes);
    found.extend(circles(graph));
    for axis in 0..graph.count() {
        found.extend(silent_followers(graph, axis));
        let Some(far) = graph.far(axis) else {
            continue;
        };
        for source in &far.sources {
            match graph.at(source) {
                Some(published) => found.extend(contradictions(graph, axis, far, published)),
                None => found.extend(unpublished(graph, axis, far, source)),
            }
        }
    }
    // Axes of one far node share most of their faults.
    let mut seen = BTreeSet::new();
    found.retain(|finding| seen.insert(finding.to_string()));
    found
}

/// Nodes of one name: both would publish under the same keys.
fn same_names(nodes: &[PlantNode]) -> Vec<PlantFinding> {
    let mut known = BTreeMap::new();
    let mut found = Vec::new();
    for node in nodes {
        let first = known.entry(&node.name).or_insert(node);
        if !std::ptr::eq(*first, node) {
            found.push(PlantFinding {
                file: node.file.clone(),
                field: "name".to_owned(),
                received: format!(
                    "{:?}, which is the name in {} too",
                    node.name.as_str(),
                    first.file
                ),
                expected: "a name of its own: both publish under the same keys".to_owned(),
            });
        }
    }
    found
}

fn circles(graph: &AxisGraph<'_>) -> Vec<PlantFinding> {
    let finding = |circle: &coaxle_node::circles::Circle| {
        let axes = circle.axes();
        // The last one follows the first one again.
        let (first, next) = (axes.first()?, axes.get(1).or(axes.first())?);
        let follower = graph.at(first)?;
        let node = graph.node_of(follower);
        let far = graph.axes_of(node).filter_map(|axis| graph.far(axis));
        let mut far = far.filter(|far| far.sources.contains(next));
        let field = far.next().map_or("far", |far| &far.field);
        Some(PlantFinding {
            file: graph.nodes[node].file.clone(),
            field: format!("{field}.node"),
            received: format!("a circle ({CIRCLE_CODE:#06x}): {circle}"),
            expected: "a sender's axis or a virtual axis at the root".to_owned(),
        })
    };
    graph.circles().iter().filter_map(finding).collect()
}

/// Contradictions between a far axis and the axis that it follows.
fn contradictions(
    graph: &AxisGraph<'_>,
    axis: AxisNumber,
    far: &FarReference,
    published: AxisNumber,
) -> Vec<PlantFinding> {
    let [here, there] = [axis, published].map(|axis| &graph.nodes[graph.node_of(axis)]);
    let [own, other] = [axis, published].map(|axis| graph.axis(axis));
    let finding = |field: String, received: String, expected: String| PlantFinding {
        file: here.file.clone(),
        field,
        received,
        expected,
    };
    let place = |file: &str, field: &str, name: &str| format!("{file}: {field} ({name})");
    let publisher = place(&there.file, &other.field, &other.name);
    let mut found = Vec::new();
    if let (Some(own_unit), Some(unit)) = (&own.unit, unit_of(graph, published))
        && *own_unit != unit
    {
        found.push(finding(
            format!("{}.unit", own.field),
            format!("{:?} for {}", own_unit.as_str(), own.name),
            format!("{:?}, as {publisher}", unit.as_str()),
        ));
    }
    if let (Some(own_modulo), Some(modulo)) = (own.modulo, modulo_of(graph, published))
        && own_modulo != modulo
    {
        found.push(finding(
            format!("{}.modulo", own.field),
            format!("{} for {}", own_modulo.length(), own.name),
            format!("{}, as {publisher}", modulo.length()),
        ));
    }
    found.extend(cycle_times(here, there, far));
    found
}

/// Nodes that an axis waits for, and which do not follow it with a slave: it would wait for ever.
fn silent_followers(graph: &AxisGraph<'_>, axis: AxisNumber) -> Vec<PlantFinding> {
    let (here, own) = (&graph.nodes[graph.node_of(axis)], graph.axis(axis));
    let AxisOrigin::Root { followers, .. } = &own.origin else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (k, follower) in followers.iter().enumerate() {
        let known = graph.nodes.iter().position(|node| node.name == *follower);
        let (received, expected) = match known {
            None => (String::new(), a_known_node(graph, follower.as_str())),
            Some(node) if graph.has_slave_of(node, axis) => continue,
            // A status lists a part of the axes.
            Some(node) if !graph.nodes[node].is_complete => continue,
            Some(_) => {
                let received = format!(", which has no slave of {}", own.name);
                (received, "a receiver with a slave of the axis".to_owned())
            }
        };
        found.push(PlantFinding {
            file: here.file.clone(),
            field: format!("{}.followers.nodes[{k}]", own.field),
            received: format!("{:?}{received}", follower.as_str()),
            expected,
        });
    }
    found
}

/// Cycle times that no clock can follow. Outputs to a PLC take frames as they come.
fn cycle_times(here: &PlantNode, there: &PlantNode, far: &FarReference) -> Option<PlantFinding> {
    if far.showing == Showing::AsReceived {
        return None;
    }
    let (own, other) = (here.cycle_time?.span(), there.cycle_time?.span());
    let (least, most) = (own.min(other).as_nanos(), own.max(other).as_nanos());
    if most % least == 0 && most / least <= MOST_CYCLES {
        return None;
    }
    Some(PlantFinding {
        file: here.file.clone(),
        field: "cycle-time-us".to_owned(),
        received: format!("{}", own.as_micros_f64()),
        expected: format!(
            "a whole multiple or a whole part (up to {MOST_CYCLES}) of {}, the cycle time in {}, which {} follows",
            other.as_micros_f64(),
            there.file,
            far.field
        ),
    })
}

/// An axis that nobody publishes.
fn unpublished(
    graph: &AxisGraph<'_>,
    axis: AxisNumber,
    far: &FarReference,
    source: &AxisAddress,
) -> Option<PlantFinding> {
    let here = &graph.nodes[graph.node_of(axis)];
    let finding = |field: String, received: String, expected: String| PlantFinding {
        file: here.file.clone(),
        field,
        received,
        expected,
    };
    let node = source.node.as_str();
    let is_standby = far
        .sources
        .first()
        .is_some_and(|first| first.node != source.node);
    let nodes = graph.nodes.iter().filter(|other| other.name == source.node);
    let nodes: Vec<_> = nodes.collect();
    if nodes.is_empty() {
        let field = match is_standby {
            true => format!("{}.standby", far.field),
            false => format!("{}.node", far.field),
        };
        let expected = a_known_node(graph, node);
        return Some(finding(field, format!("{node:?}"), expected));
    }
    // A status lists a part of the axes.
    if nodes.iter().any(|node| !node.is_complete) {
        return None;
    }
    let there = nodes[0];
    let ids = (there.axes.iter()).filter_map(|axis| axis.published);
    let ids = ids.filter(|(channel, _)| *channel == source.channel);
    let ids: Vec<_> = ids.map(|(_, id)| id.to_string()).collect();
    let channel = source.channel.name();
    if ids.is_empty() {
        let published = channels_of(there);
        let expected = match source.channel {
            Channel::FarAxes => format!("publish-far-axes in {}, or {published}", there.file),
            _ => published,
        };
        return Some(finding(
            format!("{}.channel", far.field),
            format!("{channel:?} of {node}, which publishes nothing there"),
            expected,
        ));
    }
    Some(finding(
        format!("{}.axes", far.field),
        format!("the id {}", source.id),
        format!(
            "one of {node}/{channel} in {}: {}",
            there.file,
            ids.join(", ")
        ),
    ))
}

/// Text of what is expected instead of the name of an unknown node.
fn a_known_node(graph: &AxisGraph<'_>, received: &str) -> String {
    let names = graph.nodes.iter().map(|node| node.name.as_str());
    format!("a node of these configs{}", did_you_mean(received, names))
}

/// Channels on which a node publishes axes.
fn channels_of(node: &PlantNode) -> String {
    let mut names: Vec<_> = (node.axes.iter())
        .filter_map(|axis| axis.published)
        .map(|(channel, _)| format!("{:?}", channel.name()))
        .collect();
    names.sort();
    names.dedup();
    match names.is_empty() {
        true => "another node: it publishes no axes".to_owned(),
        false => format!("one of: {}", names.join(", ")),
    }
}

/// Unit of an axis: its own, or that of the axis it follows first.
pub(crate) fn unit_of(graph: &AxisGraph<'_>, axis: AxisNumber) -> Option<Unit> {
    first_of(graph, axis, |axis| axis.unit.clone(), |_| true)
}

/// Length of the modulo period of an axis. A slave has its own only: a gear has another.
pub(crate) fn modulo_of(graph: &AxisGraph<'_>, axis: AxisNumber) -> Option<Modulo> {
    let is_same = |axis: &PlantAxis| !matches!(axis.origin, AxisOrigin::Slave { .. });
    first_of(graph, axis, |axis| axis.modulo, is_same)
}

/// The first value on the way from an axis over first masters to its root.
fn first_of<T>(
    graph: &AxisGraph<'_>,
    axis: AxisNumber,
    value: impl Fn(&PlantAxis) -> Option<T>,
    passes: impl Fn(&PlantAxis) -> bool,
) -> Option<T> {
    let mut at = axis;
    // At most as many steps as there are axes, which may follow each other in a circle.
    for _ in 0..=graph.count() {
        let axis = graph.axis(at);
        if let Some(value) = value(axis) {
            return Some(value);
        }
        if !passes(axis) {
            return None;
        }
        at = *graph.masters(at).first()?;
    }
    None
}
