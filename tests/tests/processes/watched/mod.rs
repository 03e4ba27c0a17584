//! Running nodes as an observer sees them: their presence, their statuses, when a clock is known, and their rows of every
//! cycle.

mod browser;
mod designer;
mod line;
mod page;
mod ptp;
mod replay;
mod report;

use std::process::Command;

use coaxle_test_process::until;
use line::{Line, log_text, printed};
use serde_json::Value;

#[test]
fn nodes_are_listed_their_status_is_told_and_a_script_can_wait_for_them() {
    let mut line = Line::new();
    line.receive("saw", "{ node = 'belt', axis = 3 }");
    let waited = line.run_tool(&["wait-sync", "saw", "--timeout", "60s"]);
    assert_eq!(waited.status.code(), Some(0), "{waited:?}");
    // On a busy machine it may be less certain than it was a moment before.
    let known = ["belt observer, synced", "belt observer, unsure"];
    let printed_states = printed(&waited);
    assert!(
        known.iter().any(|state| printed_states.contains(state)),
        "{waited:?}"
    );

    let listed = line.run_tool(&["nodes", "--json"]);
    let nodes: Value = serde_json::from_slice(&listed.stdout).expect("JSON");
    let names: Vec<_> = nodes
        .as_array()
        .into_iter()
        .flatten()
        .map(|node| &node["node"])
        .collect();
    assert_eq!(names, ["belt", "saw"], "{nodes}");
    assert_eq!(nodes[1]["follows"][0], "belt");

    let status = line.run_tool(&["status", "saw", "--format", "json"]);
    let status: Value = serde_json::from_slice(&status.stdout).expect("JSON");
    assert_eq!(status[0]["far"]["belt"]["synced"], true, "{status}");
    assert_eq!(
        status.as_array().map(Vec::len),
        Some(1),
        "the one that was named"
    );

    let got = line.run_tool(&["get", "saw", "belt.synced", "health", "cycle_time_us"]);
    let got = printed(&got);
    let values: Vec<_> = got.lines().collect();
    assert_eq!((values.len(), values[0]), (3, "true"), "{got}");
    let none = line.run_tool(&["get", "saw", "belt.synchronous"]);
    assert_eq!(none.status.code(), Some(2), "{none:?}");

    let metrics = printed(&line.run_tool(&["status", "--format", "prometheus"]));
    for expected in [
        "coaxle_up{node=\"belt\"} 1",
        "coaxle_far_synced{node=\"saw\",far=\"belt\"} 1",
        "coaxle_axis_velocity{node=\"belt\",axis=\"belt\",unit=\"u\"} 0",
    ] {
        assert!(
            metrics.lines().any(|line| line == expected),
            "{expected}\n{metrics}"
        );
    }
    let plain = printed(&line.run_tool(&["status"]));
    assert!(
        plain.contains("belt: sender, ok") && plain.contains("ppm"),
        "{plain}"
    );

    // No clock over a real network is certain to a microsecond within 0.3 s.
    let never = line.run_tool(&[
        "wait-sync",
        "saw",
        "--timeout",
        "300ms",
        "--max-error",
        "1us",
    ]);
    assert_eq!(never.status.code(), Some(3), "{never:?}");
    let stranger = line.run_tool(&["wait-sync", "belt", "--timeout", "300ms"]);
    assert_eq!(stranger.status.code(), Some(3), "{stranger:?}");
    assert!(
        printed(&stranger).contains("it follows no other node"),
        "{stranger:?}"
    );
}

