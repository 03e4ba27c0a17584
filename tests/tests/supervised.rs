//! Nodes as whoever supervises them sees them: exit codes, signals, the service manager, what becomes of them when their
//! parent dies, and a log or a disk that takes nothing.

use std::fs::File;
use std::io::Read;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use coaxle_clock::Span;
use coaxle_host::machine;
use tempfile::TempDir;

/// For whatever takes no time: the machine may be very busy.
const PATIENCE: Span = Span::from_secs(60);

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

/// The node with its log in a file; waits until it says that it runs.
fn running(command: &mut Command, log: &Path) -> Child {
    let child = command
        .stderr(File::create(log).expect("a log"))
        .spawn()
        .expect("it starts");
    until("it runs", || said(log).contains("running"));
    child
}

fn said(log: &Path) -> String {
    std::fs::read_to_string(log).unwrap_or_default()
}

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = machine::now();
    while !is_so() {
        assert!(machine::now() - begin < PATIENCE, "{what}");
        std::thread::park_timeout(Duration::from_millis(10));
    }
}

fn ended(mut child: Child) -> ExitStatus {
    let mut status = None;
    until("it ends", || {
        status = child.try_wait().expect("a child");
        status.is_some()
    });
    status.expect("it ended")
}

fn signal(child: &Child, signal: &str) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args([signal, &pid]).status();
    assert!(sent.expect("kill is there").success());
}

#[test]
fn the_exit_code_says_what_a_node_came_to() {
    let (folder, sender) = config("sender");
    let done = node("sender", &sender)
        .args(["--for", "200ms"])
        .output()
        .expect("it starts");
    assert_eq!(done.status.code(), Some(0));

    let (_other, receiver) = config("receiver");
    let alone = node("receiver", &receiver)
        .args(["--for", "200ms"])
        .output()
        .expect("it starts");
    assert_eq!(alone.status.code(), Some(5));
    let log = String::from_utf8_lossy(&alone.stderr);
    assert!(log.contains("no data came"), "{log}");

    let missing = folder.path().join("no-such-file.toml");
    let failed = node("sender", &missing).output().expect("it starts");
    assert_eq!(failed.status.code(), Some(78));
    let wrong = node("sender", &sender).arg("--no-such-flag").output();
    assert_eq!(wrong.expect("it starts").status.code(), Some(2));
}

#[test]
fn signals_end_a_node_cleanly() {
    let (folder, config) = config("sender");
    for (name, ended_by) in [
        ("-HUP", "HungUp"),
        ("-TERM", "Terminated"),
        ("-INT", "Interrupted"),
    ] {
        // What these tests were started to ignore, under nohup, their nodes ignore too.
        if name == "-HUP" && ignores_hang_up() {
            continue;
        }
        let log = folder.path().join("log");
        let child = running(&mut node("sender", &config), &log);
        signal(&child, name);
        assert!(ended(child).success(), "{name}");
        assert!(
            said(&log).contains(&format!("ended={ended_by}")),
            "{}",
            said(&log)
        );
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
        .args(["-c", "trap '' HUP; exec \"$@\"", "sh"])
        .arg(env!("CARGO_BIN_EXE_coaxle-under-test"))
        .arg("sender")
        .arg(config);
    let child = running(&mut command, &log);
    signal(&child, "-HUP");
    signal(&child, "-TERM");
    assert!(ended(child).success());
    assert!(said(&log).contains("ended=Terminated"), "{}", said(&log));
}

#[test]
fn the_service_manager_hears_that_a_node_runs_that_its_cycle_does_and_that_it_ends() {
    let (folder, config) = config("sender");
    let path = folder.path().join("notify");
    let manager = UnixDatagram::bind(&path).expect("a socket");
    manager
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("a time is set");
    let next = || {
        let mut bytes = [0; 256];
        let length = manager.recv(&mut bytes).expect("it says something");
        String::from_utf8_lossy(&bytes[..length]).trim().to_owned()
    };
    let child = node("sender", &config)
        .env("NOTIFY_SOCKET", &path)
        .env("WATCHDOG_USEC", "300000")
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    assert_eq!(next(), "READY=1");
    for _ in 0..3 {
        assert_eq!(next(), "WATCHDOG=1");
    }
    signal(&child, "-TERM");
    until("it says that it ends", || next() == "STOPPING=1");
    assert!(ended(child).success());
}

#[test]
fn nobody_waits_for_a_log_that_is_full_or_not_read() {
    let (_folder, config) = config("sender");
    let full = File::options().write(true).open("/dev/full");
    let mut verbose = node("sender", &config);
    verbose.args(["--for", "500ms", "-vv"]);
    let child = verbose.stderr(full.expect("it is there")).spawn();
    assert!(ended(child.expect("it starts")).success());

    // A pipe that nobody reads, until the node has ended.
    let mut child = verbose.stderr(Stdio::piped()).spawn().expect("it starts");
    let mut pipe = child.stderr.take().expect("a pipe");
    assert!(ended(child).success());
    let mut log = Vec::new();
    pipe.read_to_end(&mut log).expect("what fitted is there");
    assert!(log.len() > 1_000);
}

#[test]
fn a_full_disk_costs_the_trace_and_nothing_else() {
    let (_folder, config) = config("sender");
    let output = node("sender", &config)
        .args(["--for", "1500ms", "--trace", "/dev/full"])
        .output()
        .expect("it starts");
    let log = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{log}");
    assert!(log.contains("the trace ends here"), "{log}");
    assert!(log.contains("/dev/full is incomplete"), "{log}");
    assert!(!log.contains("panicked"), "{log}");
}

#[test]
fn nodes_of_a_run_die_with_it_however_it_ends() {
    let out = tempfile::tempdir().expect("a scratch folder");
    let mut run = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
    run.args(["run", "beat", "--processes", "--receivers", "bypass"])
        .args(["--set", "duration-s=600", "--out"])
        .arg(out.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut run = run.spawn().expect("it starts");
    let nodes = || processes_with(out.path());
    // The run itself, a sender and a receiver.
    until("its nodes run", || nodes() >= 3);
    run.kill().expect("it is killed");
    run.wait().expect("it ended");
    until("its nodes are gone", || nodes() == 0);
}

/// How many processes have a path on their command line.
fn processes_with(path: &Path) -> usize {
    let path = path.to_str().expect("a plain path").as_bytes();
    let processes = std::fs::read_dir("/proc").expect("Linux").flatten();
    let lines = processes.filter_map(|process| std::fs::read(process.path().join("cmdline")).ok());
    lines
        .filter(|line| line.windows(path.len()).any(|part| part == path))
        .count()
}
