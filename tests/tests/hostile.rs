//! Hostile input to the transport section of a config, up to Zenoh's own config. Every other target is free of Zenoh:
//! `tests/hostile`.

use coaxle_host::network::transport::zenoh_config;
use coaxle_node::config::{TransportConfig, parse};
use coaxle_node::one_line;
use coaxle_test_hostile::trial::{corpus_outcomes, mutations};
use coaxle_test_hostile::{Kind, Outcome, Target};

/// The transport section of a config, as far as Zenoh takes it without a network.
static TRANSPORT: Target = Target {
    name: "transport",
    kind: Kind::Text,
    run: transport,
    seeds: good_sections,
};

/// Mutations in the ordinary tests: as of every other text.
const CASES: usize = 3_000;

fn transport(data: &[u8]) -> Outcome {
    let text = std::str::from_utf8(data).map_err(|_| "no UTF-8 text".to_owned())?;
    let config: TransportConfig = parse("node.toml", text).map_err(|error| error.to_string())?;
    zenoh_config(&config)
        .map(drop)
        .map_err(|error| one_line(&format!("{error:#}")))
}

fn good_sections() -> Vec<(String, Vec<u8>)> {
    let named = |(name, text): (&str, &str)| (name.to_owned(), text.as_bytes().to_vec());
    [
        ("peer", "listen = ['tcp/0.0.0.0:7447']\nconnect = ['tcp/192.168.1.10:7447', 'udp/[::1]:7448']\n"),
        ("client", "mode = 'client'\nconnect = ['tls/router.example:7447']\n"),
        (
            "settings",
            "multicast = true\n[settings]\n'scouting/timeout' = 3000\n'transport/link/tx/queue/size/real_time' = 8\n",
        ),
    ]
    .map(named)
    .into()
}

#[test]
fn what_is_shipped_is_taken() {
    for (name, data) in good_sections() {
        let outcome = TRANSPORT.examine(&data);
        assert!(outcome.is_ok(), "{name}: {outcome:?}");
    }
}

#[test]
fn the_stored_corpus_holds() {
    insta::assert_snapshot!(corpus_outcomes(&TRANSPORT));
}

#[test]
fn transports() {
    mutations(&TRANSPORT, CASES, 1);
}
