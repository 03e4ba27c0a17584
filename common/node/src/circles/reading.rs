//! Followers and masters read from statuses; missing or malformed parts are ignored.

use coaxle_wire::Channel;
use coaxle_wire::keys::NodeName;
use serde_json::{Map, Value, json};

use super::{AxisAddress, Follower};

/// The published axes of a node by its status: slaves, and far axes as corrected.
#[must_use]
pub fn followers_of(node: &NodeName, status: &Map<String, Value>) -> Vec<Follower> {
    let follower = |channel, id: u64, axis: &Value, is_coupled| {
        Some(Follower {
            axis: AxisAddress {
                node: node.clone(),
                channel,
                id: u32::try_from(id).ok()?,
            },
            masters: addresses(&axis["follows"]),
            is_coupled,
        })
    };
    let slaves = parts(status, "slaves").filter_map(|slave| {
        // A slave without a phase is not coupled: its circle is open.
        let is_coupled = !slave["phase"].is_null();
        follower(Channel::Slaves, slave["id"].as_u64()?, slave, is_coupled)
    });
    // A far axis is always coupled: its input is published.
    let axes = parts(status, "axes").filter_map(|axis| {
        let id = axis["published_id"].as_u64()?;
        follower(Channel::FarAxes, id, axis, true)
    });
    slaves.chain(axes).collect()
}

/// An axis of another node, and the number of nodes that have forwarded its data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Upstream {
    pub(super) follower: Follower,
    pub(super) hops: u32,
}

/// The axes of other nodes that a status forwards, at most `most`.
pub(super) fn upstream_of(status: &Map<String, Value>, most: usize) -> Vec<Upstream> {
    let list = status
        .get("circles")
        .and_then(|of| of["upstream"].as_array());
    // Before reading: a status of another node may hold any number of entries.
    let list = list.into_iter().flatten().take(most);
    let read = |entry: &Value| {
        Some(Upstream {
            follower: Follower {
                axis: AxisAddress::read(entry["axis"].as_str()?)?,
                masters: addresses(&entry["follows"]),
                is_coupled: entry["coupled"].as_bool()?,
            },
            // Out of range is no entry, as any malformed one.
            hops: u32::try_from(entry["hops"].as_u64()?).ok()?,
        })
    };
    list.filter_map(read).collect()
}

/// Upstream axes as JSON, in the form that [`upstream_of`] reads.
pub(super) fn upstream_to_json(upstream: &[Upstream]) -> Value {
    let entry = |Upstream { follower, hops }: &Upstream| {
        let texts = |addresses: &[AxisAddress]| -> Vec<String> {
            addresses.iter().map(ToString::to_string).collect()
        };
        json!({
            "axis": follower.axis.to_string(),
            "follows": texts(&follower.masters),
            "coupled": follower.is_coupled,
            "hops": hops,
        })
    };
    upstream.iter().map(entry).collect()
}

fn parts<'a>(status: &'a Map<String, Value>, group: &str) -> impl Iterator<Item = &'a Value> {
    let group = status.get(group).and_then(Value::as_object);
    group.into_iter().flat_map(Map::values)
}

fn addresses(list: &Value) -> Vec<AxisAddress> {
    let list = list.as_array().into_iter().flatten();
    let texts = list.filter_map(Value::as_str);
    texts.filter_map(AxisAddress::read).collect()
}
