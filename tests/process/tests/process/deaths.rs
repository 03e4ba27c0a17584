//! Processes that die while a test waits: the report comes within a second, with the signal and the last lines.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, Stdio};
use std::time::Duration;

use coaxle_test_process::{Process, assert_alive, output, until};
use tempfile::TempDir;

/// Logs two lines, then runs this command.
fn node(folder: &TempDir, name: &str, then: &str) -> Process {
    let mut command = Command::new("sh");
    let script = format!("echo first >&2; echo last >&2; {then}");
    command.args(["-c", &script]).stdin(Stdio::null());
    let node = Process::start(name, &mut command, &folder.path().join(name));
    until("it has started", || node.logged("last"));
    node
}

/// The message of the panic that this ends in.
fn panic_of(what: impl FnOnce()) -> String {
    let panic = catch_unwind(AssertUnwindSafe(what)).expect_err("it fails");
    *panic.downcast::<String>().expect("a message")
}

/// Kills the process from outside, as a fault of its own would.
fn die(node: &Process, signal: &str) {
    let process = node.id().to_string();
    let sent = Command::new("kill").args([signal, &process]).status();
    assert!(sent.expect("kill is there").success());
}

const RUNS_ON: &str = "exec sleep 60";

#[test]
fn a_node_that_is_killed_while_a_test_waits_is_reported_with_its_signal_and_its_last_lines() {
    for (signal, name) in [("-KILL", "9 (SIGKILL)"), ("-ABRT", "6 (SIGABRT)")] {
        let folder = tempfile::tempdir().expect("a scratch folder");
        let line = node(&folder, "line", RUNS_ON);
        let saw = node(&folder, "saw", RUNS_ON);
        let mut looks = 0;
        let said = panic_of(|| {
            until("the saw follows the line", || {
                looks += 1;
                if looks == 3 {
                    die(&line, signal);
                }
                // A wait of one second checks fifty times.
                assert!(looks < 50, "the death is not reported");
                false
            });
        });
        // Where the system keeps cores, the status includes that one was dumped.
        let said = said.replace(" (core dumped)", "");
        let expected = format!(
            "line was killed by signal: {name}, while the test waited: the saw follows the line\n\
             the last lines of its log:\n  first\n  last"
        );
        assert_eq!(said, expected);
        drop((line, saw));
    }
}

#[test]
fn a_crash_that_no_wait_has_seen_fails_the_test_at_its_end() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let line = node(&folder, "line", RUNS_ON);
    die(&line, "-ABRT");
    until_gone(&line);
    let said = panic_of(|| drop(line));
    assert!(
        said.starts_with("line was killed by signal: 6 (SIGABRT)"),
        "{said}"
    );
}

#[test]
fn a_node_that_ends_by_itself_is_reported_with_its_exit_code() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let _line = node(&folder, "line", "exit 5");
    let said = panic_of(|| until("the saw follows", || false));
    assert!(
        said.starts_with("line ended with exit code 5, while"),
        "{said}"
    );
}

#[test]
fn a_tool_that_waits_for_a_node_is_not_waited_for_once_the_node_is_gone() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let _line = node(&folder, "line", "exit 5");
    let said = panic_of(|| {
        let _ = output(Command::new("sleep").arg("60"));
    });
    assert!(said.contains("while the test waited: 60 ends"), "{said}");
}

#[test]
fn an_end_that_the_test_has_asked_for_is_none_of_them() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let line = node(&folder, "line", RUNS_ON);
    line.kill();
    let saw = node(
        &folder,
        "saw",
        "trap 'exit 0' TERM; while true; do sleep 0.01; done",
    );
    saw.signal("TERM");
    assert!(saw.wait().success());
    assert_alive("nothing");
    drop((line, saw));
}

#[test]
fn what_a_tool_prints_is_read_however_long_it_is() {
    let printed =
        output(Command::new("sh").args(["-c", "head -c 300000 /dev/zero; echo no >&2; exit 3"]));
    assert_eq!(printed.status.code(), Some(3));
    assert_eq!(printed.stdout.len(), 300_000);
    assert_eq!(printed.stderr, b"no\n");
}

#[test]
fn processes_of_another_test_are_not_looked_after_here() {
    let folder = tempfile::tempdir().expect("a scratch folder");
    let other = std::thread::spawn(move || {
        let line = node(&folder, "line", "exit 0");
        until_gone(&line);
        line
    });
    let _line = other.join().expect("it has ended");
    assert_alive("nothing");
}

fn until_gone(node: &Process) {
    while !node.has_ended() {
        std::thread::park_timeout(Duration::from_millis(5));
    }
}
