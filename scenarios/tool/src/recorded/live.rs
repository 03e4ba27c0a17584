//! `coaxle record`: the rows of running nodes, into a recording.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;
use coaxle_clock::{Instant, Span};
use coaxle_host::cli::{NetworkArgs, parse_duration};
use coaxle_host::files::{SyncedFile, create_new, create_next};
use coaxle_host::network::transport::{Declared, Transport};
use coaxle_node::keys::NodeName;
use coaxle_os::Interrupt;
use coaxle_os::exit::Exit;
use coaxle_os::machine::{self, Machine};
use coaxle_recording::{Growth, Join, JoinError, JoinedNode};
use coaxle_report::inspect;

use crate::status;

/// The nodes, and the recording.
#[derive(Debug, Args)]
pub(crate) struct RecordArgs {
    /// The nodes [default: all that are there]
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    nodes: Vec<NodeName>,
    /// The recording to write, which must not be there yet [default: NODE.mcap, of several nodes nodes.mcap]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Record for this time, such as 10s, 500ms, 2m, 1h; without it, until Ctrl-C
    #[arg(long = "for", value_name = "DURATION", value_parser = parse_duration)]
    record_for: Option<Span>,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Most pieces that wait to be written: a few seconds of ten nodes. Pieces beyond it are dropped and counted.
// Twenty pieces a second of each node: ten nodes fill it in five seconds.
const MOST_PIECES: usize = 1024;
/// Polling interval of the interrupt.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Records the rows of the nodes from now on.
///
/// # Errors
/// A network that cannot be joined, a node that is not there, or a file that is there already or cannot be written.
pub(crate) fn record(args: &RecordArgs) -> anyhow::Result<Exit> {
    let interrupt = Interrupt::listen()?;
    let watcher = args.network.watch(&args.nodes)?;
    // Within a closure, so that the watcher is closed on every way out.
    let recorded = status::gather(&watcher, &args.nodes).and_then(|seen| {
        let nodes: Vec<_> = seen.into_iter().map(|node| node.name).collect();
        // Before the file exists: pieces wait in the queue meanwhile.
        let (pieces, declared) = subscribe(&**watcher.transport(), &nodes)?;
        let mut files = JoinedFiles::create(args.out.as_deref(), &nodes)?;
        tracing::info!("recording to {}", files.path.display());
        let exit = take(args, &interrupt, &nodes, &pieces, &mut files)?;
        // First the end of the subscriptions, so that nothing comes while the file gets its summary.
        drop(declared);
        files.finish()?;
        Ok((exit, files, nodes))
    });
    watcher.close();
    let (exit, files, nodes) = recorded?;
    inspect::print_text(&files.lines().join("\n"))?;
    let silent = nodes.iter().filter(|node| !files.has_rows_of(node));
    let silent: Vec<_> = silent.map(NodeName::as_str).collect();
    if !silent.is_empty() {
        // Access control drops messages without a word, so the tool names the likely reason.
        tracing::error!(
            "no row came of {}: in a secure network the operator may have no right to coaxle/<node>/rows",
            silent.join(", ")
        );
        return Ok(Exit::NoData);
    }
    Ok(exit)
}

/// Index of the node, and its piece.
type Pieces = Receiver<(usize, Vec<u8>)>;

fn subscribe(
    transport: &dyn Transport,
    nodes: &[NodeName],
) -> anyhow::Result<(Pieces, Vec<Declared>)> {
    let (queue, pieces) = sync_channel(MOST_PIECES);
    let queue = Arc::new(queue);
    let subscribed = nodes.iter().enumerate().map(|(n, node)| {
        let queue = Arc::clone(&queue);
        let take = move |_, piece: &[u8]| {
            // A piece that finds no room shows as missing rows.
            let _ = queue.try_send((n, piece.to_vec()));
        };
        transport.subscribe(&node.rows_key(), Box::new(take))
    });
    let subscribed: anyhow::Result<_> = subscribed.collect();
    Ok((pieces, subscribed?))
}

/// Writes pieces until the end of the recording.
fn take(
    args: &RecordArgs,
    interrupt: &Interrupt,
    nodes: &[NodeName],
    pieces: &Pieces,
    files: &mut JoinedFiles,
) -> anyhow::Result<Exit> {
    let end = args.record_for.map(|span| machine::now() + span);
    let mut watch = GrowthWatch::default();
    loop {
        let file = files.finished.len();
        if let Some(growth) = watch.update(machine::now(), file, &files.path) {
            tracing::info!("{}: {growth}", files.path.display());
        }
        if interrupt.is_received() {
            // Without a time limit, an interrupt is the usual end.
            let is_early = end.is_some();
            return Ok(Exit::Interrupted.done_if(!is_early));
        }
        if end.is_some_and(|end| machine::now() >= end) {
            return Ok(Exit::Done);
        }
        match pieces.recv_timeout(POLL_INTERVAL) {
            Ok((n, piece)) => files.piece(&nodes[n], &piece)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => bail!("the network is gone"),
        }
    }
}

/// Time over which growth is measured, after a second in which the file begins.
// Sixty pieces of a node; the data are synchronised to the disk four times a second.
const WATCHED: Span = Span::from_secs(3);
// Schemas and the head of the file are no growth.
const BEGINNING: Span = Span::from_secs(1);

/// Logs once how fast the recording grows, as soon as it is known.
#[derive(Default)]
struct GrowthWatch {
    started: Option<Instant<Machine>>,
    /// Number of the file that is watched.
    file: usize,
    /// Beginning of the measurement and the file's length then; absent again once logged.
    from: Option<(Instant<Machine>, u64)>,
}

impl GrowthWatch {
    /// Looks at the length of a file, the `file`th of the recording; returns its growth once it is known.
    fn update(&mut self, now: Instant<Machine>, file: usize, path: &Path) -> Option<Growth> {
        let mut since = now - *self.started.get_or_insert(now);
        let is_over = self.from.is_none() && since >= WATCHED;
        if file != self.file && !is_over {
            // The lengths of two files have no difference: the measurement begins again.
            (self.started, self.from, since) = (Some(now), None, Span::ZERO);
        }
        self.file = file;
        let is_due = match self.from {
            // The upper bound keeps it from beginning again once the growth was logged.
            None => since >= BEGINNING && since < WATCHED,
            Some((at, _)) => now - at >= WATCHED,
        };
        let length = is_due.then(|| path.metadata().ok()).flatten()?.len();
        let Some((at, before)) = self.from.take() else {
            self.from = Some((now, length));
            return None;
        };
        // Somebody may have cut the file.
        let more = length.saturating_sub(before);
        Some(Growth::measured(more, (now - at).as_secs_f64()))
    }
}

/// The recording; and another one each time that a node shows other signals than before.
struct JoinedFiles {
    /// The first one, after which the others are named.
    first: PathBuf,
    path: PathBuf,
    of_many: bool,
    join: Option<Join<SyncedFile>>,
    /// Number of malformed pieces.
    refused: u64,
    finished: Vec<(PathBuf, Vec<JoinedNode>)>,
}

impl JoinedFiles {
    fn create(out: Option<&Path>, nodes: &[NodeName]) -> anyhow::Result<Self> {
        let path = match (out, nodes) {
            (Some(out), _) => out.to_owned(),
            (None, [node]) => PathBuf::from(format!("{node}.mcap")),
            (None, _) => PathBuf::from("nodes.mcap"),
        };
        let of_many = nodes.len() > 1;
        let file = create_new(&path).with_context(|| cannot(&path))?;
        Ok(Self {
            join: Some(begin(file, &path, of_many)?),
            first: path.clone(),
            path,
            of_many,
            refused: 0,
            finished: Vec::new(),
        })
    }

