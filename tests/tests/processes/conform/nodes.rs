//! Nodes as processes, and the tool that tries them.

use std::fs::File;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use coaxle_test_process::{Process, output};
use coaxle_tests::ports::free_endpoint;
use serde_json::Value;
use tempfile::TempDir;

/// Nodes that run until this is dropped. Each listens, and connects to those before it.
pub(crate) struct Nodes {
    folder: TempDir,
    endpoints: Vec<String>,
    processes: Vec<Process>,
}

/// Output of the tool.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) exit: i32,
    pub(crate) json: Value,
    pub(crate) log: String,
}

impl Default for Nodes {
    fn default() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a scratch folder"),
            endpoints: Vec::new(),
            processes: Vec::new(),
        }
    }
}

impl Nodes {
    /// Starts one of our nodes.
    pub(crate) fn start(&mut self, role: &str, name: &str, config: &str) {
        let file = self.folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, format!("name = '{name}'\n{config}")).expect("a config");
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.arg(role).arg(file);
        let endpoint = free_endpoint();
        command.args(["--listen", &endpoint]);
        // Peers forward nothing for each other, so that each needs a link to each.
        for other in &self.endpoints {
            command.args(["--connect", other]);
        }
        self.spawn(name, &mut command, endpoint);
    }

    /// Runs a script as a node, with its name, its endpoint, and options.
    pub(crate) fn run(&mut self, script: &[PathBuf; 2], name: &str, options: &[&str]) {
        let endpoint = free_endpoint();
        let mut command = Command::new(&script[0]);
        // No files of bytecode beside the sources.
        command.arg("-B").arg(&script[1]).arg(name);
        command.arg(&endpoint).args(options);
        self.spawn(name, &mut command, endpoint);
    }

    /// Runs `coaxle conform` with these arguments.
    pub(crate) fn conform(&self, words: &[&str]) -> Report {
        let mut all = vec!["conform"];
        all.extend(words);
        all.extend(["--format", "json"]);
        self.run_tool(&all)
    }

    /// Runs the tool with these arguments, connected to the nodes.
    pub(crate) fn run_tool(&self, words: &[&str]) -> Report {
        let mut command = Command::new(env!("CARGO_BIN_EXE_coaxle-under-test"));
        command.args(words).stdin(Stdio::null());
        for endpoint in &self.endpoints {
            command.args(["--connect", endpoint]);
        }
        let output = output(&mut command);
        Report {
            exit: output.status.code().unwrap_or(-1),
            // A command that failed has no JSON, which its test judges by the exit code.
            json: serde_json::from_slice(&output.stdout).unwrap_or_default(),
            log: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Output of a node so far.
    pub(crate) fn printed(&self, name: &str) -> String {
        let file = self.folder.path().join(format!("{name}.out"));
        std::fs::read_to_string(file).unwrap_or_default()
    }

    fn spawn(&mut self, name: &str, command: &mut Command, endpoint: String) {
        let file = |ending| self.folder.path().join(format!("{name}.{ending}"));
        // A file, since nobody reads a pipe while the test waits.
        let out = File::create(file("out")).expect("a file");
        command.stdin(Stdio::null()).stdout(out);
        let process = Process::start(name, command, &file("log"));
        self.processes.push(process);
        self.endpoints.push(endpoint);
    }
}

/// The rules that are broken, by name.
pub(crate) fn broken(report: &Value) -> Vec<String> {
    let rules = report["rules"].as_array().into_iter().flatten();
    let broken = rules.filter(|rule| rule["outcome"] == "broken");
    broken
        .map(|rule| rule["rule"].as_str().unwrap_or_default().to_owned())
        .collect()
}
