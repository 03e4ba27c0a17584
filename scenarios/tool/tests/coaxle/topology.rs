//! `coaxle topology` over config files.

use std::path::Path;
use std::process::{Command, Output};

use coaxle_test_process::{Process, output, until};

use crate::shared::{free_endpoint, text, written};

const LINE: &str = "\
name = 'line'
cycle-time-us = 1000
[[axis]]
id = 1
name = 'conveyor'
unit = 'mm'
present-after-ms = 200
program = { limits = { velocity = 1000, acceleration = 5000, jerk = 100000 } }
";

const PRESS: &str = "\
name = 'press'
cycle-time-us = 1000
master = { node = 'line', axis = 1 }
lag-ms = 60
slave = [{ name = 'feed' }]
[[lab.far]]
node = 'line'
faults = { latency-us = 20000, jitter = { exponential-us = 20 }, loss = 0.05 }
";

const SAW: &str = "\
name = 'saw'
cycle-time-us = 1000
delay = { fixed-us = 20000 }
slave = [{ name = 'carriage' }]
master = { node = 'press', channel = 'slaves', axis = 1 }
";

struct Plant {
    folder: tempfile::TempDir,
    files: Vec<String>,
}

impl Plant {
    fn of(texts: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |(n, text): (usize, &&str)| {
            let name = text.split('\'').nth(1).expect("a name first");
            let name = match n {
                // A name that two nodes share is no name of two files.
                0 => format!("{name}.toml"),
                n => format!("{n}-{name}.toml"),
            };
            written(folder.path(), &name, text.as_bytes());
            name
        };
        let files = texts.iter().enumerate().map(file).collect();
        Self { folder, files }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle"));
        command.current_dir(self.path()).arg("topology");
        command.args(&self.files).args(arguments);
        command.output().expect("the tool starts")
    }

    fn said(&self, arguments: &[&str], code: i32) -> String {
        let output = self.run(arguments);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(code), "{out}{err}");
        out
    }
}

fn squeezed(text: &str) -> Vec<String> {
    let line = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    text.lines().map(line).collect()
}

#[test]
fn routes_have_delays_lags_and_their_sums() {
    let plant = Plant::of(&[LINE, PRESS, SAW]);
    let lines = squeezed(&plant.said(&[], 0));
    for expected in [
        "line sender 1 ms conveyor (axes/1, mm): program line.toml",
        "press receiver 1 ms 140 ms line.1 (mm) ← line/axes/1 1-press.toml",
        "feed (slaves/1, mm) ← line.1",
        "line/conveyor press/feed line → press 20 25.1 200 60 140 interpolated",
        "line/conveyor saw/carriage line → press → saw 20 + 20 = 40 25.1 + 23 = 48.1 200 60 + 140 = 200 0 interpolated",
        "proposal: line (conveyor): present-after-ms = 90; 200 is stated",
    ] {
        assert!(
            lines.iter().any(|line| line == expected),
            "{expected}\n{lines:#?}"
        );
    }
}

#[test]
fn json_dot_and_a_picture_have_the_same_nodes() {
    let plant = Plant::of(&[LINE, PRESS, SAW]);
    let json: serde_json::Value = serde_json::from_str(&plant.said(&["--json"], 0)).expect("JSON");
    assert_eq!(json["routes"][1]["stages"][1]["delay_origin"], "configured");
    assert_eq!(json["routes"][1]["lag_ms"], 200.0);
    assert_eq!(json["links"][1]["from"], serde_json::json!([1, 1]));
    assert_eq!(json["findings"], serde_json::json!([]));
    let dot = plant.said(&["--dot", "--svg", "plant.svg"], 0);
    assert!(
        dot.starts_with("digraph") && dot.contains("a0_0 -> a1_0 [label = \"20 ms, lag 60 ms\""),
        "{dot}"
    );
    let svg = std::fs::read_to_string(plant.path().join("plant.svg")).expect("a picture");
    assert!(
        svg.starts_with("<svg") && svg.contains(">carriage [mm] ← press.1<"),
        "{svg}"
    );
}

