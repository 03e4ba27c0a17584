//! The receiver's own program and a drive process, over shared memory.
//!
//! The tests judge the receiver's trace, by its own cycles: a busy machine changes only the duration.

#![allow(
    clippy::disallowed_methods,
    reason = "it waits for processes, which nothing is measured by"
)]

#[path = "../../../common/drive-memory/examples/drive_reader.rs"]
mod drive_reader;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use coaxle_test_process::{Process, WAIT_TIMEOUT, assert_alive, output, until};

const CONFIG: &str = "
name = 'saw'
cycle-time-us = 2000
master = { node = 'nobody' }
[transport]
connect = []
listen = ['tcp/127.0.0.1:0']
[[slave]]
name = 'carriage'
limits = { velocity = 200, acceleration = 1000, jerk = 20000 }
[slave.drive]
kind = 'shared-memory'
path = 'drive'
following-error-window = 150
following-error-time-s = 1
max-silent-cycles = 250
switch-on-time-s = 100
[[slave.step]]
do = { power = true }
[[slave.step]]
when = { state = 'standstill' }
do = { move-velocity = { velocity = 100 } }
[[slave.step]]
when = { state = 'error-stop', standstill = true }
do = { reset = {} }
[[slave.step]]
when = { state = 'standstill' }
do = { move-velocity = { velocity = -100 } }
";

struct Node {
    process: Process,
    folder: tempfile::TempDir,
}

impl Node {
    fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let config = folder.path().join("r.toml");
        std::fs::write(&config, CONFIG).expect("the folder can be written");
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-receiver"));
        command.arg(&config).args([
            "--trace".as_ref(),
            folder.path().join("trace.csv").as_os_str(),
        ]);
        let process = Process::start("saw", &mut command, &folder.path().join("log"));
        Self { process, folder }
    }

    fn memory(&self) -> PathBuf {
        self.folder.path().join("drive")
    }

    /// Ends it like Ctrl-C.
    fn end(self) -> Vec<Row> {
        self.process.signal("TERM");
        assert!(self.process.wait().success(), "{}", self.process.log());
        assert!(!self.memory().exists(), "the file is removed");
        rows(&self.folder.path().join("trace.csv"))
    }
}

/// A traced cycle.
struct Row {
    cycle: u64,
    position: f64,
    velocity: f64,
    state: String,
    error: u32,
    kind: String,
    attached: bool,
}

fn rows(trace: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(trace).expect("the trace");
    let head = reader.headers().expect("a head line").clone();
    let at = |name: &str| head.iter().position(|column| column == name).expect(name);
    let [cycle, position, velocity, state, error, kind, attached] = [
        "cycle",
        "carriage.position",
        "carriage.velocity",
        "carriage.state",
        "carriage.error",
        "carriage.drive_kind",
        "carriage.drive_attached",
    ]
    .map(at);
    reader
        .records()
        .map(|record| {
            let record = record.expect("a row");
            Row {
                cycle: record[cycle].parse().expect("a count"),
                position: record[position].parse().expect("a number"),
                velocity: record[velocity].parse().expect("a number"),
                state: record[state].to_owned(),
                error: record[error].parse().expect("a code"),
                kind: record[kind].to_owned(),
                attached: &record[attached] == "true",
            }
        })
        .collect()
}

/// Runs the example as the drive, until it has shown a line that satisfies `reached`.
fn drive_until(memory: &Path, reached: impl Fn(&str) -> bool) {
    let (stop, begin) = (AtomicBool::new(false), Instant::now());
    drive_reader::run(memory, &stop, |line| {
        assert_alive(&line);
        assert!(
            begin.elapsed() < WAIT_TIMEOUT,
            "still waiting, told last: {line}"
        );
        if reached(&line) {
            stop.store(true, Ordering::Relaxed);
        }
    });
}

/// Waits by reading `set_state` in the memory.
fn wait_until_not_following(memory: &Path) {
    until("the receiver does not follow any more", || {
        // Byte 192 is `set_state`, of which 2 is following.
        std::fs::read(memory).expect("the memory")[192] != 2
    });
}

fn velocity(line: &str) -> Option<f64> {
    line.rsplit_once("velocity ")?.1.parse().ok()
}

