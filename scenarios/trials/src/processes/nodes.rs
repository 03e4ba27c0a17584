//! The nodes of a scenario, made ready to run as processes of this machine.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Context;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::topology::Topology;
use coaxle_node::config::TransportConfig;
use coaxle_node::lab::{NodeFile, WithLab};
use coaxle_node::wiring;
use coaxle_os::ClaimedPort;

use super::child::{Child, NodeOutput, NodeRole};

/// Transport protocol between nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Protocol {
    /// TCP
    Tcp,
    /// UDP
    Udp,
}

impl Protocol {
    /// Returns the name in endpoints.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Tcp => "tcp",
            Self::Udp => "udp",
        }
    }
}

/// The nodes, in the order of the scenario, senders first and duplicates last, with the endpoint each listens on.
pub(crate) struct NodeProcesses {
    pub(crate) children: Vec<Child>,
    pub(crate) endpoints: Vec<String>,
    /// Nobody is given the ports of nodes that still have to start, or to start again.
    pub(crate) ports: Vec<ClaimedPort>,
}

impl NodeProcesses {
    /// Writes the nodes' configs into `folder`, which is emptied. Receivers leave there the output that
    /// `of_receivers` names, senders a trace.
    pub(crate) fn prepare(
        scenario: &Scenario,
        topology: &Topology,
        folder: &Path,
        protocol: Protocol,
        of_receivers: NodeOutput,
    ) -> anyhow::Result<Self> {
        if folder.exists() {
            // Traces of an earlier run must not be taken for this one's.
            std::fs::remove_dir_all(folder)
                .with_context(|| format!("cannot empty {}", folder.display()))?;
        }
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        // A twin has the name of its node, but a port of its own.
        let count = topology.names().len() + scenario.twins().len();
        let ports: Result<Vec<_>, _> = (0..count).map(|_| ClaimedPort::find()).collect();
        let ports = ports.context("cannot find free ports")?;
        let endpoint =
            |port: &ClaimedPort| format!("{}/127.0.0.1:{}", protocol.name(), port.number());
        let endpoints: Vec<_> = ports.iter().map(endpoint).collect();
        let children = write_configs(scenario, topology, folder, &endpoints, of_receivers)?;
        Ok(Self {
            children,
            endpoints,
            ports,
        })
    }
}

fn write_configs(
    scenario: &Scenario,
    topology: &Topology,
    folder: &Path,
    endpoints: &[String],
    of_receivers: NodeOutput,
) -> anyhow::Result<Vec<Child>> {
    let names: Vec<_> = topology.names().iter().chain(scenario.twins()).collect();
    let ways = wiring::links(&scenario.wirings());
    // A node resolves files from its config, which is in another folder.
    let here = std::env::current_dir().context("cannot tell the current folder")?;
    let mut children = Vec::new();
    for (n, name) in names.iter().enumerate() {
        // Nodes of one name share a config, except for their endpoints.
        let file = match n.checked_sub(topology.names().len()) {
            None => name.to_string(),
            Some(_) => format!("{name}-twin"),
        };
        let listen = || endpoints[n].clone();
        if let Some(config) = scenario.senders.iter().find(|s| s.name == **name) {
            let mut config = config.clone();
            config.relative_to(&here);
            // As in virtual time: each node draws its faults from its own seed.
            config.seed = scenario.seed_of(&config.name);
            config.transport = local(&config.transport, listen(), Vec::new());
            let path = write_toml(folder, &file, &config)?;
            children.push(Child::new(NodeRole::Sender, &file, path, NodeOutput::Trace));
        }
        if let Some(config) = scenario.receivers.iter().find(|r| r.name == **name) {
            let mut config = config.clone();
            // A set, because several links may come from one node, which is connected to once.
            let sources: BTreeSet<usize> = (ways.iter())
                .filter(|way| way.to == n)
                .map(|way| way.from)
                .collect();
            config.relative_to(&here);
            config.seed = scenario.seed_of(&config.name);
            // Requesters connect to this node themselves.
            let heard: Vec<_> = (config.received_nodes().iter())
                .map(|heard| heard.node.clone())
                .collect();
            let followed = |node: &&usize| heard.contains(names[**node]);
            let sources = sources.iter().filter(followed);
            let connect = sources.map(|n| endpoints[*n].clone()).collect();
            config.transport = local(&config.transport, listen(), connect);
            let path = write_toml(folder, &file, &config)?;
            children.push(Child::new(NodeRole::Receiver, &file, path, of_receivers));
        }
    }
    Ok(children)
}

/// The node's own Zenoh settings, on endpoints of this machine.
fn local(config: &TransportConfig, listen: String, connect: Vec<String>) -> TransportConfig {
    TransportConfig {
        listen: vec![listen],
        // Only to nodes of this run, whatever the scenario's network says.
        connect,
        ..config.clone()
    }
}

fn write_toml(folder: &Path, name: &str, config: &impl WithLab) -> anyhow::Result<PathBuf> {
    let path = folder.join(format!("{name}.toml"));
    let text = NodeFile::text_of(config).with_context(|| format!("cannot write {name} as TOML"))?;
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}
