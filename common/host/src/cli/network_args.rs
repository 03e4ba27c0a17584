//! Endpoints for finding running nodes.

use std::path::{Path, PathBuf};

use clap::Args;
use coaxle_node::config::{
    ConfigError, TransportConfig, TransportMode, Wrong, from_table, parse_table,
};
use coaxle_node::keys::NodeName;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};

use crate::client::Watcher;
use crate::network::credentials::known_nodes;
use crate::network::transport::endpoint;

/// Endpoints on which the examples' nodes listen.
// Zenoh's own port and the next: a sender and a receiver on one machine need one each.
const DEFAULT: [&str; 2] = ["tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448"];

/// Network options of a command that reaches running nodes.
#[derive(Clone, Debug, Default, Args)]
pub struct NetworkArgs {
    /// Look for nodes here, such as tcp/192.168.1.10:7448; may be given several times [default:
    /// this machine, ports 7447 and 7448]
    #[arg(long, global = true, value_name = "ENDPOINT", value_parser = endpoint)]
    pub connect: Vec<String>,
    /// Look for nodes at the endpoints in this config file of one of them: those it listens on and
    /// those it connects to
    #[arg(long, global = true, value_name = "FILE", conflicts_with = "connect")]
    pub config: Option<PathBuf>,
    /// The operator's folder of the secure profile, as written by `coaxle secure init`: its
    /// endpoints are used to find nodes, and orders carry the operator's name
    #[arg(long, global = true, value_name = "DIR")]
    pub secure: Option<PathBuf>,
}

impl NetworkArgs {
    /// Returns the transport for finding nodes; with an operator's folder of the secure profile,
    /// the endpoints of its config.
    ///
    /// # Errors
    /// A config file that cannot be read, or whose transport section is wrong.
    pub fn transport(&self) -> Result<TransportConfig, ConfigError> {
        let Self {
            connect,
            config,
            secure,
        } = self;
        let mut transport = match config {
            Some(file) => of_config(file)?,
            None => TransportConfig {
                // Endpoints of the command line are for plain networks. A secure profile has its own in its Zenoh config.
                connect: connect.clone(),
                ..TransportConfig::default()
            },
        };
        // A node's folder would sign an order with the name of the node, and access control knows operators only.
        if let (Some(file), Some(_), None) = (config, &transport.secure, secure) {
            let file = file.display().to_string();
            let received = "the folder of the node alone";
            let expected = "--secure with that of an operator besides";
            return Err(Wrong::of("transport.secure", received, expected).in_file(&file));
        }
        // The folder of the command line replaces that of the node's config, whose rights do not include commands.
        transport.secure.clone_from(secure);
        // A config without any endpoint says that its node is reached by nothing: the default would find another one.
        if transport.connect.is_empty() && config.is_none() && secure.is_none() {
            transport.connect = DEFAULT.map(str::to_owned).to_vec();
        }
        Ok(transport)
    }
}

impl NetworkArgs {
    /// Watches these nodes; where access control permits, all nodes, so that those present can be
    /// listed if one is missing.
    ///
    /// # Errors
    /// A wrong network section, or a network that cannot be joined.
    pub fn watch(&self, nodes: &[NodeName]) -> anyhow::Result<Watcher> {
        let transport = self.transport()?;
        let known = match (&self.secure, nodes) {
            // Without a profile nothing forbids the wildcard key, so that all nodes are watched.
            (None, _) => Vec::new(),
            // Access control answers a wildcard subscription with silence: each known node is named instead.
            (Some(folder), []) => known_nodes(folder)?,
            (Some(_), nodes) => nodes.to_vec(),
        };
        Watcher::open(&transport, &known)
    }
}

/// The transport section of a node's config, changed for a client that connects to that node.
fn of_config(file: &Path) -> Result<TransportConfig, ConfigError> {
    let name = file.display().to_string();
    let text = text_file::read(file, MOST_CONFIG_BYTES)?;
    let mut config = parse_table(&name, &text)?;
    let mut section = toml::Table::new();
    // The other sections belong to a kind of node that is not known here: only this one is parsed.
    section.extend(config.remove_entry("transport"));
    let read = from_table::<Section>(&name, section);
    let mut transport = read.map_err(|error| error.in_text(&name, &text))?.transport;
    transport.relative_to(file.parent().unwrap_or(Path::new("")));
    // The client listens nowhere: the ports of the node are in use by the node itself.
    let listens = std::mem::take(&mut transport.listen);
    // A node in client mode listens nowhere: its router, under `connect`, is the way to it.
    if transport.mode == TransportMode::Peer {
        transport
            .connect
            .extend(listens.iter().map(|at| reachable(at)));
    }
    Ok(transport)
}

#[derive(serde::Deserialize, schemars::JsonSchema)]
struct Section {
    #[serde(default)]
    transport: TransportConfig,
}

/// The endpoint of a node that listens on all addresses of this machine.
fn reachable(endpoint: &str) -> String {
    endpoint
        // An unspecified address is for listening only. On the node's own machine the loopback address reaches it.
        .replacen("/0.0.0.0:", "/127.0.0.1:", 1)
        .replacen("/[::]:", "/[::1]:", 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looked(
        connect: &[String],
        config: Option<&Path>,
        secure: Option<&Path>,
    ) -> Result<TransportConfig, ConfigError> {
        let args = NetworkArgs {
            connect: connect.to_vec(),
            config: config.map(Path::to_owned),
            secure: secure.map(Path::to_owned),
        };
        args.transport()
    }

    #[test]
    fn a_nodes_config_says_where_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("saw.toml");
        let text = "name = 'saw'\n[transport]\nconnect = ['tcp/10.0.0.1:7447']\n\
                    secure = 'saw'\nlisten = ['tcp/0.0.0.0:7448', 'tcp/[::]:7448', 'tcp/10.0.0.2:1']\n[slave]\n";
        // Both unspecified addresses, one of another machine, and an endpoint that the node itself connects to.
        std::fs::write(&file, text).unwrap();
        let error = looked(&[], Some(&file), None).unwrap_err().to_string();
        assert!(error.contains("expected --secure"), "{error}");
        let anna = folder.path().join("anna");
        let found = looked(&[], Some(&file), Some(&anna)).unwrap();
        assert_eq!(
            found.connect,
            [
                "tcp/10.0.0.1:7447",
                "tcp/127.0.0.1:7448",
                "tcp/[::1]:7448",
                "tcp/10.0.0.2:1"
            ]
        );
        assert!(found.listen.is_empty());
        assert_eq!(found.secure, Some(anna), "and not the node's");

        std::fs::write(&file, "[transport]\nmode = 'star'").unwrap();
        let error = looked(&[], Some(&file), None).unwrap_err().to_string();
        // Line 2, column 8: the value after `mode = `.
        assert!(error.contains("saw.toml:2:8: transport.mode"), "{error}");
    }

    #[test]
    fn endpoints_are_taken_as_they_are() {
        let given = ["tcp/10.0.0.1:1".to_owned()];
        assert_eq!(looked(&given, None, None).unwrap().connect, given);
        assert_eq!(looked(&[], None, None).unwrap().connect, DEFAULT);
        let secure = looked(&[], None, Some(Path::new("anna"))).unwrap();
        assert!(secure.connect.is_empty(), "the profile knows where");
    }
}
