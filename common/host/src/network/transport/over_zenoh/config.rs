//! From [`TransportConfig`] to a Zenoh config.

use anyhow::Context;
use coaxle_node::config::{TransportConfig, TransportMode};
use zenoh::Config;

use super::endpoint::{check_endpoint, check_secure_endpoint};
use super::secure;
use super::settings::{from_file, insert, unless_set};

/// Zenoh's thread settings: the environment variable it reads before its first call, and the value
/// that suits a node.
///
/// One thread to receive and one to send instead of six: a quarter less latency, a third less
/// processor time. [`crate::cli::run_program`] sets it for the calling program; a program that
/// starts nodes as processes can put it into their environment.
pub const ZENOH_RUNTIME: (&str, &str) = (
    "ZENOH_RUNTIME",
    // Receiver, acceptor and network share the thread of `app`: latency −26 %, processor time −33 %.
    "(rx:(handover:app),acc:(handover:app),net:(handover:app),app:(worker_threads:1),tx:(worker_threads:1))",
);

/// Settings used wherever a config file leaves Zenoh's own default in place.
const DEFAULTS: [(&str, &str); 5] = [
    // No discovery by multicast.
    ("scouting/multicast/enabled", "false"),
    // Nodes may start in any order and should connect soon.
    (
        "connect/retry",
        // Zenoh's own are 1 s and 4 s.
        "{ period_init_ms: 250, period_max_ms: 1000, period_increase_factor: 2 }",
    ),
    // A port in use or an address of another machine ends the node at once.
    ("listen/exit_on_failure", "true"),
    // Frames that wait for the network: as many as the queue of this priority may hold.
    // At 1 kHz 16 frames bridge 16 ms of a stalled link. Zenoh's own default is two.
    ("transport/link/tx/queue/size/real_time", "16"),
    // Never on: `put` would then write to the socket itself and wait for it.
    // A stopped receiver blocked `put` for 2.7 s with it.
    ("transport/unicast/lowlatency", "false"),
];

/// Builds the Zenoh config from, in this order, the file or the secure profile, the defaults for a
/// node, the transport section, and its settings by path.
///
/// # Errors
/// Names the wrong file, endpoint or setting, and its value.
pub fn zenoh_config(transport: &TransportConfig) -> anyhow::Result<Config> {
    let mut config = match (&transport.secure, &transport.file) {
        // The profile comes before everything: `check_section` refuses a file beside it.
        (Some(folder), _) => {
            secure::check_section(transport)?;
            secure::profile(folder)?
        }
        (None, Some(file)) => from_file(file)?,
        (None, None) => Config::default(),
    };
    // Only where nothing else was said: an operator's Zenoh file keeps its own values.
    for (path, json) in DEFAULTS {
        unless_set(&mut config, path, json)?;
    }
    let mode = match transport.mode {
        TransportMode::Peer => "\"peer\"",
        TransportMode::Client => "\"client\"",
    };
    match transport.mode {
        // Peer is the section's default and does not override a file with client mode.
        TransportMode::Peer => unless_set(&mut config, "mode", mode)?,
        TransportMode::Client => insert(&mut config, "mode", mode)?,
    }
    if transport.multicast {
        insert(&mut config, "scouting/multicast/enabled", "true")?;
    }
    let is_secure = transport.secure.is_some();
    endpoints(&mut config, "listen", &transport.listen, is_secure)?;
    endpoints(&mut config, "connect", &transport.connect, is_secure)?;
    if transport.listen.is_empty() && !transport.multicast {
        // Otherwise Zenoh would listen on a random port of all interfaces.
        unless_set(&mut config, "listen/endpoints", "[]")?;
    }
    // Last, so that a setting by path overrides all else.
    for (path, value) in &transport.settings {
        let json = serde_json::to_string(value)
            .with_context(|| format!("the Zenoh setting \"{path}\" = {value}"))?;
        insert(&mut config, path, &json)?;
    }
    Ok(config)
}

fn endpoints(
    config: &mut Config,
    section: &str,
    endpoints: &[String],
    is_secure: bool,
) -> anyhow::Result<()> {
    if endpoints.is_empty() {
        return Ok(());
    }
    for endpoint in endpoints {
        let checked = match is_secure {
            true => check_secure_endpoint(endpoint),
            false => check_endpoint(endpoint),
        };
        checked.with_context(|| format!("transport.{section}: {endpoint:?}"))?;
    }
    let json = serde_json::to_string(endpoints)?;
    insert(config, &format!("{section}/endpoints"), &json)
}

