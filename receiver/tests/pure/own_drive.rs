//! Drives passed to a receiver's slaves by its builder.

#[path = "../../examples/own_drive.rs"]
mod example;

use coaxle_axis::AxisStatus;
use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
use coaxle_clock::Instant;
use coaxle_node::Node;
use coaxle_node::config::parse;
use coaxle_receiver::{DriveKind, DriveState, Drives, Receiver, ReceiverConfig};

#[test]
fn the_example_moves_its_own_drive() {
    let (position, pulses) = example::run(2_000).expect("a valid config");
    assert!((position - 250.0).abs() < 1e-9, "{position}");
    assert_eq!(pulses, 25_000, "250 units in steps of 0.01, and none back");
}

fn config(slave: &str) -> ReceiverConfig {
    let text = format!("name = 'r'\ncycle-time-us = 1000\nmaster = {{ node = 'm' }}\n{slave}");
    parse("r.toml", &text).expect("a config")
}

fn own() -> SimulatedDrive {
    SimulatedDrive::new(DriveParameters::default()).expect("in range")
}

const LIMITS: &str = "limits = { velocity = 100, acceleration = 1000, jerk = 10000 }";
const SHARED: &str =
    "drive = { kind = 'shared-memory', path = 'not-made', following-error-window = 1 }";

#[test]
fn what_does_not_fit_is_named() {
    let limits_off = format!("[[slave]]\nname = 'a'\ncouple = 'off'\n{LIMITS}");
    let shared = format!("{limits_off}\n{SHARED}");
    for (slave, drives, expected) in [
        (
            limits_off.as_str(),
            Drives::new().with("b", own()),
            "drives: received one for \"b\", expected one of: a",
        ),
        (
            &limits_off,
            Drives::new().with("a", own()).with("a", own()),
            "drives: received two for \"a\", expected one",
        ),
        (
            "[[slave]]\nname = 'a'",
            Drives::new().with("a", own()),
            "slave[0].limits: received none, expected some: only a simulated drive says",
        ),
        (
            &format!("[[slave]]\nname = 'a'\n{LIMITS}"),
            Drives::new().with("a", own()),
            "slave[0].couple: received a coupling from the start, expected \"off\"",
        ),
        (
            &format!("[[slave]]\nname = 'a'\n{SHARED}"),
            Drives::simulated(),
            "slave[0].limits: received none",
        ),
        (
            &shared,
            Drives::new(),
            "slave[0].drive: received kind = \"shared-memory\" and no drive for it, expected one that was \
             given for \"a\"",
        ),
    ] {
        let refused = Receiver::with_drives(&config(slave), drives, Instant::EPOCH, 1);
        let error = refused.expect_err("no receiver").to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    // With a drive passed, it starts.
    let given = Drives::new().with("a", own());
    assert!(Receiver::with_drives(&config(&shared), given, Instant::EPOCH, 1).is_ok());
}

/// A simulated drive replaces the process in virtual time, and signals show this.
#[test]
fn a_simulated_drive_stands_in_for_one_in_another_process() {
    let steps = "[[slave.step]]\ndo = { power = true }\n[[slave.step]]\nwhen = { state = 'standstill' }\n\
                 do = { move-absolute = { position = 5 } }\n";
    let config = config(&format!(
        "[[slave]]\nname = 'a'\n{LIMITS}\n{SHARED}\n{steps}"
    ));
    let start = Instant::EPOCH;
    let mut receiver =
        Receiver::with_drives(&config, Drives::simulated(), start, 1).expect("a receiver");
    for _ in 0..1_000 {
        let _ = receiver.cycle(receiver.next_cycle());
    }
    let slave = &receiver.snapshot().signals.slaves[0];
    assert_eq!(slave.drive_kind, DriveKind::Simulated);
    assert_eq!(
        (slave.drive_attached, slave.drive_heartbeat_age),
        (None, None)
    );
    assert_eq!(slave.drive_state, DriveState::Following);
    assert_eq!(slave.state, AxisStatus::Standstill);
    assert!((slave.drive_position - 5.0).abs() < 1e-3);
    // A simulated drive makes no file for a process.
    assert!(!std::path::Path::new("not-made").exists());
}
