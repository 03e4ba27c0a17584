//! Command line arguments of every node.

use std::fmt;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use coaxle_clock::Span;
use coaxle_node::config::{ConfigError, TransportConfig};
use coaxle_node::keys::NodeName;
use coaxle_node::lab::{LabFields, NodeFile, WithLab};
use coaxle_node::signal::Instance;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};
use coaxle_os::Trace;
use coaxle_os::machine;
use coaxle_os::{Os, System};
use coaxle_recording::{Facts, Growth, Table};

use crate::cli::parse_duration;
use crate::files::{Attached, Recording, Rows};
use crate::network::credentials::{Credentials, CredentialsFault};
use crate::network::transport::{endpoint, zenoh_config};

/// The arguments of a node; flatten them into those of a program.
#[derive(Clone, Debug, clap::Args)]
pub struct NodeArgs {
    /// The node's config file (TOML)
    pub config: PathBuf,
    /// Stop after this time: 10s, 500ms, 2min … [default: run until Ctrl-C]
    #[arg(long = "for", value_name = "DURATION", value_parser = parse_duration)]
    pub run_for: Option<Span>,
    /// Write every cycle to this file, as CSV with a header line. A receiver also writes its raw
    /// arrivals: trace.csv, trace-arrivals.csv and trace-exchanges.csv
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Record every cycle, the log and the status to this file, as MCAP: docs/RECORDING.md. An
    /// existing file is kept, and the next one gets a number: saw.mcap, saw-2.mcap
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Only check the config and the files it names: print "CONFIG: ok" or the errors
    #[arg(long, conflicts_with_all = ["run_for", "trace", "record"])]
    pub check: bool,
    /// Start with the lab table of the config: injected faults and simulated inputs, for experiments. Without this a config that
    /// has one is refused. Log and status report it
    #[arg(long)]
    pub lab: bool,
    /// Connect here instead of to the endpoints in the config, such as tcp/192.168.1.10:7447; may
    /// be given several times
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint)]
    pub connect: Vec<String>,
    /// Listen here instead of on the endpoints in the config, such as tcp/0.0.0.0:7447 for all
    /// network interfaces; may be given several times
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint)]
    pub listen: Vec<String>,
    /// Terminate with this process, which started this one
    #[arg(long, value_name = "PID", hide = true)]
    pub parent: Option<i32>,
    /// The node's folder of the secure profile, as written by `coaxle secure init`: endpoints are
    /// tls/… then
    #[arg(long, value_name = "DIR")]
    pub secure: Option<PathBuf>,
}

impl NodeArgs {
    /// Reads the config file. Its `lab` says what is injected or simulated, if the node is started for an experiment.
    ///
    /// # Errors
    /// Names the file, the field, what was received and what is expected; a `[lab]` table that was not asked for.
    pub fn load<C: WithLab>(&self) -> anyhow::Result<NodeFile<C>> {
        let NodeFile { config, lab } = NodeFile::load(&self.config)?;
        let lab = match lab {
            // A machine started from a config of an experiment would move with injected faults. The operator has to say so.
            Some(fields) if !self.lab => return Err(self.wrong(fields.refusal()).into()),
            // Asked for without a table: nothing is injected, and log and status still say that it is an experiment.
            None if self.lab => Some(LabFields::default()),
            lab => lab,
        };
        Ok(NodeFile { config, lab })
    }

    /// Error in the config file from a separate check whose text begins with the field, with its line.
    pub fn wrong(&self, reason: impl ToString) -> ConfigError {
        let file = self.file();
        let error = ConfigError::whole(&file, reason);
        // The text is read again: the error was found in parsed values, which know no lines any more.
        match text_file::read(&self.config, MOST_CONFIG_BYTES) {
            Ok(text) => error.in_text(&file, &text),
            Err(_) => error,
        }
    }

    /// The config file's name in error messages.
    #[must_use]
    pub fn file(&self) -> String {
        self.config.display().to_string()
    }

    /// The folder that relative paths in the config start from: the config's own.
    #[must_use]
    pub fn folder(&self) -> &Path {
        // A bare file name has an empty parent, which joins to a path relative to the working directory.
        self.config.parent().unwrap_or(Path::new(""))
    }

