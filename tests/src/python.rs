//! Programs in Python, which are third-party clients and servers, where they are available.

use std::path::{Path, PathBuf};
use std::process::Command;

/// An interpreter that can import `module`: that of `COAXLE_PYTHON`, of target/python, or the machine's. None where none can,
/// with a note on the output: the test that needs it tests nothing.
#[must_use]
#[expect(clippy::print_stdout, reason = "so a test says that it tested nothing")]
pub fn with(module: &str) -> Option<PathBuf> {
    let wish = std::env::var_os("COAXLE_PYTHON").map(PathBuf::from);
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/python/bin/python3");
    // The most explicit first.
    let mut all = wish.into_iter().chain([own, PathBuf::from("python3")]);
    let found = all.find(|python| can_import(python, module));
    if found.is_none() {
        println!("not tested: no python3 with {module}, see docs/CONTRIBUTING.md");
    }
    found
}

fn can_import(python: &Path, module: &str) -> bool {
    let tried = Command::new(python)
        .args(["-c", &format!("import {module}")])
        .output();
    tried.is_ok_and(|tried| tried.status.success())
}
