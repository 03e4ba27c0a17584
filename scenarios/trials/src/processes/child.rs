//! A node as a process.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context, bail};
use coaxle_clock::Span;
use coaxle_host::network::transport::ZENOH_RUNTIME;
use coaxle_os::machine;
use coaxle_os::{ChildSignal, Os, System};

use super::death::Death;
use super::memory::MemoryWatch;

/// Role of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeRole {
    Sender,
    Receiver,
}

/// Output of a node about its cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeOutput {
    /// Every cycle; with a receiver, its raw arrivals beside it.
    Trace,
    /// The raw arrivals of a receiver, and nothing else.
    Arrivals,
}

/// A node's process, and the files of all its runs.
#[derive(Debug)]
pub(crate) struct Child {
    role: NodeRole,
    name: String,
    config: PathBuf,
    output: NodeOutput,
    files: Vec<PathBuf>,
    run_for: Option<Span>,
    process: Option<std::process::Child>,
    memory: Option<MemoryWatch>,
}

/// Time that a node may take to end by itself.
// Far more than a last cycle and the flush of a node's files take: beyond it the node hangs.
const END_TIMEOUT: Span = Span::from_secs(10);
/// Number of log lines that a death is reported with: a node's error and its causes.
const LAST_LINES: usize = 5;

impl Child {
    pub(super) fn new(role: NodeRole, name: &str, config: PathBuf, output: NodeOutput) -> Self {
        Self {
            role,
            name: name.to_owned(),
            config,
            output,
            files: Vec::new(),
            run_for: None,
            process: None,
            memory: None,
        }
    }

