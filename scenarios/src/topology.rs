//! Who follows whom: receivers resolved to the sender they get their motion from in the end.

use coaxle_node::config::ConfigError;
use coaxle_node::keys::NodeName;
use coaxle_receiver::config::{GearConfig, MasterChannel};

use crate::scenario::Scenario;

/// Nodes are numbered: senders first, then receivers, each in the order of the file.
#[derive(Debug)]
pub(crate) struct Topology {
    names: Vec<NodeName>,
    roots: Vec<Root>,
}

/// Where a receiver's motion comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Root {
    /// Number of the node it follows.
    pub(crate) source: usize,
    /// Number of the sender at the root.
    pub(crate) sender: usize,
    /// The sender's axis.
    pub(crate) axis: u32,
    /// What it receives, as a function of that axis: the gears before it in one. None where
    /// something else than gears moves a slave before it: then nobody knows.
    pub(crate) gear: Option<GearConfig>,
}

/// A field that is wrong, and why.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct WrongField {
    field: String,
    reason: String,
}

impl WrongField {
    pub(crate) fn in_file(self, file: &str) -> ConfigError {
        ConfigError::field(file, self.field, self.reason)
    }
}

impl Topology {
    pub(crate) fn of(scenario: &Scenario) -> Result<Self, WrongField> {
        let names: Vec<NodeName> = scenario
            .senders
            .iter()
            .map(|sender| sender.name.clone())
            .chain(scenario.receivers.iter().map(|r| r.name.clone()))
            .collect();
        for (n, name) in names.iter().enumerate() {
            if names[..n].contains(name) {
                return Err(WrongField {
                    field: field_of(scenario, n, "name"),
                    reason: format!(
                        "received {:?} twice, expected a name of its own for each node",
                        name.as_str()
                    ),
                });
            }
        }
        let mut topology = Self {
            names,
            roots: Vec::new(),
        };
        topology.roots = (0..scenario.receivers.len())
            .map(|n| topology.resolve(scenario, n))
            .collect::<Result<_, _>>()?;
        Ok(topology)
    }

    /// The number of a node.
    pub(crate) fn node(&self, name: &NodeName) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    pub(crate) fn names(&self) -> &[NodeName] {
        &self.names
    }

    /// Where the n-th receiver's motion comes from.
    pub(crate) fn root(&self, receiver: usize) -> Root {
        self.roots[receiver]
    }

    fn resolve(&self, scenario: &Scenario, receiver: usize) -> Result<Root, WrongField> {
        let mut gears = Vec::new();
        let mut at = receiver;
        let mut first_source = None;
        loop {
            let master = &scenario.receivers[at].master;
            let wrong = |field: &str, reason: String| WrongField {
                field: format!("receiver[{at}].master.{field}"),
                reason,
            };
            let known = self.node(&master.node);
            let senders = scenario.senders.len();
            match (known, master.channel) {
                (Some(node), MasterChannel::Axes) if node < senders => {
                    let axes = &scenario.senders[node].axes;
                    if !axes.iter().any(|axis| axis.id.get() == master.axis) {
                        let reason = format!(
                            "received {}, expected the id of an axis of {}",
                            master.axis, master.node
                        );
                        return Err(wrong("axis", reason));
                    }
                    return Ok(Root {
                        source: first_source.unwrap_or(node),
                        sender: node,
                        axis: master.axis,
                        gear: in_one(&gears),
                    });
                }
                (Some(node), MasterChannel::Slaves) if node >= senders => {
                    let before = node - senders;
                    let followed = &scenario.receivers[before];
                    let Some(slave) = followed.slave_with_id(master.axis) else {
                        let reason = format!(
                            "received {}, expected the id of a slave of {}",
                            master.axis, master.node
                        );
                        return Err(wrong("axis", reason));
                    };
                    if gears.len() > scenario.receivers.len() {
                        let reason = format!(
                            "{} follows itself in the end, expected a sender at the root",
                            master.node
                        );
                        return Err(wrong("node", reason));
                    }
                    gears.push(followed.gear_to(slave));
                    first_source.get_or_insert(node);
                    at = before;
                }
                (Some(_), _) => {
                    let reason =
                        "expected channel \"axes\" with a sender, \"slaves\" with a receiver"
                            .to_owned();
                    return Err(wrong("channel", reason));
                }
                (None, _) => {
                    let reason = format!(
                        "received {:?}, expected a node of this scenario",
                        master.node.as_str()
                    );
                    return Err(wrong("node", reason));
                }
            }
        }
    }
}

/// Gears one after the other, the last one first.
fn in_one(gears: &[Option<GearConfig>]) -> Option<GearConfig> {
    gears
        .iter()
        .rev()
        .try_fold(GearConfig::default(), |before, gear| {
            let gear = (*gear)?;
            Some(GearConfig {
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