/// The endpoints of a transport section, for messages.
pub(super) fn described(transport: &TransportConfig) -> String {
    let mut parts = Vec::new();
    if !transport.listen.is_empty() {
        parts.push(format!("listening on {}", transport.listen.join(", ")));
    }
    if !transport.connect.is_empty() {
        parts.push(format!("connecting to {}", transport.connect.join(", ")));
    }
    if transport.multicast {
        parts.push("looking for peers by multicast".to_owned());
    }
    if let Some(folder) = &transport.secure {
        parts.push(format!("with the certificates in {}", folder.display()));
    }
    if let Some(file) = &transport.file {
        parts.push(format!("with the Zenoh config file {}", file.display()));
    }
    // A message without any place would leave the reader to guess.
    if parts.is_empty() {
        parts.push("without any endpoint to listen on or to connect to".to_owned());
    }
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::config::parse;

    fn built(toml: &str) -> anyhow::Result<Config> {
        zenoh_config(&parse("test.toml", toml).unwrap())
    }

    fn setting(config: &Config, path: &str) -> serde_json::Value {
        serde_json::from_str(&config.get_json(path).unwrap()).unwrap()
    }

    fn refusal(toml: &str) -> String {
        format!("{:#}", built(toml).unwrap_err())
    }

    #[test]
    fn the_default_finds_nothing_by_chance_and_listens_nowhere() {
        let config = built("").unwrap();
        assert_eq!(setting(&config, "scouting/multicast/enabled"), false);
        assert_eq!(setting(&config, "listen/endpoints"), serde_json::json!([]));
        assert_eq!(
            setting(&config, "transport/link/tx/queue/size/real_time"),
            16
        );
        // Four times sooner than Zenoh's second.
        assert_eq!(setting(&config, "connect/retry")["period_init_ms"], 250);
    }

    #[test]
    fn endpoints_mode_and_settings_reach_zenoh() {
        let config = built(
            r#"
            mode = "client"
            connect = ["tcp/192.168.1.10:7447"]
            multicast = true
            settings = { "transport/link/tx/lease" = 1000, "connect/timeout_ms" = { peer = 5 } }
            "#,
        )
        .unwrap();
        assert_eq!(setting(&config, "mode"), "client");
        assert_eq!(
            setting(&config, "connect/endpoints"),
            serde_json::json!(["tcp/192.168.1.10:7447"])
        );
        assert_eq!(setting(&config, "scouting/multicast/enabled"), true);
        assert_eq!(setting(&config, "transport/link/tx/lease"), 1000);
        assert_eq!(setting(&config, "connect/timeout_ms")["peer"], 5);
    }

    #[test]
    fn what_a_file_says_holds_unless_the_section_says_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("zenoh.json5");
        std::fs::write(
            &file,
            r#"{ mode: "client",
                 connect: { endpoints: ["tcp/10.0.0.1:7447"] },
                 transport: { link: { tx: { queue: { size: { real_time: 4 } } } } } }"#,
        )
        .unwrap();
        let mut transport = TransportConfig {
            file: Some(file),
            ..TransportConfig::default()
        };
        let config = zenoh_config(&transport).unwrap();
        assert_eq!(setting(&config, "mode"), "client");
        assert_eq!(
            setting(&config, "connect/endpoints")[0],
            "tcp/10.0.0.1:7447"
        );
        assert_eq!(
            setting(&config, "transport/link/tx/queue/size/real_time"),
            4
        );
        assert_eq!(setting(&config, "scouting/multicast/enabled"), false);

        transport.connect = vec!["tcp/10.0.0.2:7447".to_owned()];
        let config = zenoh_config(&transport).unwrap();
        assert_eq!(
            setting(&config, "connect/endpoints")[0],
            "tcp/10.0.0.2:7447"
        );
    }

    #[test]
    fn a_wrong_setting_is_named_with_its_value() {
        assert_eq!(
            refusal(r#"settings = { "transport/link/tx/leese" = 1000 }"#),
            "the Zenoh setting \"transport/link/tx/leese\" = 1000 is refused: unknown key"
        );
        let mistyped = refusal(r#"settings = { "transport/link/tx/lease" = "soon" }"#);
        let named = "the Zenoh setting \"transport/link/tx/lease\" = \"soon\" is refused: ";
        assert!(mistyped.starts_with(named), "{mistyped}");
    }

    #[test]
    fn a_wrong_endpoint_is_named_with_what_is_expected() {
        for (endpoint, expected) in [
            ("192.168.1.10:7447", "expected <protocol>/<address>"),
            ("tpc/192.168.1.10:7447", "expected one of tcp, udp, tls"),
            ("tcp/192.168.1.10", "has no port"),
            ("tcp/:7447", "has no host"),
            ("tcp/192.168.1.10:74470", "received the port \"74470\""),
            ("udp/", "has no address"),
        ] {
            let message = refusal(&format!("connect = [{endpoint:?}]"));
            assert!(message.contains("transport.connect"), "{message}");
            assert!(message.contains(endpoint), "{message}");
            assert!(message.contains(expected), "{message}");
        }
        for endpoint in [
            // Unusual, but right: port 0, an interface, a path without a port.
            "tcp/[::]:0",
            "quic/host.example:7447#iface=eth0",
            "unixsock-stream/a.sock",
        ] {
            built(&format!("listen = [{endpoint:?}]")).unwrap();
        }
    }

    #[test]
    fn a_missing_or_broken_file_is_named() {
        let message = refusal("file = \"nowhere.json5\"");
        assert!(message.contains("nowhere.json5"), "{message}");
    }
}
