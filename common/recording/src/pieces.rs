//! A recording in pieces, for observers during the recording.

use mcap::WriteOptions;

use crate::encoded_row::EncodedRow;
use crate::format::PIECE;
use crate::log::LogLine;
use crate::table::Table;
use crate::writer::{self, Facts, WriteError, Writer, WrittenCount};

/// Rows of a node, cut into pieces. Each is a small recording that any reader can read by itself, so that
/// an observer may begin at any of them. The sequence numbers of their messages continue, so that a
/// missing piece is detected. [`Join`](crate::Join) makes one recording of them again.
pub struct Pieces {
    table: Table,
    facts: Facts,
    clock_offset_ns: i64,
    open: Option<Writer<Vec<u8>>>,
    written: WrittenCount,
    number: u64,
}

impl Pieces {
    /// Cuts the rows of a table. `facts` are in every piece, and the clock is as in [`Writer::create`].
    #[must_use]
    pub const fn of(table: Table, facts: Facts, clock_offset_ns: i64) -> Self {
        Self {
            table,
            facts,
            clock_offset_ns,
            open: None,
            written: WrittenCount::NOTHING,
            number: 0,
        }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`WriteError`], if ever.
    pub fn row(&mut self, row: &EncodedRow) -> Result<(), WriteError> {
        self.open()?.row(0, row)
    }

    /// Adds a line of the log.
    ///
    /// # Errors
    /// [`WriteError`], if ever.
    pub fn log(&mut self, line: &LogLine) -> Result<(), WriteError> {
        self.open()?.log(0, line)
    }

    /// Adds a status, as JSON.
    ///
    /// # Errors
    /// [`WriteError`], if ever.
    pub fn status(&mut self, at_ns: i64, json: &str) -> Result<(), WriteError> {
        self.open()?.status(0, at_ns, json)
    }

    /// Ends the piece and returns it; none if nothing has been added since the last one.
    ///
    /// # Errors
    /// [`WriteError`], if ever.
    pub fn take(&mut self) -> Result<Option<Vec<u8>>, WriteError> {
        let Some(writer) = self.open.take() else {
            return Ok(None);
        };
        // Sequence numbers go on in the next piece, and a gap in them shows a lost one.
        self.written = writer.written(0);
        writer.finish().map(Some)
    }

    fn open(&mut self) -> Result<&mut Writer<Vec<u8>>, WriteError> {
        let writer = match self.open.take() {
            Some(writer) => writer,
            None => self.begin()?,
        };
        Ok(self.open.insert(writer))
    }

    fn begin(&mut self) -> Result<Writer<Vec<u8>>, WriteError> {
        let mut facts = self.facts.clone();
        facts.insert(PIECE.to_owned(), self.number.to_string());
        self.number += 1;
        let tables = std::slice::from_ref(&self.table);
        let mut writer =
            Writer::with_options(options(), Vec::new(), tables, &facts, self.clock_offset_ns)?;
        writer.count_on(0, self.written);
        Ok(writer)
    }
}

/// Returns the options of a piece: it is read completely, and needs no index.
fn options() -> WriteOptions {
    writer::options()
        // A summary repeats schemas and channels, which are at the beginning of each piece anyway.
        .emit_summary_records(false)
        .emit_summary_offsets(false)
        .emit_message_indexes(false)
}
