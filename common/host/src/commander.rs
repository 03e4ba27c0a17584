//! Commanding nodes from outside: the asker's side.

use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use coaxle_clock::Span;
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use coaxle_node::{CommandAnswer, CommandOrder};
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::query::Querier;

use crate::link::described;
use crate::machine;
use crate::transport::{zenoh_config, zenoh_error};

/// How long a node may take to turn up.
const SEARCH: Span = Span::from_secs(5);
/// Nodes answer within a second, and the network is slow for once.
const ANSWER: Duration = Duration::from_secs(3);
/// How often it looks whether the node is there.
const LOOK: Duration = Duration::from_millis(10);

/// A session to send orders through. Its calls wait for what they ask for.
pub struct Commander {
    session: zenoh::Session,
    /// Where it looks for nodes, for messages.
    whereabouts: String,
}

impl Commander {
    /// Joins the network.
    ///
    /// # Errors
    /// A wrong transport section, or a session that cannot be opened, with the endpoints.
    pub fn open(transport: &TransportConfig) -> anyhow::Result<Self> {
        let whereabouts = described(transport);
        let session = zenoh::open(zenoh_config(transport)?)
            .wait()
            .map_err(zenoh_error)
            .with_context(|| format!("cannot open the Zenoh session, {whereabouts}"))?;
        Ok(Self {
            session,
            whereabouts,
        })
    }

    /// Sends an order and waits for the node's answer.
    ///
    /// # Errors
    /// The node does not turn up within five seconds, or does not answer within three; says which
    /// node was asked and where it was looked for.
    pub fn send(&self, node: &NodeName, order: &CommandOrder) -> anyhow::Result<CommandAnswer> {
        let key = node.command_key();
        let querier = self
            .session
            .declare_querier(&key)
            .timeout(ANSWER)
            .wait()
            .map_err(zenoh_error)?;
        let place = format!("asked under {key}, {}", self.whereabouts);
        if !is_there(&querier) {
            bail!("node {node} takes no orders: nobody is there after {SEARCH}, {place}");
        }
        let replies = querier
            .get()
            .payload(order.to_json())
            .encoding(Encoding::APPLICATION_JSON)
            .wait()
            .map_err(zenoh_error)?;
        let Ok(Some(reply)) = replies.recv_timeout(ANSWER) else {
            bail!(
                "node {node} did not answer, so it may or may not have the command after all; {place}"
            );
        };
        let payload = match reply.result() {
            Ok(sample) => sample.payload().to_bytes(),
            Err(error) => error.payload().to_bytes(),
        };
        CommandAnswer::from_json(&payload).map_err(|error| {
            let text = String::from_utf8_lossy(&payload);
            anyhow!("node {node} answered {text:?}, which is no answer: {error}; {place}")
        })
    }

    /// Leaves the network.
    pub fn close(self) {
        if let Err(error) = self.session.close().wait() {
            tracing::debug!(%error, "the Zenoh session did not close cleanly");
        }
    }
}

fn is_there(querier: &Querier<'_>) -> bool {
    let end = machine::now() + SEARCH;
    loop {
        let status = querier.matching_status().wait();
        if status.is_ok_and(|status| status.matching()) {
            return true;
        }
        if machine::now() >= end {
            return false;
        }
        std::thread::park_timeout(LOOK);
    }
}