    fn piece(&mut self, node: &NodeName, piece: &[u8]) -> anyhow::Result<()> {
        match self.join(node, piece) {
            Err(JoinError::Changed { .. }) => {
                self.finish()?;
                // After the first name each time: otherwise names would grow to `-2-2-2`.
                let (file, next) = create_next(&self.first).with_context(|| cannot(&self.first))?;
                tracing::warn!(
                    "{node} shows other signals than before: the recording goes on in {}",
                    next.display()
                );
                self.join = Some(begin(file, &next, self.of_many)?);
                self.path = next;
                // The piece that had other signals is the first of the new file.
                let joined = self.join(node, piece);
                joined.with_context(|| self.path.display().to_string())
            }
            Err(error @ (JoinError::Damage(_) | JoinError::Foreign { .. })) => {
                // Once: anything may be published under the key, at any rate.
                if self.refused == 0 {
                    tracing::warn!("{}: {error}", node.rows_key());
                }
                self.refused += 1;
                Ok(())
            }
            joined => joined.with_context(|| self.path.display().to_string()),
        }
    }

    fn join(&mut self, node: &NodeName, piece: &[u8]) -> Result<(), JoinError> {
        match &mut self.join {
            Some(join) => join.piece(node.as_str(), piece),
            None => Ok(()),
        }
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        if let Some(join) = self.join.take() {
            self.finished.push((self.path.clone(), join.nodes()));
            let finished = join.finish();
            finished.with_context(|| self.path.display().to_string())?;
        }
        Ok(())
    }

