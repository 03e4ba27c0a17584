//! Where the node is looked for.

use std::path::Path;

use coaxle_node::config::{ConfigError, TransportConfig, TransportMode, from_table, load};

/// Where the examples' nodes listen.
const DEFAULT: [&str; 2] = ["tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448"];

/// The transport to look for a node with.
///
/// # Errors
/// A config file that cannot be read, or whose transport section is wrong.
pub(super) fn transport(
    connect: &[String],
    config: Option<&Path>,
) -> Result<TransportConfig, ConfigError> {
    if let Some(file) = config {
        return of_config(file);
    }
    let connect = match connect {
        [] => DEFAULT.map(str::to_owned).to_vec(),
        given => given.to_vec(),
    };
    Ok(TransportConfig {
        connect,
        ..TransportConfig::default()
    })
}

/// The transport section of a node's config, for somebody who wants to reach that node.
fn of_config(file: &Path) -> Result<TransportConfig, ConfigError> {
    let mut config: toml::Table = load(file)?;
    let mut section = toml::Table::new();
    section.extend(config.remove_entry("transport"));
    let name = file.display().to_string();
    let mut transport = from_table::<Section>(&name, section)?.transport;
    if let Some(zenoh) = &mut transport.file {
        *zenoh = file.parent().unwrap_or(Path::new("")).join(&*zenoh);
    }
    let listens = std::mem::take(&mut transport.listen);
    if transport.mode == TransportMode::Peer {
        transport
            .connect
            .extend(listens.iter().map(|at| reachable(at)));
    }
    Ok(transport)
}

#[derive(serde::Deserialize)]
struct Section {
    #[serde(default)]
    transport: TransportConfig,
}

/// The endpoint of a node that listens on all addresses of this machine.
fn reachable(endpoint: &str) -> String {
    endpoint
        .replacen("/0.0.0.0:", "/127.0.0.1:", 1)
        .replacen("/[::]:", "/[::1]:", 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nodes_config_says_where_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("saw.toml");
        let text = "name = 'saw'\n[transport]\nconnect = ['tcp/10.0.0.1:7447']\n\
                    listen = ['tcp/0.0.0.0:7448', 'tcp/[::]:7448', 'tcp/10.0.0.2:1']\n[slave]\n";
        std::fs::write(&file, text).unwrap();
        let found = transport(&[], Some(&file)).unwrap();
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

        std::fs::write(&file, "[transport]\nmode = 'star'").unwrap();
        let error = transport(&[], Some(&file)).unwrap_err().to_string();
        assert!(error.contains("saw.toml: transport.mode"), "{error}");
    }

    #[test]
    fn endpoints_are_taken_as_they_are() {
        let given = ["tcp/10.0.0.1:1".to_owned()];
        assert_eq!(transport(&given, None).unwrap().connect, given);
        assert_eq!(transport(&[], None).unwrap().connect, DEFAULT);
    }
}
