//! Commanding nodes from outside.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{anyhow, bail};
use coaxle_clock::Span;
use coaxle_node::config::TransportConfig;
use coaxle_node::guess::did_you_mean;
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};
use coaxle_os::machine;

use crate::credentials::{BadCredentials, Credentials};
use crate::transport::{Client, OverZenoh, Transport};
use crate::watcher::Watcher;

/// How long a node may take to turn up.
const SEARCH: Span = Span::from_secs(5);
/// Nodes answer within a second, and the network is slow for once.
const ANSWER: Duration = Duration::from_secs(3);
/// Others that are there announce themselves within this time.
const ROUND: Span = Span::from_millis(600);
/// How often it looks whether the node is there.
const LOOK: Duration = Duration::from_millis(10);

/// Sends orders. Its calls wait for the answers.
pub struct Commander {
    transport: Arc<dyn Transport>,
    operator: Option<NodeName>,
}

impl Commander {
    /// Joins the network. With certificates, orders bear the name of their holder.
    ///
    /// # Errors
    /// A wrong transport section, certificates that cannot be read, or a session that cannot be opened, with the
    /// endpoints.
    pub fn open(transport: &TransportConfig) -> anyhow::Result<Self> {
        let operator = holder_of(transport.secure.as_deref())?;
        Ok(Self {
            transport: Arc::new(OverZenoh::open_and_wait(transport)?),
            operator,
        })
    }

    /// Sends orders over a transport that is there already: in the name of the operator whose folder of the secure profile it
    /// was opened with, in nobody's without one.
    ///
    /// # Errors
    /// Certificates that cannot be read.
    pub fn over(transport: Arc<dyn Transport>, secure: Option<&Path>) -> anyhow::Result<Self> {
        Ok(Self {
            operator: holder_of(secure)?,
            transport,
        })
    }

    /// The same in this name, which nobody proves.
    #[cfg(test)]
    pub(crate) fn named(transport: Arc<dyn Transport>, operator: NodeName) -> Self {
        Self {
            transport,
            operator: Some(operator),
        }
    }

    /// Sends an order and waits for the node's answer.
    ///
    /// # Errors
    /// The node does not turn up within five seconds, or does not answer within three; says which
    /// node was asked and where it was looked for.
    pub fn send(&self, node: &NodeName, order: &CommandOrder) -> anyhow::Result<CommandAnswer> {
        let key = match &self.operator {
            Some(operator) => node.operator_command_key(operator),
            None => node.command_key(),
        };
        let client = self.transport.client(&key, ANSWER)?;
        let place = format!("asked under {key}, {}", self.transport.whereabouts());
        if !is_there(&*client) {
            let others = self.others(node);
            bail!("node {node} takes no orders: it is not there after {SEARCH}, {place}{others}");
        }
        let Some(payload) = client.request(order.to_json())? else {
            bail!(
                "node {node} did not answer, so it may or may not have the command after all; {place}"
            );
        };
        CommandAnswer::from_json(&payload).map_err(|error| {
            let text = String::from_utf8_lossy(&payload);
            anyhow!("node {node} answered {text:?}, which is no answer: {error}; {place}")
        })
    }

    /// Who is there instead of a node, or why nobody is; empty if neither can be told.
    fn others(&self, node: &NodeName) -> String {
        // In a secure network an operator may not look around.
        let names = match &self.operator {
            Some(_) => Vec::new(),
            None => self.nodes(),
        };
        if names.is_empty() {
            let why = self.transport.why_unseen(node.as_str());
            return why.map_or_else(String::new, |why| format!("; {}", why.reason()));
        }
        let names: Vec<_> = names.iter().map(NodeName::as_str).collect();
        let meant = did_you_mean(node.as_str(), names.iter().copied());
        format!("; there are {}{meant}", names.join(", "))
    }

    /// The nodes that are there.
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

/// Whose a folder of the secure profile is.
fn holder_of(secure: Option<&Path>) -> Result<Option<NodeName>, BadCredentials> {
    let credentials = secure.map(Credentials::open).transpose()?;
    Ok(credentials.map(|found| found.name().clone()))
}

fn is_there(client: &dyn Client) -> bool {
    let end = machine::now() + SEARCH;
    loop {
        if client.has_server() {
            return true;
        }
        if machine::now() >= end {
            return false;
        }
        std::thread::park_timeout(LOOK);
    }
}
