//! Destinations of the rows of a node: a trace, a recording, and live viewers.

use coaxle_clock::Instant;
use coaxle_node::audit::AuditRecord;
use coaxle_os::Trace;
use coaxle_os::machine::{self, Machine};
use coaxle_recording::{Facts, Level, LogLine, Pieces, Table};
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::files::inputs::InputRecord;
use crate::files::recording::Recording;
use crate::files::row_stream::RowStream;
use crate::network::transport::Publisher;

/// The rows of a node, with its log and its status, on their way to their destinations.
pub struct Rows {
    table: Table,
    facts: Facts,
    trace: Option<Trace>,
    recording: Option<Recording>,
    /// Stream to live viewers; none before the run begins.
    stream: Option<RowStream>,
}

impl Rows {
    /// Creates the rows of a table with these facts, for the given files.
    #[must_use]
    pub const fn new(
        table: Table,
        facts: Facts,
        trace: Option<Trace>,
        recording: Option<Recording>,
    ) -> Self {
        Self {
            table,
            facts,
            trace,
            recording,
            stream: None,
        }
    }

    /// Begins the run with this epoch; `publisher` serves the live viewers.
    pub fn begin(&mut self, epoch: u64, publisher: Box<dyn Publisher>) {
        if let Some(recording) = &mut self.recording {
            recording.begin(epoch);
        }
        let mut facts = self.facts.clone();
        facts.insert("epoch".to_owned(), format!("{epoch:016x}"));
        // Read at the start of the run: a later step of the wall clock would bend the times of one file.
        let offset = machine::wall_clock_offset_ns();
        let pieces = Pieces::of(self.table.clone(), facts, offset);
        self.stream = Some(RowStream::new(&self.table, pieces, publisher));
    }

    /// Adds the row of a cycle.
    pub fn row(&mut self, at: Instant<Machine>, woke: Instant<Machine>, row: &impl Serialize) {
        if let Some(trace) = &mut self.trace {
            trace.write(at, [(at.as_nanos(), woke.as_nanos(), row)]);
        }
        if let Some(recording) = &mut self.recording {
            recording.row(at, woke, row);
        }
        if let Some(stream) = &mut self.stream {
            stream.row(at, woke, row);
        }
    }

    /// True if the node's inputs before its scans are wanted: a recording holds them for replay.
    #[must_use]
    pub const fn want_inputs(&self) -> bool {
        self.recording.is_some()
    }

    /// Adds the inputs of the node before a scan.
    pub fn told(&mut self, record: &InputRecord) {
        if let Some(recording) = &mut self.recording {
            recording.told(record);
        }
    }

    /// Adds a line of the node's log.
    pub fn log(&mut self, at: Instant<Machine>, level: Level, text: impl Into<String>) {
        let line = LogLine {
            at_ns: at.as_nanos(),
            level,
            name: self.table.name.clone(),
            text: text.into(),
        };
        // Borrowed by the stream first, then given to the recording: no copy is needed.
        if let Some(stream) = &mut self.stream {
            stream.log(&line);
        }
        if let Some(recording) = &mut self.recording {
            recording.log(line);
        }
    }

    /// Adds the node's status, as published: JSON.
    pub fn reported(&mut self, at: Instant<Machine>, status: &str) {
        // The file gets the status even if nobody watches, the stream only while somebody does.
        if let Some(recording) = &mut self.recording {
            recording.status(at, status);
        }
        if let Some(stream) = &mut self.stream {
            stream.status(at, status);
        }
    }

    /// Adds a record of the node's audit.
    pub fn audited(&mut self, at: Instant<Machine>, record: &AuditRecord) {
        // Not for live viewers, who may read rows only: the audit has a key of its own.
        if let Some(recording) = &mut self.recording {
            recording.audit(at, record);
        }
    }

    /// Adds the recording's counters to the status.
    pub fn add_to(&self, status: &mut Map<String, Value>) {
        if let Some(recording) = &self.recording {
            status.insert("recording_dropped".to_owned(), json!(recording.dropped()));
        }
    }

    /// Ends the run.
    ///
    /// # Errors
    /// Names the incomplete file and the reason.
    pub fn finish(&mut self) -> anyhow::Result<()> {
        // The last piece is shorter than the others. Without this call it would be lost.
        if let Some(mut stream) = self.stream.take() {
            stream.send();
        }
        let traced = self.trace.as_mut().map_or(Ok(()), Trace::finish);
        let recorded = self.recording.as_mut().map_or(Ok(()), Recording::finish);
        // Both are finished before the first error is returned: a failed trace must not cost the recording.
        traced.and(recorded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::example::{BoilerSignals, boiler};
    use crate::network::transport::{InProcess, Transport, Urgency};
    use coaxle_clock::Span;
    use coaxle_recording::{Item, Join, Reader};
    use std::sync::{Arc, Mutex};

    fn rows() -> Rows {
        Rows::new(boiler(), Facts::new(), None, None)
    }

    #[test]
    fn who_looks_on_sees_what_comes_from_then_on_and_nothing_is_made_for_nobody() {
        let network = InProcess::default();
        let mut rows = rows();
        let publisher = network.publisher("coaxle/boiler/rows", Urgency::Bulk);
        rows.begin(7, publisher.unwrap());
        let at = |ms: i64| Instant::EPOCH + Span::from_millis(ms);
        let show = |rows: &mut Rows, from: i64, to: i64| {
            for ms in from..to {
                let temperature = ms as f64;
                rows.row(at(ms), at(ms), &BoilerSignals { temperature });
                if ms % 100 == 0 {
                    rows.log(at(ms), Level::Info, "warm");
                    rows.reported(at(ms), "{}");
                }
            }
        };
        show(&mut rows, 0, 200);
        let seen: Arc<Mutex<Vec<Vec<u8>>>> = Arc::default();
        let taken = Arc::clone(&seen);
        let take = move |_, bytes: &[u8]| taken.lock().unwrap().push(bytes.to_vec());
        let subscribed = network.subscribe("coaxle/boiler/rows", Box::new(take));
        let subscribed = subscribed.unwrap();
        // 420 ms: the subscriber of 200 ms on sees pieces that begin at 200, 250, 300 and 350 ms.
        show(&mut rows, 200, 420);
        drop(subscribed);
        show(&mut rows, 420, 600);
        rows.finish().unwrap();

        let mut join = Join::create(Vec::new(), false).unwrap();
        for piece in &*seen.lock().unwrap() {
            join.piece("boiler", piece).unwrap();
        }
        let joined = &join.nodes()[0];
        // Received from the next piece on; the last pieces are still under way when the subscriber
        // is gone.
        // Four pieces of 50 rows.
        assert_eq!((joined.rows, joined.missing), (200, 0));
        let file = join.finish().unwrap();
        let items: Vec<_> = Reader::new(file.as_slice()).map(Result::unwrap).collect();
        let count = |what: fn(&Item) -> bool| items.iter().filter(|item| what(item)).count();
        // Lines and statuses at 200 and 300 ms; that of 400 ms is in the piece that nobody hears any more.
        assert_eq!(count(|item| matches!(item, Item::Log(_))), 2);
        assert_eq!(count(|item| matches!(item, Item::Status { .. })), 2);
        let epoch = items.iter().find_map(|item| match item {
            Item::Facts(facts) => facts.get("epoch"),
            _ => None,
        });
        assert_eq!(epoch.map(String::as_str), Some("0000000000000007"));
    }
}
