//! The joints of a node: the names of its axes in ROS, and the scales of their values.

use std::collections::BTreeMap;

use coaxle_wire::Channel;
use coaxle_wire::command::SlaveName;
use coaxle_wire::keys::NodeName;
use serde_json::{Map, Value};

use crate::unit::UnitScale;

/// An axis as a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct RosJoint {
    /// `conveyor/belt`, an axis of a sender; `saw/carriage`, a slave of a receiver; `saw/far/belt`, an
    /// axis that a receiver follows, as corrected.
    pub name: String,
    /// The unit of the axis; none if the node does not state it.
    pub unit: Option<String>,
    /// Scale of its unit; none if the unit is not known.
    pub scale: Option<UnitScale>,
    /// The slave behind it, if it is one that takes orders.
    pub slave: Option<SlaveName>,
}

/// The joints of a node, from its status (docs/WIRE.md).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Catalog(BTreeMap<(&'static str, u32), RosJoint>);

impl RosJoint {
    /// Returns the scale of its values: 1 if the unit is not known.
    #[must_use]
    pub fn scale(&self) -> UnitScale {
        self.scale.unwrap_or(UnitScale::NONE)
    }

    fn new(node: &NodeName, channel: Channel, axis: &str, unit: Option<&str>) -> Self {
        Self {
            // An axis that is followed may have the name of a slave of the same receiver.
            name: match channel {
                Channel::FarAxes => format!("{node}/far/{axis}"),
                _ => format!("{node}/{axis}"),
            },
            scale: unit.and_then(UnitScale::of),
            unit: unit.map(str::to_owned),
            slave: match channel {
                Channel::Slaves => SlaveName::new(axis).ok(),
                _ => None,
            },
        }
    }
}

impl Catalog {
    /// Reads the axes in the status of a node.
    #[must_use]
    pub fn of_status(node: &NodeName, status: &Map<String, Value>) -> Self {
        let mut joints = BTreeMap::new();
        let mut add = |channel: Channel, id: &str, axis: &str, fields: &Value| {
            let id = fields.get(id).and_then(Value::as_u64);
            // A status of a later version may lack the field: the joint is then named by its id.
            if let Some(id) = id.and_then(|id| u32::try_from(id).ok()) {
                let unit = fields.get("unit").and_then(Value::as_str);
                let joint = RosJoint::new(node, channel, axis, unit);
                joints.insert((channel.name(), id), joint);
            }
        };
        for (axis, fields) in parts(status, "axes") {
            // Far axes of a receiver are the ones that it follows.
            match fields.get("node") {
                Some(_) => add(Channel::FarAxes, "published_id", axis, fields),
                None => add(Channel::Axes, "id", axis, fields),
            }
        }
        for (axis, fields) in parts(status, "slaves") {
            add(Channel::Slaves, "id", axis, fields);
        }
        Self(joints)
    }

    /// Returns the joint of an axis in a frame of a channel. The status of a node with many axes does not
    /// contain all of them: one that it does not contain is named by its id, `conveyor/axis-7`, and its
    /// unit is not known.
    #[must_use]
    pub fn joint(&self, node: &NodeName, channel: Channel, id: u32) -> RosJoint {
        let known = self.0.get(&(channel.name(), id)).cloned();
        known.unwrap_or_else(|| RosJoint {
            slave: None,
            ..RosJoint::new(node, channel, &format!("axis-{id}"), None)
        })
    }

    /// Returns the joints that take orders, each with the axis id of its slave.
    pub fn slaves(&self) -> impl Iterator<Item = (u32, &RosJoint)> {
        let slaves = self.0.iter().filter(|(_, joint)| joint.slave.is_some());
        slaves.map(|((_, id), joint)| (*id, joint))
    }

    /// Returns the joints with a unit that is stated but not known.
    pub fn unknown_units(&self) -> impl Iterator<Item = &RosJoint> {
        let unknown = |joint: &&RosJoint| joint.unit.is_some() && joint.scale.is_none();
        self.0.values().filter(unknown)
    }
}

fn parts<'a>(
    status: &'a Map<String, Value>,
    name: &str,
) -> impl Iterator<Item = (&'a String, &'a Value)> {
    let parts = status.get(name).and_then(Value::as_object);
    parts.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn catalog(node: &NodeName, status: &Value) -> Catalog {
        Catalog::of_status(node, status.as_object().unwrap())
    }

    #[test]
    fn axes_are_called_by_node_and_name() {
        let conveyor = NodeName::new("conveyor").unwrap();
        let status = json!({ "axes": { "belt": { "id": 1, "unit": "mm" }, "drum": { "id": 2, "unit": "pcs" } } });
        let told = catalog(&conveyor, &status);
        let belt = told.joint(&conveyor, Channel::Axes, 1);
        assert_eq!((belt.name.as_str(), belt.slave), ("conveyor/belt", None));
        assert_eq!(belt.scale().to_ros(2000.0), 2.0);
        assert_eq!(
            told.joint(&conveyor, Channel::Axes, 7).name,
            "conveyor/axis-7"
        );
        let unknown: Vec<_> = told.unknown_units().map(|joint| &joint.name).collect();
        assert_eq!(unknown, ["conveyor/drum"]);
        assert_eq!(
            told.joint(&conveyor, Channel::Axes, 2).scale(),
            UnitScale::NONE
        );
    }

    #[test]
    fn of_a_receiver_slaves_take_orders_and_far_axes_have_the_ids_under_which_they_are_published() {
        let saw = NodeName::new("saw").unwrap();
        let status = json!({
            "axes": { "belt": { "node": "conveyor", "id": 3, "published_id": 1, "unit": "mm" },
                      "unseen": { "node": "conveyor", "id": 4, "published_id": null } },
            "slaves": { "carriage": { "id": 1, "unit": "°" } },
        });
        let told = catalog(&saw, &status);
        assert_eq!(told.joint(&saw, Channel::FarAxes, 1).name, "saw/far/belt");
        let slaves: Vec<_> = told
            .slaves()
            .map(|(id, joint)| (id, joint.name.as_str()))
            .collect();
        assert_eq!(slaves, [(1, "saw/carriage")]);
    }

    #[test]
    fn what_is_no_status_tells_nothing() {
        let saw = NodeName::new("saw").unwrap();
        for status in [
            json!({}),
            json!({ "axes": 3 }),
            // Ids that no u32 holds.
            json!({ "axes": { "a": 1, "b": { "id": -1 }, "c": { "id": 1e20 } } }),
        ] {
            assert_eq!(catalog(&saw, &status), Catalog::default(), "{status}");
        }
    }
}
