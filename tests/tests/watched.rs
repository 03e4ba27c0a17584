//! Running nodes as who watches them sees them: who is there, what they say, and when a clock is known.

use std::fs::File;
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use coaxle_clock::Span;
use coaxle_host::machine;
use serde_json::Value;
use tempfile::TempDir;

/// For whatever takes no time: the machine may be very busy.
const PATIENCE: Span = Span::from_secs(60);

/// A sender, and receivers that follow it, or something like it. Each listens, as nothing is forwarded between peers.
struct Line {
    folder: TempDir,
    endpoints: Vec<String>,
    nodes: Vec<Child>,
}

impl Line {
    /// The sender alone.
    fn new() -> Self {
        let mut line = Self {
            folder: tempfile::tempdir().expect("a scratch folder"),
            endpoints: Vec::new(),
            nodes: Vec::new(),
        };
        let sender = "cycle-time-us = 2000\n[[axis]]\nid = 3\nname = 'belt'\n[axis.program]\n\
                      limits = { velocity = 100, acceleration = 100, jerk = 1000 }\nsteps = []\n";
        line.start("sender", "belt", sender);
        line
    }

    fn start(&mut self, role: &str, name: &str, config: &str) {
        // Nobody else takes a port that was just free.
        let port = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr());
        let endpoint = format!("tcp/127.0.0.1:{}", port.expect("a free port").port());
        let file = self.folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, format!("name = '{name}'\n{config}")).expect("a config");
        let log = File::create(self.log(name)).expect("a log");
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.arg(role).arg(file).stdin(Stdio::null());
        command.args(["--listen", &endpoint]);
        for other in &self.endpoints {
            command.args(["--connect", other]);
        }
        self.endpoints.push(endpoint);
        self.nodes
            .push(command.stderr(log).spawn().expect("it starts"));
    }

    fn receive(&mut self, name: &str, master: &str) {
        let config = format!("cycle-time-us = 2000\nmaster = {master}\n");
        self.start("receiver", name, &config);
    }

    fn log(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(format!("{name}.log"))
    }

    fn ask(&self, words: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.args(words);
        for endpoint in &self.endpoints {
            command.args(["--connect", endpoint]);
        }
        command.output().expect("it runs")
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        for node in &mut self.nodes {
            let _ = node.kill();
            let _ = node.wait();
        }
    }
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = machine::now();
    while !is_so() {
        assert!(machine::now() - begin < PATIENCE, "{what}");
        std::thread::park_timeout(Duration::from_millis(20));
    }
}

fn said(log: &Path) -> String {
    std::fs::read_to_string(log).unwrap_or_default()
}

fn printed(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

#[test]
fn nodes_are_listed_their_status_is_told_and_a_script_can_wait_for_them() {
    let mut line = Line::new();
    line.receive("saw", "{ node = 'belt', axis = 3 }");
    let waited = line.ask(&["wait-sync", "saw", "--timeout", "60s"]);
    assert_eq!(waited.status.code(), Some(0), "{waited:?}");
    assert!(
        printed(&waited).contains("belt observer, synced"),
        "{waited:?}"
    );

    let listed = line.ask(&["nodes", "--json"]);
    let nodes: Value = serde_json::from_slice(&listed.stdout).expect("JSON");
    let names: Vec<_> = nodes
        .as_array()
        .into_iter()
        .flatten()
        .map(|node| &node["node"])
        .collect();
    assert_eq!(names, ["belt", "saw"], "{nodes}");
    assert_eq!(nodes[1]["follows"][0], "belt");

    let status = line.ask(&["status", "saw", "--format", "json"]);
    let status: Value = serde_json::from_slice(&status.stdout).expect("JSON");
    assert_eq!(status[0]["far"]["belt"]["synced"], true, "{status}");
    assert_eq!(
        status.as_array().map(Vec::len),
        Some(1),
        "the one that was named"
    );

    let metrics = printed(&line.ask(&["status", "--format", "prometheus"]));
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
    let plain = printed(&line.ask(&["status"]));
    assert!(
        plain.contains("belt: sender, ok") && plain.contains("ppm"),
        "{plain}"
    );

    let never = line.ask(&[
        "wait-sync",
        "saw",
        "--timeout",
        "300ms",
        "--max-error",
        "1us",
    ]);
    assert_eq!(never.status.code(), Some(3), "{never:?}");
    let stranger = line.ask(&["wait-sync", "belt", "--timeout", "300ms"]);
    assert_eq!(stranger.status.code(), Some(3), "{stranger:?}");
    assert!(
        printed(&stranger).contains("it follows no other node"),
        "{stranger:?}"
    );
}

#[test]
fn who_is_not_there_is_told_of_with_who_is() {
    let mut line = Line::new();
    line.receive("press", "{ node = 'bellt', axis = 3 }");
    line.receive("saw", "{ node = 'belt', axis = 1 }");
    until("who is there instead is named", || {
        said(&line.log("press")).contains("needs node bellt")
            && said(&line.log("press")).contains("it sees belt")
    });
    until("which axis is there instead is named", || {
        said(&line.log("saw")).contains("it has axis 3, and none of those that are followed")
    });
    for (words, code) in [
        (vec!["status", "sew"], 1),
        (vec!["wait-sync", "sew", "--timeout", "2s"], 5),
    ] {
        let answer = line.ask(&words);
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
    let mut line = Line::new();
    for node in &mut line.nodes {
        let _ = node.kill();
        let _ = node.wait();
    }
    let nobody = line.ask(&["nodes"]);
    assert_eq!(nobody.status.code(), Some(5), "{nobody:?}");
    let nobody = line.ask(&["status"]);
    assert_eq!(nobody.status.code(), Some(1), "{nobody:?}");
    assert!(
        String::from_utf8_lossy(&nobody.stderr).contains("no node is there"),
        "{nobody:?}"
    );
}