/// A sender whose axis turns at 50 u/s, promised 2 s ahead, and one that promises nothing.
#[test]
fn it_is_known_when_a_promised_axis_will_be_at_a_position() {
    let mut line = Line::new();
    let promised = "cycle-time-us = 2000\n[[axis]]\nid = 7\nname = 'drum'\nmodulo = 360\nlead-ms = 2000\n[axis.program]\n\
                    start-velocity = 50\nlimits = { velocity = 100, acceleration = 100, jerk = 1000 }\nsteps = []\n";
    line.start("sender", "press", promised);
    let when = |words: &[&str]| {
        let words: Vec<_> = ["when", "press"].iter().chain(words).copied().collect();
        line.run_tool(&words)
    };
    // A turn takes 7.2 s, of which 2 are promised: it is waited for.
    until("the position is within the promise", || {
        let answer = when(&["drum", "180", "--in-turn", "--direction", "forward"]);
        let code = answer.status.code();
        assert!(code == Some(0) || code == Some(5), "{answer:?}");
        let seconds = printed(&answer).trim().parse::<f64>();
        seconds.is_ok_and(|seconds| (0.0..=2.0).contains(&seconds))
    });
    let never = when(&["7", "-5"]);
    assert_eq!(never.status.code(), Some(5), "{never:?}");
    let told = String::from_utf8_lossy(&never.stderr);
    assert!(told.contains("not there within the promise"), "{told}");
    for (words, code, expected) in [
        (&["drumm", "5"][..], 2, "did you mean \"drum\"?"),
        (
            &["drum", "360", "--in-turn"],
            2,
            "0 up to less than the modulo turn of 360",
        ),
        (&["drum", "far"], 2, "expected a finite number"),
    ] {
        let answer = when(words);
        let told = String::from_utf8_lossy(&answer.stderr);
        assert_eq!(answer.status.code(), Some(code), "{told}");
        assert!(told.contains(expected), "{told}");
    }
    let nothing = line.run_tool(&["when", "belt", "belt", "5"]);
    let told = String::from_utf8_lossy(&nothing.stderr);
    assert_eq!(nothing.status.code(), Some(5), "{told}");
    assert!(told.contains("promises nothing"), "{told}");
}

#[test]
fn who_is_not_there_is_told_of_with_who_is() {
    let mut line = Line::new();
    line.receive("press", "{ node = 'bellt', axis = 3 }");
    line.receive("saw", "{ node = 'belt', axis = 1 }");
    until("who is there instead is named", || {
        log_text(&line.log("press")).contains("needs node bellt")
            && log_text(&line.log("press")).contains("it sees belt")
    });
    until("which axis is there instead is named", || {
        log_text(&line.log("saw")).contains("it has axis 3, and none of those that are followed")
    });
    for (words, code) in [
        (vec!["status", "sew"], 5),
        (vec!["get", "sew", "health"], 5),
        (vec!["wait-sync", "sew", "--timeout", "2s"], 5),
    ] {
        let answer = line.run_tool(&words);
        assert_eq!(answer.status.code(), Some(code), "{answer:?}");
        let told = String::from_utf8_lossy(&answer.stderr);
        assert!(
            told.contains("node sew says nothing") && told.contains("there are "),
            "{told}"
        );
        assert!(told.contains("belt") && told.contains("saw"), "{told}");
    }
}

#[test]
fn where_nobody_is_there_is_no_data() {
    let line = Line::new();
    for node in &line.nodes {
        node.kill();
    }
    let nobody = line.run_tool(&["nodes"]);
    assert_eq!(nobody.status.code(), Some(5), "{nobody:?}");
    let nobody = line.run_tool(&["status"]);
    assert_eq!(nobody.status.code(), Some(5), "{nobody:?}");
    assert!(
        String::from_utf8_lossy(&nobody.stderr).contains("no node is there"),
        "{nobody:?}"
    );
}

#[test]
fn rows_are_recorded_from_outside_as_the_node_records_them() {
    let mut line = Line::new();
    line.receive("saw", "{ node = 'belt', axis = 3 }");
    let file = line.folder.path().join("seen.mcap");
    let file = file.to_str().expect("a path");
    let recorded = line.run_tool(&["record", "belt", "saw", "--for", "2s", "--out", file]);
    assert_eq!(recorded.status.code(), Some(0), "{recorded:?}");
    let text = printed(&recorded);
    let rows = |node: &str| {
        let told = text.lines().find_map(|line| line.strip_prefix(node));
        let told = told.and_then(|rest| rest.split(' ').next()?.parse::<u64>().ok());
        told.unwrap_or_default()
    };
    assert!(rows("belt: ") > 10 && rows("saw: ") > 10, "{text}");
    let mut export = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    let exported = export.args(["export", "csv", file]).output();
    let exported = exported.expect("it runs");
    assert_eq!(exported.status.code(), Some(0), "{exported:?}");
    let table = log_text(&line.folder.path().join("seen-saw.csv"));
    assert!(table.starts_with("at_ns,woke_ns,"), "{table:.200}");
    // Rows and the head line.
    assert_eq!(table.lines().count() as u64, rows("saw: ") + 1);

    let again = line.run_tool(&["record", "saw", "--for", "1s", "--out", file]);
    assert_eq!(again.status.code(), Some(1), "{again:?}");
    let nobody = line.run_tool(&["record", "sow", "--for", "1s"]);
    let error = String::from_utf8_lossy(&nobody.stderr);
    assert!(
        error.contains("sow") && error.contains("there are"),
        "{error}"
    );
}
