//! A sender, and receivers that follow it, as real processes.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use coaxle_test_process::{Process, output};
use coaxle_tests::ports::free_endpoint;
use tempfile::TempDir;

/// A sender, and receivers that follow it, or other nodes. Each listens, as nothing is forwarded between peers.
pub(crate) struct Line {
    pub(crate) folder: TempDir,
    pub(crate) endpoints: Vec<String>,
    pub(crate) nodes: Vec<Process>,
}

impl Line {
    /// The sender alone, whose axis rests.
    pub(crate) fn new() -> Self {
        Self::moving(0.0, 0.0)
    }

    /// The sender alone, with this velocity of its axis, u/s, and this drift of its clock, ppm.
    pub(crate) fn moving(velocity: f64, drift_ppm: f64) -> Self {
        let mut line = Self {
            folder: tempfile::tempdir().expect("a scratch folder"),
            endpoints: Vec::new(),
            nodes: Vec::new(),
        };
        let sender = format!(
            "cycle-time-us = 2000\nlab.clock = {{ drift-ppm = {drift_ppm} }}\n[[axis]]\nid = 3\nname = 'belt'\n[axis.program]\nstart-velocity = {velocity}\n\
             limits = {{ velocity = 100, acceleration = 100, jerk = 1000 }}\nsteps = []\n"
        );
        line.start_with("sender", "belt", &sender, &["--lab"]);
        line
    }

    pub(crate) fn start(&mut self, role: &str, name: &str, config: &str) {
        self.start_with(role, name, config, &[]);
    }

    pub(crate) fn start_with(&mut self, role: &str, name: &str, config: &str, options: &[&str]) {
        let endpoint = free_endpoint();
        let file = self.folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, format!("name = '{name}'\n{config}")).expect("a config");
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.arg(role).arg(file).stdin(Stdio::null());
        command.args(["--listen", &endpoint]).args(options);
        for other in &self.endpoints {
            command.args(["--connect", other]);
        }
        self.endpoints.push(endpoint);
        let node = Process::start(name, &mut command, &self.log(name));
        self.nodes.push(node);
    }

    pub(crate) fn receive(&mut self, name: &str, master: &str) {
        let config = format!("cycle-time-us = 2000\nmaster = {master}\n");
        self.start("receiver", name, &config);
    }

    pub(crate) fn log(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(format!("{name}.log"))
    }

    pub(crate) fn run_tool(&self, words: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.args(words);
        for endpoint in &self.endpoints {
            command.args(["--connect", endpoint]);
        }
        output(&mut command)
    }
}

pub(crate) fn log_text(log: &Path) -> String {
    std::fs::read_to_string(log).unwrap_or_default()
}

pub(crate) fn printed(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}
