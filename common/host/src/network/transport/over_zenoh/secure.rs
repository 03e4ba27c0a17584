//! The secure profile: a folder with certificates and with the Zenoh config of the access rights.

use std::path::Path;

use anyhow::{Context, bail};
use coaxle_node::config::{TransportConfig, TransportMode};
use zenoh::Config;

use super::settings::{from_file, insert};
use crate::network::credentials::{AUTHORITY_FILE, CERTIFICATE_FILE, KEY_FILE, PROFILE_FILE};

/// Zenoh's settings for each file. The profile itself names none, so that the folder may lie anywhere.
const FILES: [(&str, &str); 5] = [
    ("root_ca_certificate", AUTHORITY_FILE),
    ("listen_certificate", CERTIFICATE_FILE),
    ("listen_private_key", KEY_FILE),
    ("connect_certificate", CERTIFICATE_FILE),
    ("connect_private_key", KEY_FILE),
];

/// Loads the profile with the files of its folder.
pub(super) fn profile(folder: &Path) -> anyhow::Result<Config> {
    let field = || format!("transport.secure: {}", folder.display());
    // Zenoh takes relative paths from the working directory, and reads the files again with each connection.
    let folder = std::path::absolute(folder).with_context(field)?;
    let mut config = from_file(&folder.join(PROFILE_FILE)).with_context(field)?;
    for (setting, file) in FILES {
        // Checked here: Zenoh would name the setting, not the folder that is incomplete.
        let file = folder.join(file);
        if !file.is_file() {
            bail!(
                "{}: {} is not there, expected the folder that `coaxle secure init` wrote",
                field(),
                file.display()
            );
        }
        let json = serde_json::to_string(&file).with_context(field)?;
        insert(&mut config, &format!("transport/link/tls/{setting}"), &json)?;
    }
    Ok(config)
}

/// Refuses settings that would bypass the profile.
pub(super) fn check_section(transport: &TransportConfig) -> anyhow::Result<()> {
    // A second file could switch off what the profile's own one switches on.
    if transport.file.is_some() {
        bail!("transport.file: received one beside transport.secure, expected either of them");
    }
    if transport.multicast {
        bail!(
            "transport.multicast: received true beside transport.secure, expected false: access control \
             does not hold for what comes by multicast"
        );
    }
    // A router in between has a certificate of its own, so that no rule could name the node behind it.
    if transport.mode == TransportMode::Client {
        bail!(
            "transport.mode: received \"client\" beside transport.secure, expected \"peer\": the profile is \
             for nodes that reach each other directly"
        );
    }
    for path in transport.settings.keys() {
        // Each of these alone opens the node: the rules, the certificates, and links without either.
        let is_barrier = [
            "access_control",
            "transport/link/tls",
            "transport/link/protocols",
        ]
        .iter()
        .any(|barrier| path.starts_with(barrier));
        if is_barrier {
            bail!(
                "transport.settings: received {path:?} beside transport.secure, expected it in its \
                 {PROFILE_FILE} alone"
            );
        }
    }
    Ok(())
}
