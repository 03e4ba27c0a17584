//! The scenario file.

use std::collections::BTreeSet;
use std::num::NonZeroU32;

use coaxle_node::config::{ConfigError, LinkConfig, Positive, from_table};
use coaxle_node::faults::seed_of;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::Wiring;
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::{SenderConfig, ShownAxes};
use serde::{Deserialize, Serialize};

use crate::event::{Event, Happening};
use crate::expect::Expectation;
use crate::topology::Topology;

/// An experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Scenario {
    /// One line: what it shows.
    pub title: String,
    /// What to look at, and why.
    #[serde(default)]
    pub description: String,
    /// How long it runs, s of true time.
    pub duration_s: Positive,
    /// Seed of everything random. The same seed gives the same run in virtual time, byte for byte.
    #[serde(default = "first_seed")]
    pub seed: u64,
    /// The simulated network. Real processes have a real one; what is to be laid over
    /// that belongs into a receiver's `faults`.
    #[serde(default)]
    pub network: LinkConfig,
    /// The senders.
    #[serde(rename = "sender")]
    pub senders: Vec<SenderConfig>,
    /// The receivers.
    #[serde(rename = "receiver")]
    pub receivers: Vec<ReceiverConfig>,
    /// What happens on the way.
    #[serde(rename = "event", default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<Event>,
    /// The grid that `coaxle sweep` runs it over, unless told otherwise.
    #[serde(rename = "sweep", default, skip_serializing_if = "Vec::is_empty")]
    pub grid: Vec<GridAxis>,
    /// What is expected of the outcome.
    #[serde(rename = "expect", default, skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<Expectation>,
}

/// A field of the scenario and the values it takes in a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct GridAxis {
    /// The path of the field, as `--set` takes it.
    pub field: String,
    /// The values, in the order they are run.
    pub values: Vec<toml::Value>,
}

/// The receiver that is meant by the name of one of its far axes, or by its own.
pub(crate) fn receiver_of(name: &str) -> &str {
    name.split_once('/').map_or(name, |(receiver, _)| receiver)
}

const fn first_seed() -> u64 {
    1
}

impl Scenario {
    /// Reads and checks a scenario. `file` is what the errors call it.
    ///
    /// # Errors
    /// [`ConfigError`] names the file, the field, what was received and what is expected.
    pub fn from_table(file: &str, table: toml::Table) -> Result<Self, ConfigError> {
        let mut scenario: Self = from_table(file, table)?;
        if let Some(folder) = std::path::Path::new(file).parent() {
            for sender in &mut scenario.senders {
                sender.relative_to(folder);
            }
            for receiver in &mut scenario.receivers {
                receiver.relative_to(folder);
            }
        }
        scenario.show_followed_axes(file)?;
        scenario.check(file)?;
        Ok(scenario)
    }

    /// The evaluation needs to see every axis that somebody follows.
    fn show_followed_axes(&mut self, file: &str) -> Result<(), ConfigError> {
        let topology = Topology::of(self).map_err(|wrong| wrong.in_file(file))?;
        for (n, sender) in self.senders.iter_mut().enumerate() {
            let axes = (topology.views().iter())
                .map(|view| view.root)
                .filter(|root| root.sender == n)
                .filter_map(|root| NonZeroU32::new(root.axis))
                .collect::<BTreeSet<_>>();
            sender.show_axes = ShownAxes::new(axes.into_iter().collect()).map_err(|wrong| {
                ConfigError::field(file, format!("sender[{n}]: axes with receivers"), wrong)
            })?;
        }
        Ok(())
    }

    /// What every node publishes and hears: senders first, then receivers.
    pub(crate) fn wirings(&self) -> Vec<Wiring> {
        let senders = self.senders.iter().map(SenderConfig::wiring);
        senders
            .chain(self.receivers.iter().map(ReceiverConfig::wiring))
            .collect()
    }

    /// The seed of one node, the same in both worlds.
    #[must_use]
    pub fn seed_of(&self, node: &NodeName) -> u64 {
        // A config file holds no integer above this.
        seed_of(self.seed, node.as_str()) & i64::MAX as u64
    }

    /// Keeps only the receivers that are named, and what they need.
    ///
    /// # Errors
    /// The name that no receiver has.
    pub fn keep_receivers(&mut self, names: &[String]) -> Result<(), String> {
        for name in names {
            if !self.receivers.iter().any(|r| r.name.as_str() == name) {
                let known: Vec<_> = self.receivers.iter().map(|r| r.name.as_str()).collect();
                return Err(format!(
                    "received {name:?}, expected some of: {}",
                    known.join(", ")
                ));
            }
        }
        let mut kept: BTreeSet<String> = names.iter().cloned().collect();
        // A chained receiver needs those before it.
        while let Some(more) = self.receivers.iter().find_map(|receiver| {
            let needed = receiver.far.iter().map(|far| far.node.as_str());
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
            .retain(|e| e.nodes().all(|name| kept.contains(receiver_of(name))));
        self.events.retain(|event| {
            let name = event.node.as_str();
            kept.contains(name) || self.senders.iter().any(|s| s.name.as_str() == name)
        });
        Ok(())
    }

    fn check(&self, file: &str) -> Result<(), ConfigError> {
        let topology = Topology::of(self).map_err(|wrong| wrong.in_file(file))?;
        for (n, event) in self.events.iter().enumerate() {
            if topology.node(&event.node).is_none() {
                let reason = format!(
                    "received {:?}, expected a node of this scenario",
                    event.node.as_str()
                );
                return Err(ConfigError::field(file, format!("event[{n}].node"), reason));
            }
            self.check_slave(event)
                .map_err(|reason| ConfigError::field(file, format!("event[{n}].slave"), reason))?;
        }
        for (n, expectation) in self.expectations.iter().enumerate() {
            expectation.check(self).map_err(|(field, reason)| {
                ConfigError::field(file, format!("expect[{n}].{field}"), reason)
            })?;
        }
        self.check_nodes(file)
    }

    /// Who is commanded must be there.
    fn check_slave(&self, event: &Event) -> Result<(), String> {
        let Happening::Command(commanded) = event.what else {
            return Ok(());
        };
        let slave = commanded.order.slave;
        let known: Vec<_> = self
            .receivers
            .iter()
            .filter(|receiver| receiver.name == event.node)
            .flat_map(|receiver| receiver.slaves.iter().map(|slave| slave.name.as_str()))
            .collect();
        if known.contains(&slave.as_str()) {
            return Ok(());
        }
        Err(format!(
            "received {:?}, expected a slave of {}: {}",
            slave.as_str(),
            event.node,
            known.join(", ")
        ))
    }

    /// Every node must be able to start: its parameters are checked where they are used.
    fn check_nodes(&self, file: &str) -> Result<(), ConfigError> {
        let start = coaxle_clock::Instant::EPOCH;
        for (n, sender) in self.senders.iter().enumerate() {
            coaxle_sender::Sender::new(sender, start, 0)
                .map_err(|wrong| ConfigError::field(file, format!("sender[{n}]"), wrong))?;
        }
        for (n, receiver) in self.receivers.iter().enumerate() {
            coaxle_receiver::Receiver::new(receiver, start, 0)
                .map_err(|wrong| ConfigError::field(file, format!("receiver[{n}]"), wrong))?;
        }
        Ok(())
    }
}
