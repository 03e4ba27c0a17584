//! Members of a network.

use std::path::Path;
use std::str::FromStr;

use coaxle_node::keys::NodeName;
use coaxle_node::wiring::Wiring;

use crate::node_config::NodeConfig;

/// A node.
#[derive(Clone, Debug)]
pub struct Member {
    /// Name, which the certificate bears.
    pub name: NodeName,
    /// Endpoints that it listens on.
    pub listen: Vec<String>,
    /// Endpoints that it connects to.
    pub connect: Vec<String>,
    /// Channels that it publishes and subscribes to.
    pub wiring: Wiring,
}

/// An operator, who sends orders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operator {
    /// The name, which the certificate bears.
    pub name: NodeName,
    /// The nodes that take orders from this operator; none named: all.
    pub nodes: Vec<NodeName>,
}

impl Member {
    /// The node of a config file.
    ///
    /// # Errors
    /// Names the file, the field, what was received and what is expected.
    pub fn load(file: &Path) -> anyhow::Result<Self> {
        Ok(Self::of(&NodeConfig::load(file)?))
    }

    /// The node of a config.
    #[must_use]
    pub fn of(config: &NodeConfig) -> Self {
        let transport = config.transport();
        Self {
            name: config.name().clone(),
            listen: transport.listen.clone(),
            connect: transport.connect.clone(),
            wiring: config.wiring(),
        }
    }
}

impl Operator {
    /// True if this node takes orders from this operator.
    #[must_use]
    pub fn commands(&self, node: &NodeName) -> bool {
        // Nodes that are added later are commanded as well, without a change of the operator.
        self.nodes.is_empty() || self.nodes.contains(node)
    }
}

impl FromStr for Operator {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let name = |text: &str| NodeName::new(text).map_err(|error| error.to_string());
        // Only the first `=`: names of nodes have none.
        let Some((operator, nodes)) = text.split_once('=') else {
            return Ok(Self {
                name: name(text)?,
                nodes: Vec::new(),
            });
        };
        Ok(Self {
            name: name(operator)?,
            nodes: nodes.split(',').map(name).collect::<Result<_, _>>()?,
        })
    }
}
