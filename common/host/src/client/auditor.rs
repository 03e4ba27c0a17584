//! The audit of a running node, from outside.

use anyhow::{anyhow, bail};
use coaxle_node::audit::{AuditExcerpt, AuditQuery};
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;

use crate::client::search::{NodeRequest, NodeResponse, ask, why_invisible};
use crate::client::session::session;
use crate::network::transport::{OverZenoh, Transport};

/// Client that reads the audit of nodes; its calls block until the response.
pub struct AuditReader {
    transport: OverZenoh,
}

impl AuditReader {
    /// Joins the network.
    ///
    /// # Errors
    /// A wrong transport section, certificates that cannot be read, or a session that cannot be opened, with the
    /// endpoints.
    pub fn open(transport: &TransportConfig) -> anyhow::Result<Self> {
        Ok(Self {
            transport: session(transport)?,
        })
    }

    /// Sends a query to a node, and waits for its response.
    ///
    /// # Errors
    /// The node does not appear within five seconds, does not respond within three, or responds with something
    /// else; with the node's name and the searched endpoints.
    pub fn ask(&self, node: &NodeName, query: &AuditQuery) -> anyhow::Result<AuditExcerpt> {
        let key = node.audit_key();
        let request = NodeRequest {
            node,
            key: &key,
            json: query.to_json(),
            absent: "shows no audit",
        };
        let why = || why_invisible(&self.transport, node);
        let NodeResponse { payload, place } = ask(&self.transport, request, why)?;
        let Some(payload) = payload else {
            bail!("node {node} did not answer; {place}");
        };
        AuditExcerpt::from_json(&payload).map_err(|error| {
            let text = String::from_utf8_lossy(&payload);
            let text = coaxle_node::one_line(&text);
            anyhow!("node {node} answered {text:?}, which is no audit: {error}; {place}")
        })
    }

    /// Leaves the network.
    pub fn close(self) {
        self.transport.close();
    }
}
