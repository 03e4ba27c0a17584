//! A trace file: consecutive CSV rows, readable at any moment.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use coaxle_clock::{Domain, Instant, Span};
use serde::Serialize;

/// Period of flushing, so that a killed process leaves a usable file.
const FLUSH_PERIOD: Span = Span::from_millis(250);

/// Buffer size: more than the rows of a flush period, so that the file always ends with a complete row.
const BUFFER_BYTES: usize = 4 << 20;

/// Rows of one kind, written to a CSV file with a head line.
pub struct Trace {
    path: PathBuf,
    writer: csv::Writer<File>,
    /// Time of the last flush, on the clock of the rows.
    flushed: Option<Span>,
    /// First error; nothing is written after it.
    failure: Option<csv::Error>,
}

impl Trace {
    /// Creates the file, or empties it. The head line names the fields of a row.
    ///
    /// # Errors
    /// The file that cannot be written.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        Self::open(path, true)
    }

    /// Creates the file with a head line of its own, for rows that are more than one struct.
    ///
    /// # Errors
    /// The file that cannot be written.
    pub fn with_columns(path: &Path, columns: &[String]) -> anyhow::Result<Self> {
        let mut trace = Self::open(path, false)?;
        // A full disk at the very start is reported as any later one, when the first rows come.
        trace.failure = trace.writer.write_record(columns).err();
        Ok(trace)
    }

    fn open(path: &Path, has_headers: bool) -> anyhow::Result<Self> {
        let file = File::create(path)
            .with_context(|| format!("cannot write the trace file {}", path.display()))?;
        Ok(Self {
            path: path.to_owned(),
            writer: csv::WriterBuilder::new()
                .buffer_capacity(BUFFER_BYTES)
                .has_headers(has_headers)
                .from_writer(file),
            flushed: None,
            failure: None,
        })
    }

    /// Adds the rows of the cycle that began at `at` on the clock of all cycles. A full disk is reported
    /// once in the log, and again by [`Self::finish`].
    pub fn write<D: Domain>(&mut self, at: Instant<D>, rows: impl IntoIterator<Item: Serialize>) {
        // Rows after a gap would look as if they followed each other.
        if self.failure.is_some() {
            return;
        }
        let written = self.try_write(at.since_epoch(), rows);
        if let Err(error) = written {
            tracing::error!(file = %self.path.display(), "the trace ends here: {error}");
            self.failure = Some(error);
        }
    }

    /// Writes out the rest.
    ///
    /// # Errors
    /// Not all rows could be written.
    pub fn finish(&mut self) -> anyhow::Result<()> {
        let result = match self.failure.take() {
            Some(error) => Err(error),
            None => self.writer.flush().map_err(csv::Error::from),
        };
        result
            .map_err(by_system)
            .with_context(|| format!("the trace file {} is incomplete", self.path.display()))
    }

    fn try_write(
        &mut self,
        at: Span,
        rows: impl IntoIterator<Item: Serialize>,
    ) -> Result<(), csv::Error> {
        for row in rows {
            self.writer.serialize(row)?;
        }
        // By the clock of the rows: a simulation in virtual time flushes as often per row as a real run.
        if at - *self.flushed.get_or_insert(at) >= FLUSH_PERIOD {
            self.flushed = Some(at);
            self.writer.flush()?;
        }
        Ok(())
    }
}

/// Returns the error of the system, which has a remedy, in place of the error of the CSV writer.
fn by_system(error: csv::Error) -> io::Error {
    // Only errors of the system have a remedy for the user.
    if !error.is_io_error() {
        return io::Error::other(error);
    }
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;

    const START: Instant<Machine> = Instant::EPOCH;

    #[derive(Serialize)]
    struct Row {
        at_ns: i64,
        position: Option<f64>,
    }

    fn row(k: i64) -> Row {
        Row {
            at_ns: k,
            position: (k > 0).then_some(0.5 * k as f64),
        }
    }

    #[test]
    fn what_is_older_than_the_flush_period_can_be_read_while_it_runs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.csv");
        let mut trace = Trace::create(&path).unwrap();
        for k in 0..=300 {
            trace.write(START + Span::from_millis(k), [row(k)]);
        }
        let now = std::fs::read_to_string(&path).unwrap();
        assert_eq!(now.lines().count(), 1 + 251, "head line and 0 to 250 ms");
        assert!(now.starts_with("at_ns,position\n0,\n1,0.5\n") && now.ends_with('\n'));
        trace.finish().unwrap();
        let all = std::fs::read_to_string(&path).unwrap();
        assert_eq!(all.lines().count(), 1 + 301);
    }

    #[test]
    fn a_file_that_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("no/such/folder.csv");
        let Err(error) = Trace::create(&path) else {
            panic!("created");
        };
        assert!(format!("{error:#}").contains("no/such/folder.csv"));
    }

    #[test]
    fn a_full_disk_is_an_error_at_the_end() {
        let mut trace = Trace::create(Path::new("/dev/full")).unwrap();
        for k in 0..1_000 {
            trace.write(START + Span::from_millis(k), [row(k)]);
        }
        let message = format!("{:#}", trace.finish().unwrap_err());
        assert!(message.contains("/dev/full is incomplete"), "{message}");
    }
}
