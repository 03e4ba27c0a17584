//! Commands that examine files.

use std::path::Path;
use std::process::{Command, Output};

use crate::shared::text;

/// A command of the tool that examines files.
pub(crate) struct Tool {
    pub(crate) command: &'static str,
    /// The folder of its examples.
    pub(crate) files: &'static str,
}

impl Tool {
    pub(crate) fn started(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle"));
        command.arg(self.command).args(arguments);
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.started(arguments).output().expect("the tool starts")
    }

    /// Checks that the command fails with one line that has this text.
    pub(crate) fn refused(&self, arguments: &[&str], expected: &str) {
        let output = self.run(arguments);
        let said = text(&output.stdout) + &text(&output.stderr);
        let code = output.status.code();
        // A malformed file fails; a request that a block refuses is refused.
        assert!(matches!(code, Some(1 | 4 | 78)), "{arguments:?}: {said}");
        assert_eq!(said.lines().count(), 1, "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }

    pub(crate) fn shipped(&self, name: &str) -> String {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .join(self.files);
        let path = folder.join(name);
        path.to_str().expect("a plain path").to_owned()
    }
}
