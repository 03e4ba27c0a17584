//! The config of a node, be it a sender's, a receiver's or a gateway's.

use std::net::SocketAddr;
use std::path::Path;

use coaxle_gateway::config::GatewayConfig;
use coaxle_node::config::{ConfigError, TransportConfig, parse, parse_table};
use coaxle_node::keys::NodeName;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_node::wiring::Wiring;
use coaxle_receiver::ReceiverConfig;
use coaxle_sender::config::SenderConfig;

/// The config of a node, by its kind.
#[derive(Clone, Debug)]
pub enum NodeConfig {
    /// A sender.
    Sender(Box<SenderConfig>),
    /// A receiver.
    Receiver(Box<ReceiverConfig>),
    /// A gateway.
    Gateway(Box<GatewayConfig>),
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
        let is_gateway = ["ads", "udp", "pipe"]
            .iter()
            .any(|key| table.contains_key(*key));
        if is_gateway {
            return Ok(Self::Gateway(parse(&name, &text)?));
        }
        let follows = ["far", "master", "slave"]
            .iter()
            .any(|key| table.contains_key(*key));
        if table.contains_key("axis") && !follows {
            return Ok(Self::Sender(parse(&name, &text)?));
        }
        Ok(Self::Receiver(parse(&name, &text)?))
    }

    /// The node's name.
    #[must_use]
    pub fn name(&self) -> &NodeName {
        match self {
            Self::Sender(config) => &config.name,
            Self::Receiver(config) => &config.name,
            Self::Gateway(config) => &config.name,
        }
    }

    /// The node's transport.
    #[must_use]
    pub fn transport(&self) -> &TransportConfig {
        match self {
            Self::Sender(config) => &config.transport,
            Self::Receiver(config) => &config.transport,
            Self::Gateway(config) => &config.transport,
        }
    }

    /// Address at which a sender answers beacons, if it does.
    #[must_use]
    pub fn timing_listen(&self) -> Option<SocketAddr> {
        match self {
            Self::Sender(config) => config.timing_endpoints().listen,
            Self::Receiver(_) | Self::Gateway(_) => None,
        }
    }

    /// Channels that the node publishes and subscribes to.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        match self {
            Self::Sender(config) => config.wiring(),
            Self::Receiver(config) => config.wiring(),
            Self::Gateway(config) => config.wiring(),
        }
    }
}
