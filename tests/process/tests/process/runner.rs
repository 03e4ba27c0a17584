//! The runner of `.ci/run`, which notes slow tests.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

/// Lock for one test at a time: a program that is still open for writing in a process that another test just starts cannot be run.
static TURN: Mutex<()> = Mutex::new(());

/// Runs the runner with a script as test program. Returns its output and notes.
fn run(script: &str) -> (Output, String) {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().expect("a scratch folder");
    let program = folder.path().join("saw_under-0123abc");
    std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).expect("a program");
    std::fs::set_permissions(&program, Permissions::from_mode(0o755)).expect("it is made");
    let notes = folder.path().join("notes");
    let runner = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.ci/test-runner");
    let ran = Command::new(runner)
        .arg(&program)
        .arg("saws")
        .env("COAXLE_TEST_NOTES", &notes)
        .env("SLOW_S", "30")
        .output();
    (
        ran.expect("bash is there"),
        std::fs::read_to_string(notes).unwrap_or_default(),
    )
}

#[test]
fn slow_tests_are_noted_and_the_output_stays_as_it_is() {
    let (ran, notes) = run("echo 'test it_cuts ... ok <30.125s>'
         echo 'test it_waits - should panic ... ok <29.900s>'
         echo 'test it_fails ... FAILED <131.000s>'
         echo 'test result: FAILED. 2 passed; 1 failed; finished in 191.02s'
         echo \"$@\"; exit 101");
    assert_eq!(ran.status.code(), Some(101));
    assert_eq!(
        String::from_utf8_lossy(&ran.stdout),
        "test it_cuts ... ok\n\
         test it_waits - should panic ... ok\n\
         test it_fails ... FAILED\n\
         test result: FAILED. 2 passed; 1 failed; finished in 191.02s\n\
         saws -Z unstable-options --report-time\n"
    );
    assert_eq!(
        notes,
        "    30.1 s  saw_under: it_cuts\n   131.0 s  saw_under: it_fails\n"
    );
}

#[test]
fn a_program_that_crashes_fails() {
    let (ran, notes) = run("echo 'test it_cuts ... ok <0.001s>'; kill -SEGV $$");
    assert!(!ran.status.success());
    assert_eq!(ran.stdout, b"test it_cuts ... ok\n");
    assert_eq!(notes, "");
}

/// Checks that the compiler here measures tests by these flags, as this very program does.
#[test]
fn the_flags_are_known() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let program = std::env::current_exe().expect("this program");
    let ran = Command::new(program)
        .args(["--list", "-Z", "unstable-options", "--report-time"])
        .env("RUSTC_BOOTSTRAP", "1")
        .output();
    let ran = ran.expect("it runs");
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
}
