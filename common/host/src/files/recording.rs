//! A recording on its way into a file: encoded here, written by a thread of its own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use anyhow::{Context, anyhow};
use coaxle_clock::Instant;
use coaxle_node::audit::AuditRecord;
use coaxle_os::machine::{self, Machine};
use coaxle_recording::{EncodedRow, Facts, LogLine, RowEncoder, RowError, Table, Writer};
use serde::Serialize;

use crate::files::inputs::InputRecord;
use crate::files::new_file::create_next;
use crate::files::synced_file::SyncedFile;

/// Memory for entries that wait to be written: a disk may stall for a second or more.
// 32 MiB of 100 signals in a row are 28 000 rows, so that the count below ends the queue at 16 s of 1 kHz.
const QUEUE_BYTES: usize = 32 << 20;
/// Capacity in rows, as many as this memory holds, within these limits.
// The channel allocates its places at once: the count bounds them where rows are small.
const MOST_ENTRIES: usize = 16_384;
// Rows of more than 43 000 signals (32 MiB / 64 / 12 bytes) still have a queue.
const FEWEST_ENTRIES: usize = 64;
/// Approximate size of a signal in a row.
const SIGNAL_BYTES: usize = 12;

/// Rows, log lines and status of a node, on their way into an MCAP file. No thread waits for the
/// disk: entries that do not fit into the writing thread's queue are dropped and counted. Entries
/// older than a quarter of a second are on the disk.
pub struct Recording {
    path: PathBuf,
    encoder: RowEncoder,
    /// Queue to the writing thread; none after the end.
    queue: Option<SyncSender<RecordingEntry>>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
    dropped: u64,
    /// Number of gaps in the recorded inputs.
    input_gaps: u64,
    /// A row that did not fit its table; no row is written after that.
    failure: Option<RowError>,
}

/// An entry to write.
enum RecordingEntry {
    Row(EncodedRow),
    Inputs {
        at_ns: i64,
        woke_ns: i64,
        bytes: Vec<u8>,
    },
    Log(LogLine),
    Status {
        at_ns: i64,
        json: String,
    },
    Audit {
        at_ns: i64,
        json: String,
    },
    Facts(Facts),
}

/// A file attached to a recording.
#[derive(Clone, Copy, Debug)]
pub struct Attached<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Media type of the contents.
    pub media_type: &'a str,
    /// Contents.
    pub data: &'a [u8],
}

