//! The scenario file.

use std::collections::BTreeSet;

use coaxle_node::config::{DurationSeconds, LinkConfig, Wrong, did_you_mean};
use coaxle_node::faults::seed_of;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::Wiring;
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::SenderConfig;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::event::{Action, Event, EventKind};
use crate::expect::{Expectation, receiver_of};
use crate::group::Group;
use crate::invariants::Exception;
use crate::router::{RouterConfig, fits};

/// An experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Scenario {
    /// Subject of the experiment, in one line.
    pub title: String,
    /// Points of interest, and reasons.
    #[serde(default)]
    pub description: String,
    /// Duration, s of true time: at most a million, eleven days.
    pub duration_s: DurationSeconds,
    /// Seed of everything random. The same seed gives the same run in virtual time, byte for byte.
    #[serde(default = "first_seed")]
    pub seed: u64,
    /// The simulated network. Real processes have a real one; faults to be added to
    /// that belong into a receiver's `faults`.
    #[serde(default)]
    pub network: LinkConfig,
    /// The network of the beacons of timing channels, which take another way: no fault of `network` applies to them.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub timing_network: LinkConfig,
    /// The routers between nodes in virtual time; without any, each message goes from node to node at once. Real processes have
    /// none of them.
    #[serde(rename = "router", default, skip_serializing_if = "Vec::is_empty")]
    pub routers: Vec<RouterConfig>,
    /// Similar nodes, written once: reading expands them among the senders and receivers.
    #[serde(rename = "group", default, skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<Group>,
    /// The senders.
    #[serde(rename = "sender", default)]
    pub senders: Vec<SenderConfig>,
    /// The receivers.
    #[serde(rename = "receiver", default)]
    pub receivers: Vec<ReceiverConfig>,
    /// Events during the run.
    #[serde(rename = "event", default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
    /// The grid of `coaxle sweep`, unless another one is given.
    #[serde(rename = "sweep", default, skip_serializing_if = "Vec::is_empty")]
    pub grid: Vec<GridAxis>,
    /// Expectations of the outcome.
    #[serde(rename = "expect", default, skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<Expectation>,
    /// Exceptions from the invariants that hold in every run by default.
    #[serde(rename = "exception", default, skip_serializing_if = "Vec::is_empty")]
    pub exceptions: Vec<Exception>,
}

/// A field of the scenario and the values it takes in a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct GridAxis {
    /// The path of the field, as `--set` takes it.
    pub field: String,
    /// The values, in the order they are run.
    #[schemars(with = "Vec<serde_json::Value>")]
    pub values: Vec<toml::Value>,
}

fn is_nothing(network: &LinkConfig) -> bool {
    *network == LinkConfig::default()
}

const fn first_seed() -> u64 {
    1
}

/// Most nodes of a scenario.
const MOST_NODES: usize = 1000;

impl Scenario {
    /// # Errors
    /// [`Wrong`]: too many nodes.
    pub(crate) fn check_count(&self) -> Result<(), Wrong> {
        let received = self.senders.len() + self.receivers.len();
        if received <= MOST_NODES {
            return Ok(());
        }
        let received = format!("{received} senders and receivers");
        let expected = format!("at most {MOST_NODES}");
        Err(Wrong::of("receiver", received, expected))
    }

    /// Channels that every node publishes and subscribes to: senders first, then receivers, then duplicates.
    pub fn wirings(&self) -> Vec<Wiring> {
        let senders = self.senders.iter().map(SenderConfig::wiring);
        let receivers = self.receivers.iter().map(ReceiverConfig::wiring);
        let mut wirings: Vec<_> = senders.chain(receivers).collect();
        for twin in self.twins() {
            let original = wirings.iter().find(|wiring| wiring.node == *twin);
            wirings.extend(original.cloned());
        }
        wirings
    }

    /// The nodes that get a duplicate of the same name, in the order of the events.
    pub fn twins(&self) -> Vec<&NodeName> {
        let mut twins = Vec::new();
        for event in &self.events {
            let is_twin = matches!(
                event.what,
                EventKind::Away {
                    action: Action::Twin,
                    ..
                }
            );
            // A duplicate that comes twice is one node, started twice.
            if is_twin && !twins.contains(&&event.node) {
                twins.push(&event.node);
            }
        }
        twins
    }

    /// Index of a node's duplicate, if it has one: duplicates come after all nodes.
    pub(crate) fn twin_of(&self, node: &NodeName) -> Option<usize> {
        let place = self.twins().iter().position(|twin| *twin == node)?;
        Some(self.senders.len() + self.receivers.len() + place)
    }

    /// Index of the router of this name, if there is one.
    pub(crate) fn router(&self, name: &NodeName) -> Option<usize> {
        self.routers.iter().position(|router| router.name == *name)
    }

    /// Seed of one node, equal in both worlds.
    #[must_use]
    pub fn seed_of(&self, node: &NodeName) -> u64 {
        // A config file holds no integer above this.
        seed_of(self.seed, node.as_str()) & i64::MAX as u64
    }

    /// Keeps only the named receivers, and the nodes that they need.
    ///
    /// # Errors
    /// The name that no receiver has.
    pub fn keep_receivers(&mut self, names: &[String]) -> Result<(), String> {
        for name in names {
            if !self.receivers.iter().any(|r| r.name.as_str() == name) {
                let known: Vec<_> = self.receivers.iter().map(|r| r.name.as_str()).collect();
                return Err(format!(
                    "received {name:?}, expected some of: {}{}",
                    known.join(", "),
                    did_you_mean(name, known.iter().copied())
                ));
            }
        }
        let mut kept: BTreeSet<String> = names.iter().cloned().collect();
        // A chained receiver needs those before it.
        while let Some(more) = self.receivers.iter().find_map(|receiver| {
            let heard = receiver.received_nodes().into_iter();
            let needed = heard.map(|heard| heard.node.as_str());
            let is_missing = |needed: &&str| {
                !kept.contains(*needed) && self.receivers.iter().any(|r| r.name.as_str() == *needed)
            };
            let mut missing = needed.filter(is_missing);
            kept.contains(receiver.name.as_str())
                .then(|| missing.next().map(str::to_owned))
                .flatten()
        }) {
            kept.insert(more);
        }
        self.receivers.retain(|r| kept.contains(r.name.as_str()));
        self.expectations
            // A share of a receiver that is left out cannot be judged.
            .retain(|e| e.nodes().all(|name| kept.contains(receiver_of(name))));
        self.exceptions.retain(|e| kept.contains(&e.receiver));
        for router in &mut self.routers {
            // A pattern that fits no node is refused when a scenario is read.
            router.nodes.retain(|pattern| {
                kept.iter().any(|name| fits(pattern, name))
                    || self.senders.iter().any(|s| fits(pattern, s.name.as_str()))
            });
        }
        self.events.retain(|event| {
            let name = event.node.as_str();
            kept.contains(name)
                || self.senders.iter().any(|s| s.name.as_str() == name)
                || self.routers.iter().any(|r| r.name.as_str() == name)
        });
        Ok(())
    }
}
