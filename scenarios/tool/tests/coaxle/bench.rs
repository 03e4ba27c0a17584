//! `coaxle bench` as a user starts it: that everything is measured, never how fast anything is.

use std::process::{Command, Output};

use crate::shared::text;
use serde_json::Value;

fn bench(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle"));
    command.arg("bench").args(words);
    command.output().expect("the tool can be started")
}

fn is_a_time(value: &Value) -> bool {
    let time = |name: &str| value[name].as_f64().unwrap_or(f64::NAN);
    let (usual, rare, worst) = (time("p50_us"), time("p99_us"), time("max_us"));
    value["count"].as_u64() > Some(0) && usual <= rare && rare <= worst
}

#[test]
fn every_part_has_its_figures() {
    let output = bench(&["--for", "600ms", "--rounds", "1", "--format", "json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let (wake_up, way, load) = (&found["wake_up"], &found["end_to_end"], &found["load"]);
    for time in [
        &wake_up["node"],
        &wake_up["bare"],
        &way["udp"],
        &way["zenoh"],
        &way["nodes"],
        &way["zenoh_network"],
        &way["stages"]["scan"],
        &way["stages"]["hand_over"],
        &way["stages"]["network"],
        &way["stages"]["wait"],
        &way["stages"]["to_scan"],
    ] {
        assert!(is_a_time(time), "{time} in {found:#}");
    }
    for ratio in [
        &wake_up["node_over_bare"],
        &way["ratios"]["nodes"],
        &way["ratios"]["network"],
    ] {
        assert!(ratio["p50"].as_f64() > Some(0.0), "{ratio} in {found:#}");
    }
    assert_eq!(load["axes"], 100);
    assert!(load["bytes"].as_u64() > way["bytes"].as_u64(), "{found:#}");
    assert_eq!(found["transports"], Value::Null, "only if it is asked for");
}

#[test]
fn transports_have_a_row_each_and_say_what_was_not_lost() {
    let words = [
        "transports",
        "--for",
        "500ms",
        "--rounds",
        "1",
        "--loss",
        "0",
    ];
    let output = bench(&words);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for transport in ["datagrams", "TCP", "UDP", "QUIC stream", "Unix socket"] {
        assert!(said.contains(transport), "{said}");
    }
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_line() {
    for (words, expected) in [
        (["--loss", "90"], "expected a percentage from 0 to 50"),
        (["--axes", "0"], "0 is not in 1..=128"),
        (["--cycle-us", "1"], "received 1"),
        (["--for", "0s"], "expected a duration"),
    ] {
        let output = bench(&words);
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(text(&output.stderr).contains(expected), "{words:?}");
    }
}
