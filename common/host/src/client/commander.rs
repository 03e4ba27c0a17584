//! Commanding nodes from outside.

use std::path::Path;
use std::sync::Arc;

use anyhow::{anyhow, bail};
use coaxle_clock::Span;
use coaxle_node::config::TransportConfig;
use coaxle_node::guess::did_you_mean;
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};

use crate::client::search::{NodeRequest, NodeResponse, ask, why_invisible};
use crate::client::session::session;
use crate::client::watcher::Watcher;
use crate::network::credentials::{BadCredentials, Credentials};
use crate::network::transport::Transport;

/// Time for other nodes to announce themselves.
// Longer than Zenoh's scouting delay of 500 ms.
const ROUND: Span = Span::from_millis(600);

/// Operator's name of the page that a node serves of itself; a secure network gives it to nobody else.
pub const PAGE: &str = "page";

/// Client that sends orders; its calls block until the response.
pub struct Commander {
    transport: Arc<dyn Transport>,
    operator: Option<NodeName>,
}

impl Commander {
    /// Joins the network. With certificates, orders carry the name of their holder.
    ///
    /// # Errors
    /// A wrong transport section, certificates that cannot be read, or a session that cannot be opened, with the
    /// endpoints.
    pub fn open(transport: &TransportConfig) -> anyhow::Result<Self> {
        let operator = holder_of(transport.secure.as_deref())?;
        Ok(Self {
            transport: Arc::new(session(transport)?),
            operator,
        })
    }

    /// Sends orders over an existing transport, in the name of the operator of the secure profile
    /// it was opened with, or without a name.
    ///
    /// # Errors
    /// Certificates that cannot be read.
    pub fn over(transport: Arc<dyn Transport>, secure: Option<&Path>) -> anyhow::Result<Self> {
        Ok(Self {
            operator: holder_of(secure)?,
            transport,
        })
    }

    /// Sends the orders of a page that a node serves of itself, over the node's own transport. They carry the
    /// name [`PAGE`].
    ///
    /// # Errors
    /// Never: the name is one.
    pub fn of_page(transport: &Arc<dyn Transport>) -> anyhow::Result<Self> {
        Ok(Self::named(Arc::clone(transport), NodeName::new(PAGE)?))
    }

    /// Creates a commander with an operator's name that is not authenticated.
    pub(crate) fn named(transport: Arc<dyn Transport>, operator: NodeName) -> Self {
        Self {
            transport,
            operator: Some(operator),
        }
    }

    /// Sends an order and waits for the node's response.
    ///
    /// # Errors
    /// The node does not appear within five seconds, or does not respond within three; with the
    /// node's name and the searched endpoints.
    pub fn send(&self, node: &NodeName, order: &CommandOrder) -> anyhow::Result<CommandAnswer> {
        let key = match &self.operator {
            Some(operator) => node.operator_command_key(operator),
            None => node.command_key(),
        };
        let request = NodeRequest {
            node,
            key: &key,
            json: order.to_json(),
            absent: "takes no orders",
        };
        let others = || self.others(node);
        let NodeResponse { payload, place } = ask(&*self.transport, request, others)?;
        // Lost on the way there or on the way back: nobody can tell, so the text promises neither.
        let Some(payload) = payload else {
            bail!(
                "node {node} did not answer, so it may or may not have the command after all; {place}"
            );
        };
        CommandAnswer::from_json(&payload).map_err(|error| {
            let text = String::from_utf8_lossy(&payload);
            anyhow!("node {node} answered {text:?}, which is no answer: {error}; {place}")
        })
    }

    /// Text on the nodes seen instead of the missing one, or on why none is seen; empty if neither
    /// is known.
    fn others(&self, node: &NodeName) -> String {
        // In a secure network an operator may not list all nodes.
        let names = match &self.operator {
            Some(_) => Vec::new(),
            None => self.nodes(),
        };
        if names.is_empty() {
            return why_invisible(&*self.transport, node);
        }
        let names: Vec<_> = names.iter().map(NodeName::as_str).collect();
        let meant = did_you_mean(node.as_str(), names.iter().copied());
        format!("; there are {}{meant}", names.join(", "))
    }

    /// The nodes that are announced.
    fn nodes(&self) -> Vec<NodeName> {
        let Ok(watcher) = Watcher::over(Arc::clone(&self.transport), &[]) else {
            return Vec::new();
        };
        let seen = watcher.wait_for(ROUND, |_| false).into_iter();
        seen.filter(|node| node.is_alive)
            .map(|node| node.name)
            .collect()
    }

    /// Leaves the network.
    pub fn close(self) {
        self.transport.close();
    }
}

/// Name of the holder of a secure profile folder.
fn holder_of(secure: Option<&Path>) -> Result<Option<NodeName>, BadCredentials> {
    let credentials = secure.map(Credentials::open).transpose()?;
    Ok(credentials.map(|found| found.name().clone()))
}
