//! Nodes as a supervisor sees them: exit codes, signals, the service manager, the end of their parent, and a log
//! or a disk that takes nothing.

use std::fs::{DirEntry, File};
use std::io::Read;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use coaxle_test_process::{Process, output, until};
use serde_json::Value;
use tempfile::TempDir;

const SENDER: &str = "name = 'belt'\ncycle-time-us = 2000\n[[axis]]\nid = 1\nname = 'belt'\n\
                      [axis.program]\nlimits = { velocity = 100, acceleration = 100, jerk = 1000 }\nsteps = []\n";

const RECEIVER: &str = "name = 'saw'\ncycle-time-us = 2000\nmaster = { node = 'belt' }\n";

/// A scratch folder with a config.
fn config(role: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let file = folder.path().join(format!("{role}.toml"));
    let text = if role == "sender" { SENDER } else { RECEIVER };
    std::fs::write(&file, text).expect("a config");
    (folder, file)
}

fn node(role: &str, config: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    command.arg(role).arg(config).stdin(Stdio::null());
    command
}

/// A node with its log in a file; waits until it logs that it runs.
fn running(command: &mut Command, log: &Path) -> Process {
    let node = Process::start("the node", command, log);
    until("the node runs", || node.logged("running"));
    node
}

#[test]
fn the_exit_code_says_what_a_node_came_to() {
    let (folder, sender) = config("sender");
    let done = output(node("sender", &sender).args(["--for", "200ms"]));
    assert_eq!(done.status.code(), Some(0));

    let (_other, receiver) = config("receiver");
    let alone = output(node("receiver", &receiver).args(["--for", "200ms"]));
    // Codes are those of `--help`: 5 no data, 78 a wrong file, 2 a wrong command line.
    assert_eq!(alone.status.code(), Some(5));
    let log = String::from_utf8_lossy(&alone.stderr);
    assert!(log.contains("no data came"), "{log}");

    let missing = folder.path().join("no-such-file.toml");
    let failed = output(&mut node("sender", &missing));
    assert_eq!(failed.status.code(), Some(78));
    let wrong = output(node("sender", &sender).arg("--no-such-flag"));
    assert_eq!(wrong.status.code(), Some(2));
}

#[test]
fn signals_end_a_node_cleanly() {
    let (folder, config) = config("sender");
    for (name, ended_by) in [
        ("HUP", "HungUp"),
        ("TERM", "Terminated"),
        ("INT", "Interrupted"),
    ] {
        // Signals ignored by these tests, under nohup, are ignored by their nodes, too.
        if name == "HUP" && ignores_hang_up() {
            continue;
        }
        let log = folder.path().join("log");
        let node = running(&mut node("sender", &config), &log);
        node.signal(name);
        assert!(node.wait().success(), "{name}");
        let ended = format!("ended={ended_by}");
        assert!(node.logged(&ended), "{}", node.log());
    }
}

fn ignores_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").expect("a status");
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:\t"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask, 16).ok());
    mask.expect("the ignored signals") & 1 != 0
}

#[test]
fn a_node_that_outlives_its_terminal_is_not_ended_by_its_closing() {
    let (folder, config) = config("sender");
    let log = folder.path().join("log");
    let mut command = Command::new("sh");
    command
        // An ignored signal is inherited through `exec`, as under nohup.
        .args(["-c", "trap '' HUP; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_coaxle-under-test"))
        .arg("sender")
        .arg(config);
    let node = running(&mut command, &log);
    node.signal("HUP");
    node.signal("TERM");
    assert!(node.wait().success());
    assert!(node.logged("ended=Terminated"), "{}", node.log());
}

#[test]
fn the_service_manager_hears_that_a_node_runs_that_its_cycle_does_and_that_it_ends() {
    let (folder, config) = config("sender");
    let path = folder.path().join("notify");
    let manager = UnixDatagram::bind(&path).expect("a socket");
    manager.set_nonblocking(true).expect("a socket");
    let next = || {
        let (mut bytes, mut length) = ([0; 256], 0);
        until("the node says something", || {
            let received = manager.recv(&mut bytes);
            length = received.unwrap_or_default();
            length > 0
        });
        String::from_utf8_lossy(&bytes[..length]).trim().to_owned()
    };
    let mut command = node("sender", &config);
    command
        .env("NOTIFY_SOCKET", &path)
        // 0.3 s, which a node has to feed several times within.
        .env("WATCHDOG_USEC", "300000");
    let log = folder.path().join("log");
    let node = Process::start("the node", &mut command, &log);
    assert_eq!(next(), "READY=1");
    for _ in 0..3 {
        assert_eq!(next(), "WATCHDOG=1");
    }
    node.signal("TERM");
    until("the node says that it ends", || next() == "STOPPING=1");
    assert!(node.wait().success());
}

