//! Whose rows there are in a recording, and a row.

use coaxle_node::signal::Kind;

use crate::value::Value;

/// A row as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Whose it is: its place among the tables that [`Reader::tables`](crate::Reader::tables) gives.
    pub table: usize,
    /// When the cycle ideally began, ns of the clock of the rows.
    pub at_ns: i64,
    /// When it really did.
    pub woke_ns: i64,
    /// The values of its columns, in their order; none where nothing was known.
    pub values: Vec<Option<Value>>,
}

/// Whose rows there are, as the file says it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadTable {
    /// Its name.
    pub name: String,
    /// What it is: `sender`, `receiver`.
    pub role: String,
    /// Its columns, in the order of the values of a row.
    pub columns: Vec<Column>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// The instance that it is of; empty for the node itself.
    pub instance: String,
    /// What that is: `far node`, `slave` …
    pub group: String,
    /// The signal.
    pub signal: String,
    /// Its unit; empty what has none.
    pub unit: String,
    /// What its values are.
    pub kind: Kind,
}

impl Column {
    /// Its name: `instance.signal`.
    #[must_use]
    pub fn name(&self) -> String {
        match self.instance.as_str() {
            "" => self.signal.clone(),
            instance => format!("{instance}.{}", self.signal),
        }
    }
}
