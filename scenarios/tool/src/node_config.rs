//! The config of a node, be it a sender's, a receiver's or a gateway's.

use std::net::SocketAddr;
use std::path::Path;

use coaxle_gateway::config::GatewayConfig;
use coaxle_node::config::{ConfigError, TransportConfig, parse_table};
use coaxle_node::keys::NodeName;
use coaxle_node::lab::{LabFields, NodeFile, WithLab};
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_node::wiring::Wiring;
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::SenderConfig;

/// The config of a node, by its kind.
#[derive(Clone, Debug)]
pub struct NodeConfig {
    /// The config, by the kind of node.
    pub kind: NodeKind,
    /// Injected faults and simulated inputs of its `[lab]` table; none without a table.
    pub lab: Option<LabFields>,
}

/// The config of a node, by its kind.
#[derive(Clone, Debug)]
pub enum NodeKind {
    /// A sender.
    Sender(Box<SenderConfig>),
    /// A receiver.
    Receiver(Box<ReceiverConfig>),
    /// A gateway.
    Gateway(Box<GatewayConfig>),
}

impl From<NodeKind> for NodeConfig {
    fn from(kind: NodeKind) -> Self {
        Self { kind, lab: None }
    }
}

impl NodeConfig {
    /// Reads a config file. A gateway has a connection to a PLC and a sender has axes. A receiver follows axes of others.
    ///
    /// # Errors
    /// Names the file, the field, what was received and what is expected.
    pub fn load(file: &Path) -> Result<Self, ConfigError> {
        let name = file.display().to_string();
        let text = text_file::read(file, MOST_CONFIG_BYTES)?;
        let table = parse_table(&name, &text)?;
        // By the fields, as no field names the kind.
        // The connection to a PLC comes first: a gateway may have an `[[axis]]` as a sender has.
        let is_gateway = ["ads", "udp", "pipe"]
            .iter()
            .any(|key| table.contains_key(*key));
        if is_gateway {
            return Self::read(&name, &text, NodeKind::Gateway);
        }
        let follows = ["far", "master", "slave"]
            .iter()
            .any(|key| table.contains_key(*key));
        if table.contains_key("axis") && !follows {
            return Self::read(&name, &text, NodeKind::Sender);
        }
        // The last kind, whose error names what is missing.
        Self::read(&name, &text, NodeKind::Receiver)
    }

    fn read<C: WithLab>(
        file: &str,
        text: &str,
        kind: impl FnOnce(Box<C>) -> NodeKind,
    ) -> Result<Self, ConfigError> {
        let NodeFile { config, lab } = NodeFile::parse(file, text)?;
        let kind = kind(Box::new(config));
        Ok(Self { kind, lab })
    }

    /// The node's name.
    #[must_use]
    pub fn name(&self) -> &NodeName {
        match &self.kind {
            NodeKind::Sender(config) => &config.name,
            NodeKind::Receiver(config) => &config.name,
            NodeKind::Gateway(config) => &config.name,
        }
    }

    /// The node's transport.
    #[must_use]
    pub fn transport(&self) -> &TransportConfig {
        match &self.kind {
            NodeKind::Sender(config) => &config.transport,
            NodeKind::Receiver(config) => &config.transport,
            NodeKind::Gateway(config) => &config.transport,
        }
    }

    /// Address at which the node answers beacons, if it does.
    #[must_use]
    pub fn timing_listen(&self) -> Option<SocketAddr> {
        match &self.kind {
            NodeKind::Sender(config) => config.timing_endpoints().listen,
            NodeKind::Receiver(config) => config.timing_endpoints().listen,
            NodeKind::Gateway(_) => None,
        }
    }

    /// Channels that the node publishes and subscribes to.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        match &self.kind {
            NodeKind::Sender(config) => config.wiring(),
            NodeKind::Receiver(config) => config.wiring(),
            NodeKind::Gateway(config) => config.wiring(),
        }
    }
}