#[test]
fn nobody_waits_for_a_log_that_is_full_or_not_read() {
    let (_folder, config) = config("sender");
    // Every write to this device fails for lack of space.
    let full = File::options().write(true).open("/dev/full");
    let mut verbose = node("sender", &config);
    verbose.args(["--for", "500ms", "-vv"]);
    verbose.stderr(full.expect("it is there"));
    let node = Process::start_without_log("the node", &mut verbose).expect("it starts");
    assert!(node.wait().success());

    // A pipe that is not read until the node has ended.
    verbose.stderr(Stdio::piped());
    let node = Process::start_without_log("the node", &mut verbose).expect("it starts");
    let mut pipe = node.take_stderr().expect("a pipe");
    assert!(node.wait().success());
    let mut log = Vec::new();
    pipe.read_to_end(&mut log).expect("what fitted is there");
    // At least what fits a pipe before it is read.
    assert!(log.len() > 1_000);
}

#[test]
fn a_full_disk_costs_the_trace_and_nothing_else() {
    let (_folder, config) = config("sender");
    let mut command = node("sender", &config);
    let ended = output(command.args(["--for", "1500ms", "--trace", "/dev/full"]));
    let log = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{log}");
    assert!(log.contains("the trace ends here"), "{log}");
    assert!(log.contains("/dev/full is incomplete"), "{log}");
    assert!(!log.contains("panicked"), "{log}");
}

#[test]
fn nodes_of_a_run_die_with_it_however_it_ends() {
    let out = tempfile::tempdir().expect("a scratch folder");
    let (run, _logs) = run_processes(out.path(), "duration-s=600");
    let nodes = || processes_with(out.path()).len();
    // The run itself, a sender and a receiver.
    until("its nodes run", || nodes() >= 3);
    run.kill();
    until("its nodes are gone", || nodes() == 0);
}

#[test]
fn a_node_that_a_signal_kills_against_the_scenario_fails_the_run() {
    let out = tempfile::tempdir().expect("a scratch folder");
    let (run, logs) = run_processes(out.path(), "duration-s=10");
    let nodes = out.path().join("nodes");
    until("the receiver has cycles", || {
        let trace = std::fs::read_to_string(nodes.join("bypass.csv"));
        trace.is_ok_and(|trace| trace.lines().count() > 100)
    });
    let receiver = processes_with(&nodes.join("bypass.toml"));
    assert_eq!(receiver.len(), 1, "{receiver:?}");
    let mut kill = Command::new("kill");
    let killed = kill.args(["-ABRT", &receiver[0]]).status();
    assert!(killed.expect("kill is there").success());
    // An expectation that is not met.
    assert_eq!(run.wait().code(), Some(3), "{}", run.log());

    let read = |file: &Path| std::fs::read_to_string(file).expect("a file");
    let summary = read(&out.path().join("summary.json"));
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    let verdicts = summary["expectations"].as_array().expect("a list");
    let failed: Vec<_> = verdicts.iter().filter(|one| one["met"] == false).collect();
    let [death] = failed.as_slice() else {
        panic!("{failed:?}");
    };
    let text = |field: &str| death[field].as_str().unwrap_or_default();
    assert_eq!(death["receiver"], "bypass", "{death}");
    assert!(text("field").starts_with("process at "), "{death}");
    let signal = "killed by signal: 6 (SIGABRT)";
    assert!(text("received").starts_with(signal), "{death}");
    assert!(text("expected").contains("INFO"), "its last lines: {death}");
    // The output for people has it, too.
    let said = read(&logs.path().join("out")) + &run.log();
    assert!(said.contains(signal), "{said}");
    // The rest of the run is there.
    let cycles = summary["receivers"]["bypass"]["cycles"].as_u64();
    // A hundred rows had been traced, of which the last may be cut off.
    assert!(cycles > Some(90), "{summary}");
}

/// Starts a run of two nodes as processes. Returns it, and the folder of its output.
fn run_processes(out: &Path, set: &str) -> (Process, TempDir) {
    let logs = tempfile::tempdir().expect("a scratch folder");
    let said = File::create(logs.path().join("out")).expect("a file");
    let mut run = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    run.args(["run", "beat", "--processes", "--receivers", "bypass"])
        .args(["--set", set, "--set", "expect=[]", "--out"])
        .arg(out)
        .stdout(said);
    let run = Process::start("the run", &mut run, &logs.path().join("log"));
    (run, logs)
}

/// The processes that have a path on their command line.
fn processes_with(path: &Path) -> Vec<String> {
    let path = path.to_str().expect("a plain path").as_bytes();
    let processes = std::fs::read_dir("/proc").expect("Linux").flatten();
    let has_path = |process: &DirEntry| {
        let line = std::fs::read(process.path().join("cmdline"));
        line.is_ok_and(|line| line.windows(path.len()).any(|part| part == path))
    };
    let those = processes.filter(has_path);
    those
        .map(|process| process.file_name().to_string_lossy().into_owned())
        .collect()
}
