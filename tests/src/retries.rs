//! Attempts of tests whose outcome depends on how busy the machine is.

use std::fs::File;
use std::io::Write;

/// Notes the reason why a test tries something again: on its output, and in the file of `.ci/run` that lists such tests. A
/// test that needs that often has a fault.
#[expect(clippy::print_stdout, reason = "so a test says that it tries again")]
pub fn note(test: &str, reason: &str) {
    println!("tried again: {test}: {reason}");
    let Some(notes) = std::env::var_os("COAXLE_TEST_NOTES") else {
        return;
    };
    let reason = reason.lines().next().unwrap_or_default();
    let file = File::options().create(true).append(true).open(notes);
    // Without the file, the note is on the output.
    let _ = file.and_then(|mut file| writeln!(file, "tried again  {test}: {reason}"));
}