impl Recording {
    /// Creates the file, or the next free one of its name, and starts the thread that writes it.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn create(
        path: &Path,
        table: &Table,
        facts: &Facts,
        attached: &[Attached<'_>],
    ) -> anyhow::Result<Self> {
        let cannot = || format!("cannot write the recording {}", path.display());
        // The next free name: the recording of an earlier run is never overwritten by a restart of the service.
        let (file, path) = create_next(path).with_context(cannot)?;
        let tables = std::slice::from_ref(table);
        let mut writer = Writer::create(
            SyncedFile(file),
            tables,
            facts,
            machine::wall_clock_offset_ns(),
        )
        .with_context(cannot)?;
        for file in attached {
            let put = writer.attach(file.name, file.media_type, file.data);
            put.with_context(cannot)?;
        }
        let signals: usize = table.instances.iter().map(|of| of.signals.len()).sum();
        // `max(1)` is for a node without signals: a division by zero would end it.
        let entries = QUEUE_BYTES / (SIGNAL_BYTES * signals).max(1);
        let (queue, entries) = sync_channel(entries.clamp(FEWEST_ENTRIES, MOST_ENTRIES));
        let file = path.display().to_string();
        let thread = std::thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || {
                let written = write(writer, &entries);
                written
                    // Logged when it happens. The result itself is read only when the node ends, perhaps days later.
                    .inspect_err(|error| tracing::error!(%file, "the recording ends here: {error}"))
            })
            .with_context(cannot)?;
        Ok(Self {
            path,
            encoder: RowEncoder::of(table),
            queue: Some(queue),
            thread: Some(thread),
            dropped: 0,
            input_gaps: 0,
            failure: None,
        })
    }

    /// Path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Records the epoch of the run.
    pub fn begin(&mut self, epoch: u64) {
        let facts = [("epoch", format!("{epoch:016x}"))];
        self.facts(facts);
    }

    /// Adds the row of a cycle.
    pub fn row(&mut self, at: Instant<Machine>, woke: Instant<Machine>, row: &impl Serialize) {
        // A table does not change during a run: each further row would fail and log in the same way.
        if self.failure.is_some() {
            return;
        }
        match self.encoder.encode(at.as_nanos(), woke.as_nanos(), row) {
            Ok(row) => self.push(RecordingEntry::Row(row)),
            Err(error) => {
                tracing::error!(file = %self.path.display(), "the recording ends here: {error}");
                self.failure = Some(error);
            }
        }
    }

    /// Adds the inputs of the node before a scan.
    pub fn told(&mut self, record: &InputRecord) {
        self.input_gaps += u64::from(record.after_gap);
        // `push` counts what it drops. The difference says whether these inputs were lost, for the facts of the file.
        let dropped = self.dropped;
        self.push(RecordingEntry::Inputs {
            at_ns: record.ideal_start.as_nanos(),
            woke_ns: record.woke.as_nanos(),
            bytes: record.scan.to_bytes(),
        });
        self.input_gaps += self.dropped - dropped;
    }

    /// Adds a line of the node's log.
    pub fn log(&mut self, line: LogLine) {
        self.push(RecordingEntry::Log(line));
    }

    /// Adds a status of the node, as JSON.
    pub fn status(&mut self, at: Instant<Machine>, json: &str) {
        let json = json.to_owned();
        let at_ns = at.as_nanos();
        self.push(RecordingEntry::Status { at_ns, json });
    }

    /// Adds a record of the node's audit.
    pub fn audit(&mut self, at: Instant<Machine>, record: &AuditRecord) {
        let (at_ns, json) = (at.as_nanos(), record.to_json());
        self.push(RecordingEntry::Audit { at_ns, json });
    }

    /// Number of rows, log lines, statuses and records of the audit that did not fit into the queue or came after a failure.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Writes the remaining entries, and ends the file with its summary.
    ///
    /// # Errors
    /// Names the incomplete file and the reason.
    pub fn finish(&mut self) -> anyhow::Result<()> {
        let facts = [
            ("dropped", self.dropped.to_string()),
            ("input-gaps", self.input_gaps.to_string()),
        ];
        // Before the queue closes: the facts at the end say whether the file is whole.
        self.facts(facts);
        // Closing the queue ends the thread's loop after the entries that are in it.
        self.queue = None;
        let Some(thread) = self.thread.take() else {
            return Ok(());
        };
        let written = thread.join();
        let written = written.unwrap_or_else(|_| Err(anyhow!("its thread panicked")));
        let rows = self
            .failure
            .take()
            .map_or(Ok(()), |error| Err(error.into()));
        let incomplete = || format!("the recording {} is incomplete", self.path.display());
        // The writer's error comes first: a full disk explains more than a row behind it.
        written.and(rows).with_context(incomplete)
    }

    fn facts<const N: usize>(&mut self, facts: [(&str, String); N]) {
        let facts = facts.map(|(name, value)| (name.to_owned(), value));
        // Few and small: these may wait, even for a slow disk.
        if let Some(queue) = &self.queue {
            let _ = queue.send(RecordingEntry::Facts(facts.into()));
        }
    }

    fn push(&mut self, entry: RecordingEntry) {
        let Some(queue) = &self.queue else {
            return;
        };
        let pushed = queue.try_send(entry);
        // A disconnected queue is not logged here: the thread has logged the reason itself.
        if let Err(TrySendError::Full(_)) = &pushed
            // Once: at 1 kHz a slow disk would fill the log instead. The count is in the status.
            && self.dropped == 0
        {
            let file = self.path.display();
            tracing::warn!(%file, "the recording has gaps from now on: its disk does not keep up");
        }
        self.dropped += u64::from(pushed.is_err());
    }
}

impl Drop for Recording {
    /// Finishes the file of a node that did not end regularly, too.
    fn drop(&mut self) {
        // Without the thread there is nothing to write: `finish` was called before.
        if self.thread.is_some() {
            let _ = self.finish();
        }
    }
}

