//! The audit of a running node, from outside.

use std::time::Duration;

use anyhow::{anyhow, bail};
use coaxle_node::audit::{AuditExcerpt, AuditQuery};
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::NodeNotFound;

use crate::client::search::{SEARCH, is_there};
use crate::client::session::session;
use crate::network::transport::{OverZenoh, Transport};

/// Response timeout.
// Nodes respond within milliseconds; the rest is for a slow network.
const ANSWER: Duration = Duration::from_secs(3);

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
        let client = self.transport.client(&key, ANSWER)?;
        let place = format!("asked under {key}, {}", self.transport.whereabouts());
        if !is_there(
            &*client,
            &format!("node {node}"),
            self.transport.whereabouts(),
        ) {
            let why = self.transport.invisibility_reason(node.as_str());
            let why = why.map_or_else(String::new, |why| format!("; {}", why.reason()));
            let missing =
                format!("node {node} shows no audit: it is not there after {SEARCH}, {place}{why}");
            return Err(NodeNotFound(missing).into());
        }
        let Some(payload) = client.request(query.to_json())? else {
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
