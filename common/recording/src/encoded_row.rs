//! A row, encoded for a file.

use coaxle_node::signal::Kind;

/// A row as in a file: one message for each instance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EncodedRow {
    /// Ideal start of the cycle, ns of the clock of the rows.
    pub(crate) at_ns: i64,
    /// Real start of the cycle.
    pub(crate) woke_ns: i64,
    bytes: Vec<u8>,
    ends: Vec<u32>,
}

/// Error of a row that does not fit its table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowError {
    /// A value of another kind than its signal.
    #[error("{column}: received a {received}, expected a {expected}")]
    Kind {
        /// The column: `instance.signal`.
        column: String,
        /// Kind of the value in the row.
        received: Kind,
        /// Declared kind of the signal.
        expected: Kind,
    },
    /// More or fewer values than there are signals.
    #[error("received {received} values, expected {expected}")]
    Length {
        /// Least number of values received.
        received: usize,
        /// Number of signals.
        expected: usize,
    },
    /// A value that cannot be serialised as a row.
    #[error("received {0}, expected structures of numbers, flags and words")]
    NoRow(String),
}

/// Field of a signal in a message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot {
    pub(crate) number: u32,
    pub(crate) kind: Kind,
    /// True if it is the last one of its message.
    pub(crate) is_last: bool,
}

impl EncodedRow {
    /// Makes an empty row with capacity for this number of bytes.
    pub(crate) fn new(at_ns: i64, woke_ns: i64, bytes: usize) -> Self {
        Self {
            at_ns,
            woke_ns,
            // Rows of a table are alike: the longest one so far mostly avoids growing.
            bytes: Vec::with_capacity(bytes),
            ends: Vec::new(),
        }
    }

    /// Returns the total length of its messages, bytes.
    pub(crate) const fn length(&self) -> usize {
        self.bytes.len()
    }

    /// Returns the message in progress.
    pub(crate) const fn open_message(&mut self) -> &mut Vec<u8> {
        &mut self.bytes
    }

    pub(crate) fn end_message(&mut self) {
        self.ends.push(self.bytes.len() as u32);
    }

    /// Returns the messages of the row, in the order of the instances.
    pub(crate) fn messages(&self) -> impl Iterator<Item = &[u8]> {
        // Only the ends are kept: each message begins where the one before it ends.
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let ranges = starts.zip(&self.ends);
        ranges.map(|(start, end)| &self.bytes[start as usize..*end as usize])
    }
}