#[test]
fn an_unknown_delay_is_assumed_only_if_asked() {
    let saw = SAW.replace("delay = { fixed-us = 20000 }\n", "");
    let plant = Plant::of(&[LINE, PRESS, &saw]);
    let said = plant.said(&[], 0);
    assert!(
        said.contains("no present-after-ms, because a way has no known delay"),
        "{said}"
    );
    let said = plant.said(&["--assume-delay", "5ms"], 0);
    assert!(said.contains("present-after-ms = 71"), "{said}");
}

#[test]
fn contradictions_have_file_field_received_and_expected_and_exit_code_1() {
    let press = PRESS
        .replace("axis = 1", "axis = 1, unit = 'inch'")
        .replace("cycle-time-us = 1000", "cycle-time-us = 1500");
    let saw = SAW.replace("axis = 1", "axis = 2");
    let knife =
        "name = 'knife'\ncycle-time-us = 1000\n[[far]]\nnode = 'presss'\nchannel = 'slaves'\n";
    let twice = LINE.replace("name = 'conveyor'", "name = 'belt'");
    let plant = Plant::of(&[LINE, &press, &saw, knife, &twice]);
    let said = plant.said(&[], 1);
    for expected in [
        "wrong: 4-line.toml: name: received \"line\", which is the name in line.toml too, expected a name of its own",
        "wrong: 1-press.toml: master.unit: received \"inch\" for line.1, expected \"mm\", as line.toml: axis[0] (conveyor)",
        "wrong: 1-press.toml: cycle-time-us: received 1500, expected a whole multiple or a whole part",
        "wrong: 2-saw.toml: master.axis: received the id 2, expected one of press/slaves in 1-press.toml: 1",
        "wrong: 3-knife.toml: far[0].node: received \"presss\", expected a node of these configs; did you mean \"press\"?",
    ] {
        assert!(said.contains(expected), "{expected}\n{said}");
    }
}

#[test]
fn circles_over_nodes_are_refused() {
    let press = PRESS
        .replace(
            "node = 'line', axis = 1",
            "node = 'saw', channel = 'slaves', axis = 1",
        )
        .replace("node = 'line'", "node = 'saw'");
    let said = Plant::of(&[&press, SAW]).said(&[], 1);
    let expected = "wrong: press.toml: master.node: received a circle (0x816f): press/slaves/1 follows saw/slaves/1 follows \
                    press/slaves/1";
    assert!(said.contains(expected), "{said}");
}

#[test]
fn a_file_that_is_no_config_is_named() {
    let plant = Plant::of(&["name = 'x'\n"]);
    let output = plant.run(&[]);
    assert_eq!(output.status.code(), Some(78), "{output:?}");
    assert!(text(&output.stderr).contains("x.toml"), "{output:?}");
}

/// A node that ends with the test.
fn start(role: &str, folder: &Path, config: &str, arguments: &[&str]) -> Process {
    let file = written(folder, &format!("{role}.toml"), config.as_bytes());
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle"));
    command.arg(role).arg(file).args(arguments);
    command.args(["--for", "600s", "--quiet"]);
    Process::start(role, &mut command, &folder.join(format!("{role}.log")))
}

fn tool(arguments: &[&str]) -> (String, Option<i32>) {
    let output = output(Command::new(env!("CARGO_BIN_EXE_coaxle")).args(arguments));
    let said = text(&output.stdout) + &text(&output.stderr);
    (said, output.status.code())
}

/// Asks until the answer has this text.
fn answer_with(expected: &str, arguments: &[&str]) -> String {
    let mut said = String::new();
    until(expected, || {
        said = tool(arguments).0;
        said.contains(expected)
    });
    said
}

const LIVE_LINE: &str = "\
name = 'line'
cycle-time-us = 2000
[[axis]]
id = 3
name = 'conveyor'
unit = 'mm'
present-after-ms = 100
program = { start-velocity = 5, limits = { velocity = 10, acceleration = 10, jerk = 100 } }
";

