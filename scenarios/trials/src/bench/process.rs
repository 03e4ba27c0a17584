//! A process of a measurement, as its parent holds it.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Stdio};

use anyhow::{Context, bail};
use coaxle_clock::Span;
use coaxle_host::network::transport::ZENOH_RUNTIME;
use coaxle_os::{ChildSignal, Os, System};

use super::plan::{PEER, PeerPlan, PeerReport, READY};

/// A running process, which is killed when this value is dropped.
pub(super) struct Process {
    child: Child,
    out: BufReader<ChildStdout>,
    what: &'static str,
}

impl Process {
    /// Starts a process and waits until it is ready. It ends after `limit` at the latest; `before` comes before the program,
    /// as `nice` would.
    ///
    /// # Errors
    /// It does not start, or fails before it is ready: with its last words.
    pub(super) fn start(
        what: &'static str,
        plan: &PeerPlan,
        limit: Span,
        before: &[String],
    ) -> anyhow::Result<Self> {
        let cannot = || format!("cannot start the {what}");
        // The running program itself: nothing else must be installed, and versions cannot differ.
        let program = std::env::current_exe().context("cannot find this program")?;
        let mut command = match before {
            [] => Command::new(program),
            [first, rest @ ..] => {
                let mut command = Command::new(first);
                command.args(rest).arg(program);
                command
            }
        };
        let (runtime, threads) = ZENOH_RUNTIME;
        let json = serde_json::to_string(plan).with_context(cannot)?;
        command
            // Nobody reads standard error before a failure, and a full pipe would block the process.
            .args([PEER, "--quiet"])
            .args(["--parent", &std::process::id().to_string()])
            .args(["--for", &format!("{}s", limit.as_secs_f64())])
            .arg(json)
            // As for a node's own process; Zenoh reads it once, before its first call.
            .env(runtime, threads)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        // Ctrl-C is for the parent.
        Os::ignore_terminal_signals(&mut command);
        let mut child = command.spawn().with_context(cannot)?;
        let out = child.stdout.take().with_context(cannot)?;
        let mut process = Self {
            child,
            out: BufReader::new(out),
            what,
        };
        let mut line = String::new();
        // An empty line means that the process ended first.
        process.out.read_line(&mut line).with_context(cannot)?;
        if line.trim_end() != READY {
            return Err(process.failed());
        }
        Ok(process)
    }

    /// Processor time used so far; none where the system does not report it.
    pub(super) fn processor_time(&self) -> Option<Span> {
        let time = Os::processor_time(self.child.id())?;
        Some(Span::from_secs_f64(time.as_secs_f64()))
    }

    /// Ends the process, and returns its report.
    ///
    /// # Errors
    /// The process failed: with its last words.
    pub(super) fn end(mut self) -> anyhow::Result<PeerReport> {
        Os::signal(&self.child, ChildSignal::End)
            .with_context(|| format!("cannot end the {}", self.what))?;
        let mut text = String::new();
        // Read before the wait: a report longer than the pipe's buffer would hold the process for ever.
        let read = self.out.read_to_string(&mut text);
        if read.is_err() || text.is_empty() {
            return Err(self.failed());
        }
        let status = self.child.wait();
        let status = status.with_context(|| format!("cannot wait for the {}", self.what))?;
        if !status.success() {
            bail!("the {} ended badly ({status})", self.what);
        }
        serde_json::from_str(&text).with_context(|| format!("what the {} told", self.what))
    }

    /// The reason of the failure, from its output.
    fn failed(mut self) -> anyhow::Error {
        let what = self.what;
        // A process that has not ended by itself would write nothing more.
        let _ = Os::signal(&self.child, ChildSignal::End);
        let mut said = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            let _ = errors.read_to_string(&mut said);
        }
        let line = said.lines().rev().find(|line| !line.trim().is_empty());
        let line = line.unwrap_or("it did not say why");
        let line = line.strip_prefix("error: ").unwrap_or(line);
        anyhow::anyhow!("the {what} failed: {line}")
    }
}

impl Drop for Process {
    /// No process is left running, on any failure.
    fn drop(&mut self) {
        let _ = self.child.kill();
        // Without it a killed process would stay as a zombie.
        let _ = self.child.wait();
    }
}
