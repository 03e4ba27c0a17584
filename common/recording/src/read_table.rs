//! Tables of a recording, and their rows.

use coaxle_node::signal::Kind;

use crate::value::Value;

/// A row as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Index of its table in [`Reader::tables`](crate::Reader::tables).
    pub table: usize,
    /// Ideal start of the cycle, ns of the clock of the rows.
    pub at_ns: i64,
    /// Real start of the cycle.
    pub woke_ns: i64,
    /// The values of its columns, in their order; none for unknown ones.
    pub values: Vec<Option<Value>>,
}

/// Table as described in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadTable {
    /// Name of the table.
    pub name: String,
    /// Role: `sender`, `receiver`.
    pub role: String,
    /// Columns, in the order of the values of a row.
    pub columns: Vec<Column>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// The instance; empty for the node itself.
    pub instance: String,
    /// Group of the instance: `far node`, `slave` …
    pub group: String,
    /// The signal.
    pub signal: String,
    /// Unit; empty if it has none.
    pub unit: String,
    /// Kind of its values.
    pub kind: Kind,
}

impl Column {
    /// Returns the name of the column: `instance.signal`.
    #[must_use]
    pub fn name(&self) -> String {
        match self.instance.as_str() {
            "" => self.signal.clone(),
            instance => format!("{instance}.{}", self.signal),
        }
    }
}