/// Writes entries until the queue closes, and ends the file.
fn write(mut writer: Writer<SyncedFile>, entries: &Receiver<RecordingEntry>) -> anyhow::Result<()> {
    for entry in entries {
        // The first error ends the thread: a record may be half written, and what follows would be unreadable.
        match entry {
            RecordingEntry::Row(row) => writer.row(0, &row),
            RecordingEntry::Inputs {
                at_ns,
                woke_ns,
                bytes,
            } => writer.inputs(0, at_ns, woke_ns, &bytes),
            RecordingEntry::Log(line) => writer.log(0, &line),
            RecordingEntry::Status { at_ns, json } => writer.status(0, at_ns, &json),
            RecordingEntry::Audit { at_ns, json } => writer.audit(0, at_ns, &json),
            RecordingEntry::Facts(facts) => writer.facts(&facts),
        }?;
    }
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::example::{BoilerSignals, boiler};
    use coaxle_clock::Span;
    use coaxle_recording::{Item, Level, Reader, Value};
    use std::fs::File;

    fn items(path: &Path) -> Vec<Item> {
        let reader = Reader::new(File::open(path).unwrap());
        reader.filter_map(Result::ok).collect()
    }

    #[test]
    fn what_a_node_shows_is_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("boiler.mcap");
        let config = Attached {
            name: "boiler.toml",
            media_type: "application/toml",
            data: b"name = 'boiler'",
        };
        let mut recording = Recording::create(&path, &boiler(), &Facts::new(), &[config]).unwrap();
        recording.begin(0xf00d);
        let start = machine::now();
        for k in 0..100 {
            let at = start + Span::from_millis(10 * k);
            let row = BoilerSignals {
                temperature: k as f64,
            };
            recording.row(at, at + Span::from_micros(3), &row);
        }
        recording.log(LogLine {
            at_ns: start.as_nanos(),
            level: Level::Warning,
            name: "boiler".to_owned(),
            text: "cold".to_owned(),
        });
        recording.status(start, "{}");
        recording.finish().unwrap();
        assert_eq!(recording.dropped(), 0);
        let items = items(&path);
        let rows = items.iter().filter_map(|item| match item {
            Item::Row(row) => Some(row),
            _ => None,
        });
        let rows: Vec<_> = rows.collect();
        assert_eq!(rows.len(), 100);
        // The machine's clock is kept to the nanosecond.
        // A 64-bit count: a float is exact to the nanosecond for 2⁵³ ns only, 104 days of uptime.
        assert_eq!(rows[3].at_ns, (start + Span::from_millis(30)).as_nanos());
        assert_eq!(rows[3].values, [Some(Value::Number(3.0))]);
        let facts = items.iter().filter_map(|item| match item {
            Item::Facts(facts) => facts.get("epoch").cloned(),
            _ => None,
        });
        assert_eq!(facts.collect::<Vec<_>>(), ["000000000000f00d"]);
        let is_there = |what: fn(&Item) -> bool| items.iter().any(what);
        assert!(is_there(|item| matches!(item, Item::Attachment { .. })));
        assert!(is_there(|item| matches!(item, Item::Log(_))));
        assert!(is_there(|item| matches!(item, Item::Status { .. })));
    }

    #[test]
    fn a_recording_that_is_there_stays_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("boiler.mcap");
        std::fs::write(&path, "of the run before").unwrap();
        let mut recording = Recording::create(&path, &boiler(), &Facts::new(), &[]).unwrap();
        assert_eq!(recording.path(), folder.path().join("boiler-2.mcap"));
        recording.row(
            Instant::EPOCH,
            Instant::EPOCH,
            &BoilerSignals { temperature: 1.0 },
        );
        recording.finish().unwrap();
        let before = std::fs::read_to_string(&path).unwrap();
        assert_eq!(before, "of the run before");
        assert!(!items(recording.path()).is_empty());
    }

    #[test]
    fn nobody_waits_for_a_disk_that_is_full_and_it_is_said() {
        // Any write to /dev/full is refused with ENOSPC.
        let path = Path::new("/dev/full");
        let error = Recording::create(path, &boiler(), &Facts::new(), &[]).map(|_| ());
        let message = format!("{:#}", error.unwrap_err());
        assert!(message.contains("the recording /dev/full"), "{message}");
    }

    #[test]
    fn a_row_of_something_else_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("boiler.mcap");
        let mut recording = Recording::create(&path, &boiler(), &Facts::new(), &[]).unwrap();
        recording.row(Instant::EPOCH, Instant::EPOCH, &("hot", 1));
        let message = format!("{:#}", recording.finish().unwrap_err());
        assert!(
            message.contains("temperature: received a text, expected a number"),
            "{message}"
        );
    }
}
