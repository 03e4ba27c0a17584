//! A row on its way into a file.

use coaxle_node::signal::Kind;

/// A row as a file has it: one message for each instance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EncodedRow {
    /// When the cycle ideally began, ns of the clock of the rows.
    pub(crate) at_ns: i64,
    /// When it really did.
    pub(crate) woke_ns: i64,
    bytes: Vec<u8>,
    ends: Vec<u32>,
}

/// A row that is none of its table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowError {
    /// A value of another kind than its signal.
    #[error("{column}: received a {received}, expected a {expected}")]
    Kind {
        /// The column: `instance.signal`.
        column: String,
        /// What the row has there.
        received: Kind,
        /// What the signal is declared to be.
        expected: Kind,
    },
    /// More or fewer values than there are signals.
    #[error("received {received} values, expected {expected}")]
    Length {
        /// How many came, at least.
        received: usize,
        /// How many signals there are.
        expected: usize,
    },
    /// Something that is no row.
    #[error("received {0}, expected structures of numbers, flags and words")]
    NoRow(String),
}

/// Where the value of a signal goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slot {
    pub(crate) number: u32,
    pub(crate) kind: Kind,
    /// Whether its message ends with it.
    pub(crate) is_last: bool,
}

impl EncodedRow {
    /// An empty one, with room for so many bytes.
    pub(crate) fn new(at_ns: i64, woke_ns: i64, bytes: usize) -> Self {
        Self {
            at_ns,
            woke_ns,
            bytes: Vec::with_capacity(bytes),
            ends: Vec::new(),
        }
    }

    /// Bytes of its messages.
    pub(crate) const fn length(&self) -> usize {
        self.bytes.len()
    }

    /// The message being made.
    pub(crate) const fn open_message(&mut self) -> &mut Vec<u8> {
        &mut self.bytes
    }

    pub(crate) fn end_message(&mut self) {
        self.ends.push(self.bytes.len() as u32);
    }

    /// Its messages, in the order of the instances.
    pub(crate) fn messages(&self) -> impl Iterator<Item = &[u8]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let ranges = starts.zip(&self.ends);
        ranges.map(|(start, end)| &self.bytes[start as usize..*end as usize])
    }
}
