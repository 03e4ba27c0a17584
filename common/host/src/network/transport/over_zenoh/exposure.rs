//! Access that a transport section gives to others.

use coaxle_node::config::TransportConfig;
use serde_json::Value;
use zenoh::Config;

use super::config::zenoh_config;
use super::endpoint::is_local;

/// Reachability of a node, and its access restrictions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exposure {
    /// Endpoints beyond this machine that it listens on.
    pub listens: Vec<String>,
    /// Endpoints beyond this machine that it connects to.
    pub connects: Vec<String>,
    /// True if it discovers others by multicast.
    pub multicast: bool,
    /// True if endpoints with TLS require a certificate of the authority.
    pub mutual_tls: bool,
    /// True if access control denies by default.
    pub denies_by_default: bool,
    /// Greatest size of a message that is assembled before any check, bytes.
    pub max_message_size: u64,
}

impl Exposure {
    /// Determines it from the Zenoh config of a transport section.
    ///
    /// # Errors
    /// A wrong transport section.
    pub fn of(transport: &TransportConfig) -> anyhow::Result<Self> {
        let config = zenoh_config(transport)?;
        let is_on = |path: &str| setting(&config, path) == Value::Bool(true);
        Ok(Self {
            listens: beyond_this_machine(endpoints(&config, "listen")),
            connects: beyond_this_machine(endpoints(&config, "connect")),
            multicast: is_on("scouting/multicast/enabled"),
            mutual_tls: is_on("transport/link/tls/enable_mtls"),
            denies_by_default: is_on("access_control/enabled")
                && setting(&config, "access_control/default_permission") == "deny",
            // Zenoh's default of 1 GiB is in its config. An absent setting therefore means no bound.
            max_message_size: setting(&config, "transport/link/rx/max_message_size")
                .as_u64()
                .unwrap_or(u64::MAX),
        })
    }

    /// Endpoints among these that are open to anybody: without TLS, or without a required client
    /// certificate.
    #[must_use]
    pub fn without_mutual_tls<'a>(&self, endpoints: &'a [String]) -> Vec<&'a str> {
        let is_open = |endpoint: &&str| {
            // TLS without a required client certificate encrypts, but lets anybody in.
            let has_tls = endpoint.starts_with("tls/") || endpoint.starts_with("quic/");
            !(has_tls && self.mutual_tls)
        };
        endpoints
            .iter()
            .map(String::as_str)
            .filter(is_open)
            .collect()
    }
}

fn beyond_this_machine(mut endpoints: Vec<String>) -> Vec<String> {
    endpoints.retain(|endpoint| !is_local(endpoint));
    endpoints
}

/// The endpoints of a section, which may be given per mode.
pub(super) fn endpoints(config: &Config, section: &str) -> Vec<String> {
    let found = setting(config, &format!("{section}/endpoints"));
    let mode = setting(config, "mode");
    // Zenoh's defaults are objects per mode, endpoints of ours are plain lists.
    let of_mode = mode.as_str().and_then(|mode| found.get(mode));
    let endpoints = of_mode.unwrap_or(&found).as_array();
    let texts = endpoints.into_iter().flatten().filter_map(Value::as_str);
    texts.map(str::to_owned).collect()
}

fn setting(config: &Config, path: &str) -> Value {
    let json = config.get_json(path).ok();
    json.and_then(|json| serde_json::from_str(&json).ok())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn exposure(toml: &str) -> Exposure {
        Exposure::of(&parse("test.toml", toml).unwrap()).unwrap()
    }

    #[test]
    fn what_stays_on_this_machine_is_not_open() {
        let found = exposure("listen = ['tcp/127.0.0.1:7447']\nconnect = ['tcp/localhost:7448']");
        assert!(found.listens.is_empty() && found.connects.is_empty());
        assert!(!found.multicast && !found.denies_by_default && !found.mutual_tls);
        // Zenoh's own default.
        assert_eq!(found.max_message_size, 1 << 30);
    }

    #[test]
    fn what_goes_beyond_is_named() {
        let found = exposure(
            "listen = ['tcp/0.0.0.0:7447', 'tls/0.0.0.0:7448', 'tcp/127.0.0.1:1']\nmulticast = true",
        );
        assert_eq!(found.listens, ["tcp/0.0.0.0:7447", "tls/0.0.0.0:7448"]);
        assert!(found.multicast);
        let anywhere = exposure("multicast = true").listens;
        assert_eq!(anywhere, ["tcp/[::]:0"], "Zenoh's own default for peers");
        let open = found.without_mutual_tls(&found.listens);
        assert_eq!(open, found.listens, "TLS that asks nobody is open, too");
        let found = exposure(
            "listen = ['tcp/0.0.0.0:7447', 'tls/0.0.0.0:7448']\n\
             settings = { 'transport/link/tls/enable_mtls' = true }",
        );
        assert_eq!(
            found.without_mutual_tls(&found.listens),
            ["tcp/0.0.0.0:7447"]
        );
    }

    #[test]
    fn access_control_counts_if_it_denies_what_it_does_not_allow() {
        let with = |permission: &str| {
            exposure(&format!(
                "settings = {{ access_control = {{ enabled = true, default_permission = {permission:?}, \
                 rules = [], subjects = [], policies = [] }} }}"
            ))
        };
        // Both grant the same by their rules: only the default for everything else differs.
        assert!(with("deny").denies_by_default);
        assert!(!with("allow").denies_by_default);
    }
}
