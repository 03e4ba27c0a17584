//! Bounds of what a node and the tool take: every row of `docs/LIMITS.md`, readers with little memory, and the resources
//! that a start needs.

mod contents;
mod door;
mod files;
mod memory;
mod page;
mod start;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use coaxle_test_process::output;

/// The tool, and a folder for its files.
pub(crate) struct Bench {
    folder: tempfile::TempDir,
}

/// The program under test.
const TOOL: &str = env!("CARGO_BIN_EXE_coaxle-under-test");

/// An axis of a sender at standstill.
pub(crate) const AXIS: &str = "[[axis]]\nid = 1\nname = 'a'\n[axis.program]\nlimits = { velocity = 1000.0, \
                               acceleration = 1000.0, jerk = 10000.0 }\n";

impl Bench {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Path of a file with this content.
    pub(crate) fn file(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        std::fs::write(&path, content).expect("a file");
        shown(&path)
    }

    /// Path of a file of zeros, which takes no room on the disk.
    pub(crate) fn zeros(&self, name: &str, bytes: u64) -> String {
        let path = self.path(name);
        let file = std::fs::File::create(&path).expect("a file");
        file.set_len(bytes).expect("a length");
        shown(&path)
    }

    /// Checks a sender's config.
    pub(crate) fn sender(&self, text: &str) -> ToolEnd {
        let text = format!("name = 's'\n{text}");
        run(&["sender", &self.file("s.toml", text), "--check"])
    }

    /// Checks a sender's config of an experiment.
    pub(crate) fn sender_in_lab(&self, text: &str) -> ToolEnd {
        let text = format!("name = 's'\n{text}");
        run(&["sender", &self.file("s.toml", text), "--check", "--lab"])
    }

    /// Checks a receiver's config.
    pub(crate) fn receiver(&self, text: &str) -> ToolEnd {
        let text = format!("name = 'r'\ncycle-time-us = 1000\n{text}");
        run(&["receiver", &self.file("r.toml", text), "--check"])
    }

    /// Checks a scenario.
    pub(crate) fn scenario(&self, text: &str) -> ToolEnd {
        let text = format!("title = 't'\n{text}");
        run(&["check", &self.file("t.toml", text)])
    }

    /// Checks a cam file.
    pub(crate) fn cam(&self, text: &str) -> ToolEnd {
        run(&["cam", "check", &self.file("c.toml", text)])
    }
}

/// The repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

pub(crate) fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// End of the tool: its exit code, and all that it printed.
pub(crate) struct ToolEnd {
    code: Option<i32>,
    text: String,
}

/// Runs the tool.
pub(crate) fn run(words: &[&str]) -> ToolEnd {
    end_of(&output(Command::new(TOOL).args(words)))
}

/// Runs the tool with at most this much of something, as a shell sets it: `-v` is its memory in KiB, `-n` its
/// descriptors. None where no shell can.
#[expect(
    clippy::print_stdout,
    reason = "who runs the tests reads what was not tested"
)]
pub(crate) fn run_with(limits: &[(&str, u64)], words: &[&str]) -> Option<ToolEnd> {
    let set = limits
        .iter()
        .map(|(of, most)| format!("ulimit {of} {most} || exit 99; "));
    let script = format!("{}exec \"$0\" \"$@\"", set.collect::<String>());
    let mut command = Command::new("sh");
    command.args(["-c", &script, TOOL]).args(words);
    // A backtrace takes seconds, and hides the cause.
    command.env("RUST_BACKTRACE", "0");
    let end = end_of(&output(&mut command));
    if end.code == Some(99) {
        println!("not tested: this shell sets no limits: {}", end.text);
        return None;
    }
    Some(end)
}

/// Memory that the program itself takes, KiB of addresses, as it grows with what it can do: the least limit at which the system loads it,
/// to a MiB. None where no shell sets limits.
pub(crate) fn program_memory() -> Option<u64> {
    static FOUND: OnceLock<Option<u64>> = OnceLock::new();
    *FOUND.get_or_init(|| {
        // A signal, or the shell's 126 and 127: it is not loaded.
        let is_loaded = |mib: u64| {
            let end = run_with(&[("-v", mib << 10)], &["--version"])?;
            Some(end.code.is_some_and(|code| code < 126))
        };
        let (mut too_little, mut enough) = (1, 1_024);
        while enough - too_little > 1 {
            let middle = u64::midpoint(too_little, enough);
            match is_loaded(middle)? {
                true => enough = middle,
                false => too_little = middle,
            }
        }
        Some(enough << 10)
    })
}

fn end_of(output: &Output) -> ToolEnd {
    let text = [&output.stdout[..], &output.stderr[..]].concat();
    ToolEnd {
        code: output.status.code(),
        text: String::from_utf8_lossy(&text).into_owned(),
    }
}

impl ToolEnd {
    /// True if it printed this.
    pub(crate) fn says(&self, what: &str) -> bool {
        self.text.contains(what)
    }

    /// Checks that the tool took its input.
    #[track_caller]
    pub(crate) fn is_taken(&self) {
        assert_eq!(self.code, Some(0), "{}", self.text);
    }

    /// Checks that the tool refused its input with this text.
    #[track_caller]
    pub(crate) fn is_refused(&self, why: &str) {
        assert!(
            self.code != Some(0) && self.text.contains(why),
            "expected {why:?}, received {:?}: {}",
            self.code,
            self.text
        );
        self.has_not_crashed();
    }

    /// Checks that it ended by itself, with an exit code of its own and without a panic.
    #[track_caller]
    pub(crate) fn has_not_crashed(&self) {
        let is_own = self.code.is_some_and(|code| code < 128 && code != 101);
        let is_panic =
            self.text.contains("panicked at") || self.text.contains("memory allocation of");
        assert!(is_own && !is_panic, "{:?}: {}", self.code, self.text);
    }
}
