//! The connection of a node to the others.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The Zenoh session of a node: explicit endpoints, no discovery.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
pub struct TransportConfig {
    /// Peer (the default) or client of a router.
    pub mode: TransportMode,
    /// A folder of the secure profile, as written by `coaxle secure init`: certificates and access
    /// rights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub secure: Option<PathBuf>,
    /// Endpoints to listen on, such as `tcp/127.0.0.1:7447`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub listen: Vec<String>,
    /// Endpoints to connect to, such as `tcp/192.168.1.10:7447`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub connect: Vec<String>,
    /// Look for peers by multicast. Off by default.
    pub multicast: bool,
    /// A Zenoh config file (JSON5) to start from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Any Zenoh setting, by its path: `"transport/link/tx/lease" = 1000`.
    #[serde(skip_serializing_if = "toml::Table::is_empty")]
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub settings: toml::Table,
}

impl TransportConfig {
    /// Resolves the relative paths of its files from `folder`, for example the config's own.
    pub fn relative_to(&mut self, folder: &Path) {
        for path in [&mut self.file, &mut self.secure].into_iter().flatten() {
            *path = folder.join(&*path);
        }
    }
}

/// A node's part in the Zenoh network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TransportMode {
    /// Connects to other peers directly, and to clients through a router. A router never forwards
    /// between two peers: nodes that connect only there must be clients.
    #[default]
    Peer,
    /// Connects through one router only, to all other nodes there.
    Client,
}