    fn has_rows_of(&self, node: &NodeName) -> bool {
        let mut all = self.finished.iter().flat_map(|(_, nodes)| nodes);
        all.any(|joined| joined.name == node.as_str() && joined.rows > 0)
    }

    /// A line for each node of each file.
    fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (path, nodes) in &self.finished {
            lines.extend(nodes.iter().map(|node| {
                let JoinedNode {
                    name,
                    rows,
                    missing,
                } = node;
                format!("{name}: {rows} rows, {missing} missing")
            }));
            lines.push(format!("recording: {}", path.display()));
        }
        if self.refused > 0 {
            lines.push(format!(
                "{} messages were no pieces of a recording",
                self.refused
            ));
        }
        lines
    }
}

fn cannot(path: &Path) -> String {
    format!("cannot create the recording {}", path.display())
}

fn begin(file: File, path: &Path, of_many: bool) -> anyhow::Result<Join<SyncedFile>> {
    Join::create(SyncedFile(file), of_many).with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::signal::Instance;
    use coaxle_receiver::signals::NodeSignals;
    use coaxle_recording::{Facts, Pieces, RowEncoder, Table};

    fn piece(instances: usize) -> Vec<u8> {
        let instance = |n: usize| Instance::of::<NodeSignals>(if n == 0 { "" } else { "other" });
        let table = Table {
            name: "saw".to_owned(),
            role: "receiver".to_owned(),
            instances: (0..instances).map(instance).collect(),
        };
        let mut encoder = RowEncoder::of(&table);
        let mut pieces = Pieces::of(table, Facts::new(), 0);
        let row = vec![NodeSignals::default(); instances];
        pieces.row(&encoder.encode(0, 0, &row).unwrap()).unwrap();
        pieces.take().unwrap().unwrap()
    }

    #[test]
    fn growth_is_that_of_one_file_though_the_recording_went_on_in_another() {
        let folder = tempfile::tempdir().unwrap();
        let mut watch = GrowthWatch::default();
        let begin = machine::now();
        let mut logged = Vec::new();
        for tick in 0..100_i64 {
            // From the third second on in another file; both grow by 1000 bytes in 0.1 s, 36 MB in an hour.
            let file = usize::from(tick >= 25);
            let path = folder.path().join(file.to_string());
            let length = 1_000 * (tick - 25 * i64::from(file == 1));
            std::fs::write(&path, vec![0; length.try_into().unwrap()]).unwrap();
            let now = begin + Span::from_millis(100 * tick);
            logged.extend(watch.update(now, file, &path));
        }
        let [growth] = logged[..] else {
            panic!("{logged:?}");
        };
        assert_eq!(
            growth.to_string(),
            Growth::measured(10_000, 1.0).to_string()
        );
        // Later files begin no other measurement.
        for tick in 100..200 {
            let now = begin + Span::from_millis(100 * tick);
            let path = folder.path().join("1");
            assert!(watch.update(now, 2, &path).is_none());
        }
    }

    #[test]
    fn a_node_that_shows_other_signals_gets_another_file_and_strangers_get_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let saw = NodeName::new("saw").unwrap();
        let mut files = JoinedFiles::create(Some(&path), std::slice::from_ref(&saw)).unwrap();
        files.piece(&saw, &piece(1)).unwrap();
        files.piece(&saw, b"hello").unwrap();
        files.piece(&saw, &piece(2)).unwrap();
        files.piece(&saw, &piece(2)).unwrap();
        files.finish().unwrap();
        assert!(files.has_rows_of(&saw));
        let lines = files.lines();
        assert_eq!(lines[0], "saw: 1 rows, 0 missing");
        assert!(lines[3].ends_with("a-2.mcap"), "{lines:?}");
        assert_eq!(lines[4], "1 messages were no pieces of a recording");
        let error = JoinedFiles::create(Some(&path), &[saw])
            .map(|_| ())
            .unwrap_err();
        assert!(
            format!("{error:#}").contains("cannot create the recording"),
            "{error:#}"
        );
    }
}