    /// The file of each run, oldest first.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(PathBuf::as_path)
    }

    /// Ends by itself after this time from the next start on, if it is not ended before.
    pub(crate) fn end_after(&mut self, time: Span) {
        self.run_for = Some(time);
    }

    pub(crate) fn start(&mut self) -> anyhow::Result<()> {
        // Each run has files of its own: a restarted node would overwrite what happened before.
        let run = self.files.len();
        let file = |ending: &str| {
            let name = match run {
                0 => format!("{}.{ending}", self.name),
                run => format!("{}.{run}.{ending}", self.name),
            };
            self.config.with_file_name(name)
        };
        let cycles = file("csv");
        let log = file("log");
        let log = File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
        let program = std::env::current_exe().context("cannot find this program")?;
        let (runtime, threads) = ZENOH_RUNTIME;
        let run_for = self.run_for.map(|time| format!("{}s", time.as_secs_f64()));
        let mut command = Command::new(program);
        command
            .arg(match self.role {
                NodeRole::Sender => "sender",
                NodeRole::Receiver => "receiver",
            })
            .arg(&self.config)
            // A scenario is an experiment.
            .arg("--lab")
            .arg(match self.output {
                NodeOutput::Trace => "--trace",
                NodeOutput::Arrivals => "--arrivals",
            })
            .arg(&cycles)
            .args(run_for.iter().flat_map(|time| ["--for", time]))
            // The node dies with this program, even if that is killed.
            .args(["--parent", &std::process::id().to_string()])
            .env(runtime, threads)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log);
        // Ctrl-C is for the run: it ends its nodes itself, and reads their files.
        // Otherwise the terminal would send it to the whole group.
        Os::ignore_terminal_signals(&mut command);
        let process = command
            .spawn()
            .with_context(|| format!("cannot start {}", self.name))?;
        self.process = Some(process);
        self.memory = Some(MemoryWatch::new(machine::now()));
        self.files.push(cycles);
        Ok(())
    }

    /// The death of the node, once, if a signal killed it.
    ///
    /// # Errors
    /// A node that ends by itself ends the run: its log says why. So does one whose memory grows.
    pub(crate) fn check(&mut self) -> anyhow::Result<Option<Death>> {
        let Some(process) = &mut self.process else {
            return Ok(None);
        };
        let number = process.id();
        match process.try_wait().context("cannot look after a node")? {
            None => self.check_memory(number).map(|()| None),
            Some(status) => self.ended(status, "early").map(Some),
        }
    }

    /// Result for a node that has ended early, or badly.
    fn ended(&mut self, status: ExitStatus, how: &str) -> anyhow::Result<Death> {
        // Otherwise the next check would report the death again.
        self.process = None;
        let death = Death::of(&self.name, status, machine::now(), || self.last_lines());
        death.with_context(|| {
            format!(
                "{} ended {how} ({status}): {}",
                self.name,
                self.last_words()
            )
        })
    }

    fn check_memory(&mut self, process: u32) -> anyhow::Result<()> {
        let now = machine::now();
        let Some(memory) = self.memory.as_mut().filter(|memory| memory.is_due(now)) else {
            return Ok(());
        };
        // Unknown where the system does not report it, or when the node has just ended.
        match Os::resident_memory(process) {
            Some(bytes) => memory.look(now, bytes).with_context(|| self.name.clone()),
            None => Ok(()),
        }
    }

    /// Kills the node; its death, if a signal did so before.
    pub(super) fn kill(&mut self) -> anyhow::Result<Option<Death>> {
        // First, since a crash before the ordered kill must not pass for it.
        let death = self.check()?;
        if let Some(mut process) = self.process.take() {
            process.kill().context("cannot kill a node")?;
            process.wait().context("cannot wait for a node")?;
        }
        Ok(death)
    }

    pub(super) fn freeze(&self) -> anyhow::Result<()> {
        self.signal(ChildSignal::Freeze)
    }

    pub(super) fn resume(&self) -> anyhow::Result<()> {
        self.signal(ChildSignal::Resume)
    }

    pub(crate) fn ask_to_end(&self) -> anyhow::Result<()> {
        // A frozen node receives nothing.
        self.signal(ChildSignal::Resume)?;
        self.signal(ChildSignal::End)
    }

    /// Waits for the requested end; returns the node's death, if a signal killed it instead.
    pub(crate) fn wait_for_end(&mut self) -> anyhow::Result<Option<Death>> {
        let Some(mut process) = self.process.take() else {
            return Ok(None);
        };
        let asked = machine::now();
        loop {
            if let Some(status) = process.try_wait().context("cannot wait for a node")? {
                return match status.success() {
                    true => Ok(None),
                    false => self.ended(status, "badly").map(Some),
                };
            }
            if machine::now() - asked > END_TIMEOUT {
                process.kill().context("cannot kill a node")?;
                process.wait().context("cannot wait for a node")?;
                bail!("{} did not end within {END_TIMEOUT}", self.name);
            }
            // Polled, as the standard library waits for a process without any timeout.
            std::thread::park_timeout(Duration::from_millis(5));
        }
    }

    fn signal(&self, signal: ChildSignal) -> anyhow::Result<()> {
        if let Some(process) = &self.process {
            Os::signal(process, signal).with_context(|| format!("cannot signal {}", self.name))?;
        }
        Ok(())
    }

    fn last_words(&self) -> String {
        self.last(1)
    }

    fn last_lines(&self) -> String {
        self.last(LAST_LINES)
    }

    /// The last `count` lines of the log, with a slash between them.
    fn last(&self, count: usize) -> String {
        let log = self.log();
        let bytes = std::fs::read(&log).unwrap_or_default();
        // A crash may leave half a character.
        let text = String::from_utf8_lossy(&bytes);
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        let mut last: Vec<_> = lines.rev().take(count).collect();
        last.reverse();
        match last.as_slice() {
            [] => format!("nothing in {}", log.display()),
            lines => lines.join(" / "),
        }
    }

    /// The log of the newest run.
    pub(crate) fn log(&self) -> PathBuf {
        let newest = self.files.last().unwrap_or(&self.config);
        newest.with_extension("log")
    }
}

impl Drop for Child {
    /// No node is left running, on any failure.
    fn drop(&mut self) {
        if let Some(process) = &mut self.process {
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}