    /// Returns the node's transport section with the command line's overrides, checked.
    ///
    /// # Errors
    /// Names the wrong endpoint or setting, or the reason why the certificates are not those of
    /// this node.
    pub fn transport(
        &self,
        node: &NodeName,
        configured: &TransportConfig,
    ) -> anyhow::Result<TransportConfig> {
        // The config's endpoints are replaced as a whole: an added endpoint could never take one away.
        let mut transport = configured.clone();
        if !self.connect.is_empty() {
            transport.connect.clone_from(&self.connect);
        }
        if !self.listen.is_empty() {
            transport.listen.clone_from(&self.listen);
        }
        // Before the folder of the command line is set: that one is relative to the working directory.
        transport.relative_to(self.folder());
        if let Some(folder) = &self.secure {
            transport.secure = Some(folder.clone());
        }
        // The built config is dropped: the check alone counts, so that `--check` finds what a start would refuse.
        zenoh_config(&transport).map_err(|error| self.wrong(format!("{error:#}")))?;
        if let Some(folder) = &transport.secure {
            check_holder(node, folder).map_err(|error| self.wrong(format!("{error:#}")))?;
        }
        Ok(transport)
    }

    /// Creates the trace and the recording of the node's rows, if requested. `instances` are all
    /// parts of the node that have signals, in the order of a row, `columns` the names of the
    /// signals, and `cycle` the interval between rows.
    ///
    /// # Errors
    /// Names the file that cannot be written, or read.
    pub fn rows(
        &self,
        node: &NodeName,
        role: &str,
        instances: Vec<Instance>,
        columns: &[String],
        cycle: Span,
    ) -> anyhow::Result<Rows> {
        let table = Table {
            name: node.to_string(),
            role: role.to_owned(),
            instances,
        };
        // A recording is read long after the run: the facts say by which node and version it was written.
        let facts = [
            ("node", node.as_str()),
            ("role", role),
            ("version", env!("CARGO_PKG_VERSION")),
        ];
        let mut facts: Facts = facts
            .map(|(name, fact)| (name.to_owned(), fact.to_owned()))
            .into();
        if self.lab {
            facts.insert("lab".to_owned(), "true".to_owned());
        }
        let trace = |path| Trace::with_columns(path, columns);
        let trace = self.trace.as_deref().map(trace).transpose()?;
        let recording = self.recording(&table, &facts, cycle)?;
        Ok(Rows::new(table, facts, trace, recording))
    }

    /// Creates the recording, with the config file in it.
    fn recording(
        &self,
        table: &Table,
        facts: &Facts,
        cycle: Span,
    ) -> anyhow::Result<Option<Recording>> {
        let Some(path) = &self.record else {
            return Ok(None);
        };
        // The text as it is, not as parsed: a replay builds the node from the same bytes.
        let config = text_file::read(&self.config, MOST_CONFIG_BYTES)?;
        let name = self.config.file_name().unwrap_or_default();
        let attached = Attached {
            name: &name.to_string_lossy(),
            media_type: "application/toml",
            data: config.as_bytes(),
        };
        let recording = Recording::create(path, table, facts, &[attached])?;
        let growth = Growth::expected(table, cycle.as_secs_f64());
        log_recording_path(path, recording.path(), growth);
        Ok(Some(recording))
    }

    /// Ties the life of this process to that of its parent, if one is given.
    ///
    /// # Errors
    /// The parent has ended already, or the system refuses.
    pub fn die_with_parent(&self) -> anyhow::Result<()> {
        let Some(parent) = self.parent else {
            return Ok(());
        };
        Os::die_with_parent(parent).context("cannot be tied to the process that started it")
    }

    /// Reports on standard output that the config is valid.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn report_valid(&self) -> anyhow::Result<()> {
        report_valid(&self.file())
    }
}

/// Reports on standard output that a config file is valid.
///
/// # Errors
/// Standard output cannot be written.
pub fn report_valid(file: &impl fmt::Display) -> anyhow::Result<()> {
    writeln!(std::io::stdout(), "{file}: ok").context("cannot write the answer")
}

