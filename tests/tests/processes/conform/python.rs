//! Python with Zenoh, where it is installed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An interpreter that has it.
pub(crate) struct Python(PathBuf);

impl Python {
    /// Finds an interpreter; none, with a note on the output, where there is none.
    pub(crate) fn find() -> Option<Self> {
        coaxle_tests::python::with("zenoh").map(Self)
    }

    /// Command of one of our scripts.
    pub(crate) fn script(&self, name: &str) -> [PathBuf; 2] {
        [self.0.clone(), root().join("tests/python").join(name)]
    }

    /// The faults, and the rule that each breaks.
    pub(crate) fn faults(&self) -> BTreeMap<String, String> {
        let [python, script] = self.script("faulty.py");
        let listed = Command::new(python).arg(script).arg("--list").output();
        let listed = listed.expect("it runs");
        serde_json::from_slice(&listed.stdout).expect("a list")
    }
}

/// The folder of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