#[test]
fn running_nodes_are_shown_with_measured_delays() {
    let folder = tempfile::tempdir().expect("a folder");
    let (line, saw) = (free_endpoint(), free_endpoint());
    let _line = start("sender", folder.path(), LIVE_LINE, &["--listen", &line]);
    let config = "name = 'saw'\ncycle-time-us = 2000\nmaster = { node = 'line', axis = 3 }\n\
                  slave = [{ name = 'carriage' }]\n";
    let follows = ["--listen", &saw, "--connect", &line];
    let _saw = start("receiver", folder.path(), config, &follows);
    let (waited, code) = tool(&["wait-sync", "saw", "--timeout", "60s", "--connect", &saw]);
    assert_eq!(code, Some(0), "{waited}");
    let arguments = [
        "topology",
        "--live",
        "--json",
        "--connect",
        &line,
        "--connect",
        &saw,
    ];
    let said = answer_with("\"interpolated\"", &arguments);
    let json: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!(json["findings"], serde_json::json!([]), "{said}");
    let route = &json["routes"][0];
    let way = ["line/conveyor", "saw/line.3", "saw/carriage"];
    assert_eq!(route["way"], serde_json::json!(way), "{said}");
    let stage = &route["stages"][0];
    assert_eq!(stage["delay_origin"], "measured", "{said}");
    assert_eq!(stage["present_after_ms"], 100.0, "{said}");
    let needed = stage["needed_ms"].as_f64().expect("measured");
    // Two cycles of 2 ms at least, and less than the delay, or it would not be interpolated.
    assert!((4.0..100.0).contains(&needed), "{said}");
    // By the line alone: 2 ms, as its config says, with the unit.
    let line = &json["nodes"][0]["axes"][0];
    assert_eq!(
        (&line["kind"], &line["unit"]),
        (&"program".into(), &"mm".into())
    );
    // The receiver takes the unit, where its config states none.
    let (status, _) = tool(&["status", "saw", "--format", "json", "--connect", &saw]);
    let status: serde_json::Value = serde_json::from_str(&status).expect("JSON");
    assert_eq!(status[0]["axes"]["line.3"]["unit"], "mm", "{status}");
    assert_eq!(status[0]["about"]["line"]["described"], true, "{status}");
}

#[test]
fn a_receiver_that_means_another_unit_does_not_move() {
    let folder = tempfile::tempdir().expect("a folder");
    let (line, saw) = (free_endpoint(), free_endpoint());
    let _line = start("sender", folder.path(), LIVE_LINE, &["--listen", &line]);
    let config = "name = 'saw'\ncycle-time-us = 2000\nmaster = { node = 'line', axis = 3, unit = 'inch' }\n\
                  slave = [{ name = 'carriage' }]\n";
    let follows = ["--listen", &saw, "--connect", &line];
    let _saw = start("receiver", folder.path(), config, &follows);
    let said = answer_with(
        "axis-contradicts",
        &["status", "saw", "--format", "json", "--connect", &saw],
    );
    let status: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    let contradiction = &status[0]["about"]["line"]["contradictions"][0];
    let expected =
        "received \"inch\" for line.3, expected \"mm\", as line says of its axis conveyor";
    assert!(
        contradiction
            .as_str()
            .is_some_and(|text| text.ends_with(expected)),
        "{said}"
    );
    // Its count of cycles tells the time that has passed, on a busy machine as well.
    let now = || {
        let (said, _) = tool(&["status", "saw", "--format", "json", "--connect", &saw]);
        let status: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        let position = status[0]["slaves"]["carriage"]["position"].as_f64();
        (status[0]["cycles"].as_u64(), position)
    };
    // On a machine too busy for a description within a second it has moved by then, and is braked.
    let mut since = now();
    until("it stands for a thousand cycles", || {
        let (cycles, position) = now();
        if position != since.1 {
            since = (cycles, position);
        }
        let passed = cycles.zip(since.0).map(|(now, first)| now - first);
        passed.is_some_and(|passed| passed > 1_000)
    });
}
