//! Nodes that run: their axes from what they say of themselves, the delays from their statuses.

use std::time::Duration;

use coaxle_clock::{CycleTime, Span};
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::{SeenNode, Watcher};
use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::config::Unit;
use coaxle_topology::{
    AxisOrigin, FarReference, LagRule, MeasuredWay, PlantAxis, PlantNode, PlantRole, RootMotion,
    Showing, WaySource, about_from_json,
};
use serde_json::{Map, Value};

use crate::status;

/// Time in which a node answers, or is one that does not describe its axes.
const ANSWER: Duration = Duration::from_secs(1);

/// Gathers the nodes that run.
///
/// # Errors
/// A network that cannot be joined, or without any node.
pub(super) fn nodes(network: &NetworkArgs) -> anyhow::Result<Vec<PlantNode>> {
    let watcher = network.watch(&[])?;
    let nodes = status::gather(&watcher, &[]).map(|seen| described(&watcher, &seen));
    watcher.close();
    nodes
}

/// Describes the nodes that run, of those that are seen. Each is asked, and waited for up to a second.
pub(crate) fn described(watcher: &Watcher, seen: &[SeenNode]) -> Vec<PlantNode> {
    let alive = seen.iter().filter(|node| node.is_alive);
    alive.filter_map(|node| node_of(watcher, node)).collect()
}

fn node_of(watcher: &Watcher, seen: &SeenNode) -> Option<PlantNode> {
    let (_, status) = seen.status.as_ref()?;
    let mut node = about(watcher, seen).unwrap_or_else(|| by_status(seen, status));
    // A finding of a running node has no file.
    node.file = format!("node {}", seen.name);
    node.hold_back = status
        .get("hold_back_us")
        .and_then(Value::as_f64)
        .map(Span::from_micros_f64);
    for axis in &mut node.axes {
        if let AxisOrigin::Far(far) = &mut axis.origin {
            measure(far, status);
        }
    }
    Some(node)
}

/// Description of a node by itself; none of one that gives none.
fn about(watcher: &Watcher, seen: &SeenNode) -> Option<PlantNode> {
    let client = watcher.transport().client(&seen.name.about_key(), ANSWER);
    let reply = client.ok()?.request(String::new()).ok()??;
    match about_from_json(&reply) {
        Ok((node, _)) if node.name == seen.name => Some(node),
        Ok((node, _)) => {
            tracing::warn!(
                "node {} describes the axes of {}: ignored",
                seen.name,
                node.name
            );
            None
        }
        Err(error) => {
            tracing::warn!(
                "what node {} says of its axes is ignored: {error}",
                seen.name
            );
            None
        }
    }
}

/// Adds what the receiver measures of a far node.
fn measure(far: &mut FarReference, status: &Map<String, Value>) {
    let Some(source) = far.sources.first() else {
        return;
    };
    let measured = &status.get("far").unwrap_or(&Value::Null)[source.node.as_str()];
    let time = |name: &str| measured[name].as_f64().map(Span::from_micros_f64);
    far.measure(&MeasuredWay {
        delay: time("delay_us"),
        needed: time("needed_present_after_us"),
        present_after: time("present_after_us"),
        lag: time("presentation_lag_us"),
    });
}

/// A node that does not describe its axes, by its status: slaves without their masters in the node.
fn by_status(seen: &SeenNode, status: &Map<String, Value>) -> PlantNode {
    let role = match status.get("role").and_then(Value::as_str) {
        Some("sender") => PlantRole::Sender,
        Some("receiver") => PlantRole::Receiver,
        Some("gateway") => PlantRole::Gateway,
        _ => PlantRole::Unknown,
    };
    let cycle = status.get("cycle_time_us").and_then(Value::as_f64);
    let cycle = cycle.map(Span::from_micros_f64).map(CycleTime::new);
    let mut axes: Vec<_> = parts(status, "axes")
        .map(|(name, axis)| axis_by_status(name, axis))
        .collect();
    let far: Vec<_> = axes.iter().map(sources).collect();
    axes.extend(parts(status, "slaves").map(|(name, slave)| {
        let follows = addresses(slave);
        let is_master = |sources: &&Vec<AxisAddress>| sources.iter().any(|it| follows.contains(it));
        let places = far.iter().enumerate();
        let masters = places
            .filter(|(_, sources)| is_master(sources))
            .map(|(n, _)| n);
        axis(
            name,
            slave["id"].as_u64().map(|id| (Channel::Slaves, id)),
            slave,
            AxisOrigin::Slave {
                masters: masters.collect(),
            },
        )
    }));
    PlantNode {
        file: String::new(),
        name: seen.name.clone(),
        role,
        cycle_time: cycle.and_then(Result::ok),
        axes,
        is_complete: false,
        hold_back: None,
    }
}

fn axis_by_status(name: &str, status: &Value) -> PlantAxis {
    let follows = addresses(status);
    let (channel, id) = match follows.is_empty() {
        true => (Channel::Axes, &status["id"]),
        false => (Channel::FarAxes, &status["published_id"]),
    };
    let origin = match follows.is_empty() {
        true => AxisOrigin::Root {
            motion: RootMotion::Unknown,
            present_after: None,
            followers: Vec::new(),
        },
        false => AxisOrigin::Far(FarReference {
            field: "far".to_owned(),
            sources: follows,
            way: WaySource::Unknown,
            showing: Showing::Later(LagRule::Full),
            measured: None,
        }),
    };
    axis(name, id.as_u64().map(|id| (channel, id)), status, origin)
}

fn axis(
    name: &str,
    published: Option<(Channel, u64)>,
    status: &Value,
    origin: AxisOrigin,
) -> PlantAxis {
    let published = published.and_then(|(channel, id)| Some((channel, u32::try_from(id).ok()?)));
    let unit = status["unit"]
        .as_str()
        .and_then(|unit| Unit::new(unit).ok());
    PlantAxis {
        name: name.to_owned(),
        field: "status".to_owned(),
        published,
        // The default is any unit.
        unit: unit.filter(|unit| *unit != Unit::default()),
        modulo: None,
        limits: None,
        origin,
    }
}

fn sources(axis: &PlantAxis) -> Vec<AxisAddress> {
    match &axis.origin {
        AxisOrigin::Far(far) => far.sources.clone(),
        _ => Vec::new(),
    }
}

fn addresses(status: &Value) -> Vec<AxisAddress> {
    let list = status["follows"].as_array().into_iter().flatten();
    let texts = list.filter_map(Value::as_str);
    texts.filter_map(AxisAddress::read).collect()
}

fn parts<'a>(
    status: &'a Map<String, Value>,
    group: &str,
) -> impl Iterator<Item = (&'a str, &'a Value)> {
    let group = status.get(group).and_then(Value::as_object);
    let parts = group.into_iter().flatten();
    parts.map(|(name, part)| (name.as_str(), part))
}