/// Logs the recording's path and its growth on the disk.
fn log_recording_path(asked: &Path, path: &Path, growth: Growth) {
    let file = path.display();
    if path == asked {
        tracing::info!("recording to {file}: {growth}");
    } else {
        let asked = asked.display();
        tracing::warn!("recording to {file}, since {asked} is there already: {growth}");
    }
}

/// Checks that the certificates are this node's. An expired one is not an error here: the node may
/// run, alone.
fn check_holder(node: &NodeName, folder: &Path) -> anyhow::Result<()> {
    let field = || format!("transport.secure: {}", folder.display());
    let credentials = Credentials::open(folder).with_context(field)?;
    // Access control goes by the name in the certificate. Another's folder would make this node act as that other.
    if credentials.name() != node {
        bail!(
            "{}: received the certificate of {:?}, expected that of this node, {:?}",
            field(),
            credentials.name().as_str(),
            node.as_str()
        );
    }
    match credentials.check(machine::wall_clock()) {
        // A node without valid credentials still holds its slaves and its trace. The log says that nobody lets it in.
        Ok(()) | Err(CredentialsFault::Expired(_) | CredentialsFault::NotYet) => Ok(()),
        Err(fault) => Err(fault).with_context(field),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use coaxle_node::config::parse;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        node: NodeArgs,
    }

    fn saw() -> NodeName {
        NodeName::new("saw").unwrap()
    }

    fn args(line: &str) -> NodeArgs {
        let words = std::iter::once("node").chain(line.split_whitespace());
        Cli::try_parse_from(words)
            .unwrap_or_else(|e| panic!("{e}"))
            .node
    }

    #[test]
    fn endpoints_of_the_command_line_replace_those_of_the_config() {
        let configured: TransportConfig = parse(
            "t",
            "listen = ['tcp/0.0.0.0:7447']\nconnect = ['tcp/10.0.0.1:1', 'tcp/10.0.0.2:2']",
        )
        .unwrap();
        let as_configured = args("a.toml").transport(&saw(), &configured).unwrap();
        assert_eq!(as_configured, configured);

        let line = "a.toml --connect tcp/127.0.0.1:7447 --connect tcp/127.0.0.1:7448";
        let connecting = args(line).transport(&saw(), &configured).unwrap();
        assert_eq!(
            connecting.connect,
            ["tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448"]
        );
        // Each list is replaced alone: `--connect` says nothing about where the node listens.
        assert_eq!(connecting.listen, configured.listen);

        let listening = args("a.toml --listen tcp/[::]:7")
            .transport(&saw(), &configured)
            .unwrap();
        assert_eq!(listening.listen, ["tcp/[::]:7"]);
        assert_eq!(listening.connect, configured.connect);
    }

    #[test]
    fn a_wrong_endpoint_is_quoted() {
        // Without a protocol the address looks complete, and Zenoh would retry it silently.
        let refused = Cli::try_parse_from(["node", "a.toml", "--connect", "192.168.1.10"]);
        let message = refused.err().expect("no endpoint").to_string();
        assert!(message.contains("'192.168.1.10'"), "{message}");
        assert!(message.contains("tcp/192.168.1.10:7447"), "{message}");
    }

    #[test]
    fn a_zenoh_file_is_found_from_the_config() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("zenoh.json5"), "{ mode: 'peer' }").unwrap();
        let configured: TransportConfig = parse("t", "file = 'zenoh.json5'").unwrap();
        let config = folder.path().join("a.toml");
        let transport = args(&config.display().to_string())
            .transport(&saw(), &configured)
            .unwrap();
        assert_eq!(transport.file, Some(folder.path().join("zenoh.json5")));
    }

    #[test]
    fn checking_is_not_running() {
        assert!(args("a.toml --check").check);
        // A check writes nothing: each of these would create a file or a run.
        for line in [
            "node a.toml --check --for 1s",
            "node a.toml --check --trace t.csv",
            "node a.toml --check --record r.mcap",
        ] {
            assert!(
                Cli::try_parse_from(line.split_whitespace()).is_err(),
                "{line}"
            );
        }
    }
}
