//! A receiver that is replayed from its recording.

use std::process::{Command, Output};

use crate::watched::line::{Line, printed};

const SAW: &str = "cycle-time-us = 2000\nmode = 'MODE'\nmaster = { node = 'belt', axis = 3 }\n\
    [[slave]]\nname = 'carriage'\ncouple = 'off'\nlimits = { velocity = 500, acceleration = 5000, jerk = 100000 }\n";

/// Runs the tool without the endpoints of running nodes.
fn coaxle(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command.args(words).output().expect("it runs")
}

#[test]
fn a_receiver_comes_to_the_same_bit_for_bit_and_a_killed_one_too() {
    let mut line = Line::moving(50.0, 120.0);
    let recording = line.folder.path().join("saw.mcap");
    let recording = recording.to_str().expect("UTF-8").to_owned();
    let config = SAW.replace("MODE", "observer");
    line.start_with("receiver", "saw", &config, &["--record", &recording]);
    let waited = line.run_tool(&["wait-sync", "saw", "--timeout", "60s"]);
    assert_eq!(waited.status.code(), Some(0), "{waited:?}");
    for order in [
        &["command", "saw", "carriage", "power", "on"][..],
        &["command", "saw", "carriage", "home", "--position", "3"],
        &["command", "saw", "carriage", "gear-in", "--ratio", "2"],
    ] {
        let answer = line.run_tool(order);
        assert_eq!(answer.status.code(), Some(0), "{answer:?}");
    }
    // Longer than a flush period, so that the orders are on the disk.
    std::thread::park_timeout(std::time::Duration::from_millis(800));
    // Killed, it cannot end its recording.
    line.nodes[1].kill();

    let replayed = coaxle(&["replay", &recording]);
    let said = printed(&replayed);
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    assert!(said.contains("the same bit for bit: "), "{said}");
    assert!(said.contains("the file ends without its summary"), "{said}");
    let moved = printed(&coaxle(&[
        "info",
        &recording.replace(".mcap", "-replayed.mcap"),
    ]));
    assert!(moved.contains("replayed: "), "{moved}");

    // Another mode is another receiver: differences are reported, and are no failure.
    let other = line.folder.path().join("other.toml");
    let config = SAW.replace("MODE", "time");
    std::fs::write(&other, format!("name = 'saw'\n{config}")).expect("a config");
    let other = other.to_str().expect("UTF-8");
    let again = coaxle(&["replay", &recording, "--config", other]);
    let error = String::from_utf8_lossy(&again.stderr).into_owned();
    assert!(
        error.contains("expected a name that is not taken"),
        "{error}"
    );
    let out = recording.replace(".mcap", "-other.mcap");
    let replayed = coaxle(&["replay", &recording, "--config", other, "--out", &out]);
    let said = printed(&replayed);
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    assert!(
        said.contains("rows differ") && said.contains("belt.mode"),
        "{said}"
    );
}

#[test]
fn what_cannot_be_replayed_is_told_with_what_could() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let run = [
        "run",
        "beat",
        "--receivers",
        "sync",
        "--set",
        "duration-s=0.1",
    ];
    let out = path("run");
    let ran = coaxle(&[&run[..], &["--out", &out]].concat());
    assert!(matches!(ran.status.code(), Some(0 | 3)), "{ran:?}");
    let error = |file: &str| {
        let refused = coaxle(&["replay", file]);
        assert_eq!(refused.status.code(), Some(78), "{refused:?}");
        String::from_utf8(refused.stderr).expect("UTF-8")
    };
    let trace = error(&format!("{out}/trace.mcap"));
    assert!(trace.contains("expected one of a receiver"), "{trace}");
    let summary = error(&format!("{out}/summary.json"));
    assert!(
        summary.contains("expected a recording in MCAP"),
        "{summary}"
    );
}