#[test]
fn a_drive_process_is_moved_dies_and_comes_back() {
    let node = Node::start();
    // A profile ends exactly at its set velocity.
    drive_until(&node.memory(), |line| velocity(line) == Some(100.0));
    // The process ends in full motion. The next one starts when the receiver has noticed.
    wait_until_not_following(&node.memory());
    drive_until(&node.memory(), |line| velocity(line) == Some(-100.0));
    assert_alive("it is ended");
    let rows = node.end();

    let states = rows.iter().map(|row| row.state.as_str());
    let mut life: Vec<_> = states.collect();
    life.dedup();
    // The drive has ended before its node, which may run on for longer than it waits for a drive if the machine is busy.
    if life.len() == 8 && life[7] == "error-stop" {
        life.pop();
    }
    // A shorter life fails below, by its length.
    assert_eq!(
        life,
        [
            "disabled",
            "standstill",
            "continuous-motion",
            "error-stop",
            "disabled",
            "standstill",
            "continuous-motion",
        ][..life.len().min(7)],
    );
    assert!(life.len() >= 7, "{life:?}");
    assert!(rows.iter().all(|row| row.kind == "shared-memory"));
    let stopped = rows.iter().filter(|row| row.state == "error-stop");
    assert!(stopped.clone().all(|row| row.error == 0x4655));
    assert!(stopped.clone().any(|row| !row.attached));
    for pair in rows.windows(2) {
        let (before, row) = (&pair[0], &pair[1]);
        // A disabled slave takes over the drive's position, which may jump.
        let moves = |row: &Row| row.state != "disabled";
        if !(moves(before) && moves(row)) {
            continue;
        }
        // Cycles that a busy machine skips have no row.
        let seconds = 2e-3 * (row.cycle - before.cycle) as f64;
        let step = (row.position - before.position).abs();
        assert!(
            step <= 200.0 * seconds * (1.0 + 1e-6),
            "cycle {}: {step}",
            row.cycle
        );
        let change = (row.velocity - before.velocity).abs();
        assert!(
            change <= 1_000.0 * seconds * (1.0 + 1e-6),
            "cycle {}: {change}",
            row.cycle
        );
    }
}

#[test]
fn two_nodes_do_not_share_a_file() {
    let node = Node::start();
    drive_until(&node.memory(), |line| {
        line.starts_with("attached to carriage, axis 1")
    });
    let mut second = Command::new(env!("CARGO_BIN_EXE_coaxle-receiver"));
    let second = output(second.arg(node.folder.path().join("r.toml")));
    assert!(!second.status.success());
    let said = String::from_utf8_lossy(&second.stderr);
    let pid = node.process.id();
    let expected =
        format!("drive: is used by another node (process {pid}), expected a file of its own");
    assert!(said.contains("slave \"carriage\".drive.path: "), "{said}");
    assert!(said.contains(&expected), "{said}");
    node.end();
}

/// The Python program of the page, if Python is available.
#[test]
fn the_python_of_the_page_is_a_drive_process() {
    let page = include_str!("../../../docs/DRIVE.md");
    let program = page.split("```python\n").nth(1).expect("a program");
    let program = program.split("```").next().expect("its end");
    if Command::new("python3").arg("--version").output().is_err() {
        return;
    }
    let node = Node::start();
    until("the memory is there", || node.memory().exists());
    // The file exists a moment before its contents are valid.
    std::thread::sleep(Duration::from_millis(500));
    let mut python = Command::new("python3");
    let scratch = tempfile::tempdir().expect("a folder");
    let file = |name: &str| scratch.path().join(name);
    let shown = File::create(file("shown")).expect("a file");
    // The process's output is read while it runs.
    python
        .args(["-u", "-c", program])
        .arg(node.memory())
        .stdout(shown);
    let python = Process::start("the drive", &mut python, &file("drive.log"));
    until("the drive is moved", || {
        let shown = std::fs::read_to_string(file("shown")).unwrap_or_default();
        shown.lines().any(|line| {
            let position = line
                .rsplit_once("position ")
                .and_then(|(_, p)| p.parse().ok());
            // Beyond 50 u, the drive is not only switched on.
            line.contains("enable 1") && position.is_some_and(|position: f64| position > 50.0)
        })
    });
    // The process ends by itself, with the node.
    python.may_end();
    let rows = node.end();
    assert!(
        python.wait().success(),
        "it sees that the node has ended: {}",
        python.log()
    );
    assert!(rows.iter().all(|row| row.state != "error-stop"));
}
