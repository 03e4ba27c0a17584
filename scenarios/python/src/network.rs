//! A session in the network, by which nodes are watched, commanded and followed, and axes are published.

use std::path::PathBuf;
use std::sync::Arc;

use coaxle_host::client::{Commander, Watcher};
use coaxle_host::network::transport::{OverZenoh, Transport};
use coaxle_node::CommandOrder;
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use pyo3::prelude::*;
use serde_json::{Map, Value};

use crate::clock::{cycle_time, span};
use crate::error::{told, wrong};
use crate::follow::Follower;
use crate::publish::Publisher;

/// A session over Zenoh.
#[pyclass(module = "coaxle")]
pub(crate) struct Network {
    transport: Arc<dyn Transport>,
    commander: Commander,
    watcher: Watcher,
}

#[pymethods]
impl Network {
    /// Joins the network; with an operator's folder of the secure profile, in that operator's name.
    #[new]
    #[pyo3(signature = (*, connect, listen, secure))]
    fn new(
        py: Python<'_>,
        connect: Vec<String>,
        listen: Vec<String>,
        secure: Option<PathBuf>,
    ) -> PyResult<Self> {
        let config = TransportConfig {
            connect,
            listen,
            secure,
            ..TransportConfig::default()
        };
        // Joining waits for the network, half a second and more.
        py.detach(|| Self::join(&config)).map_err(told)
    }

    /// The status of every node that is seen within this time: JSON by the node's name.
    fn nodes(&self, py: Python<'_>, within_s: f64) -> PyResult<String> {
        let patience = span("within_s", within_s)?;
        // Never satisfied: all nodes that are seen within the time are wanted, not the first.
        let seen = py.detach(|| self.watcher.wait_for(patience, |_| false));
        let status = |node: coaxle_host::client::SeenNode| {
            let status = node.status.map(|(_, status)| Value::Object(status));
            (node.name.to_string(), status.unwrap_or_default())
        };
        let all: Map<_, _> = seen.into_iter().map(status).collect();
        serde_json::to_string(&all).map_err(told)
    }

    /// The newest status of a node, JSON; none if it publishes none within this time.
    fn status(&self, py: Python<'_>, node: &str, within_s: f64) -> PyResult<Option<String>> {
        let (name, patience) = (name("node", node)?, span("within_s", within_s)?);
        let of = |seen: &[coaxle_host::client::SeenNode]| {
            let node = seen.iter().find(|node| node.name == name);
            node.and_then(|node| node.status.clone())
        };
        let seen = py.detach(|| self.watcher.wait_for(patience, |seen| of(seen).is_some()));
        let status = of(&seen).map(|(_, status)| serde_json::to_string(&status));
        status.transpose().map_err(told)
    }

    /// Sends an order, JSON as in docs/WIRE.md, to a node. Returns its response, JSON.
    fn send(&self, py: Python<'_>, node: &str, order: &str) -> PyResult<String> {
        let node = name("node", node)?;
        let order =
            CommandOrder::from_json(order.as_bytes()).map_err(|bad| wrong(bad.to_string()))?;
        let answer = py.detach(|| self.commander.send(&node, &order));
        let answer = answer.map_err(told)?;
        Ok(answer.to_json())
    }

    /// A node of this name whose axes have these ids.
    fn publish(
        &self,
        py: Python<'_>,
        node: &str,
        cycle_time_s: f64,
        axes: Vec<u32>,
    ) -> PyResult<Publisher> {
        let (node, cycle_time) = (name("node", node)?, cycle_time(cycle_time_s)?);
        py.detach(|| Publisher::open(&self.transport, node, cycle_time, &axes))
    }

    /// Follows axes of a node, in the clock of this machine. `name` is the requester in time requests.
    fn follow(&self, py: Python<'_>, node: &str, axes: Vec<u32>, own: &str) -> PyResult<Follower> {
        let (node, own) = (name("node", node)?, name("name", own)?);
        py.detach(|| Follower::open(&self.transport, &node, &own, axes))
    }

    /// Leaves the network.
    fn close(&self, py: Python<'_>) {
        py.detach(|| self.transport.close());
    }
}

impl Network {
    fn join(config: &TransportConfig) -> anyhow::Result<Self> {
        let transport: Arc<dyn Transport> = Arc::new(OverZenoh::open_and_wait(config)?);
        Ok(Self {
            watcher: Watcher::over(Arc::clone(&transport), &[])?,
            commander: Commander::over(Arc::clone(&transport), config.secure.as_deref())?,
            transport,
        })
    }
}

fn name(field: &str, text: &str) -> PyResult<NodeName> {
    NodeName::new(text).map_err(|error| wrong(format!("{field}: {error}")))
}
