//! Objects of a node and their variables, from the table of its rows.

use coaxle_node::signal::Kind;
use coaxle_recording::ReadTable;

/// Object of the address space: the node itself, or a part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartObject {
    /// Kind of part.
    pub kind: PartKind,
    /// Name of the part; empty for the node itself.
    pub name: String,
    /// Variables of the object.
    pub variables: Vec<PartVariable>,
}

/// Kind of part of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PartKind {
    /// The node itself.
    Node,
    /// An axis that it publishes, or one that it follows.
    Axis,
    /// A node that it follows.
    FarNode,
    /// A virtual axis.
    VirtualAxis,
    /// A slave.
    Slave,
}

/// Variable of an object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartVariable {
    /// Name of the signal.
    pub name: String,
    /// Unit; empty without one.
    pub unit: String,
    /// Kind of its values.
    pub kind: Kind,
    /// Source of its values.
    pub source: VariableSource,
}

/// Source of the values of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableSource {
    /// Column of the rows.
    Column(usize),
    /// Field of the status.
    Status(StatusText),
}

/// Text in the status of a node that no signal has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusText {
    /// Presence of the node: a flag.
    Alive,
    /// Health in a word.
    Health,
    /// Field with a code and a text: an error, a refusal.
    Fault(&'static str),
}

impl PartKind {
    /// Folder of the parts in their node, as in its status; empty for the node itself.
    #[must_use]
    pub const fn folder(self) -> &'static str {
        match self {
            Self::Node => "",
            Self::Axis => "axes",
            Self::FarNode => "far",
            Self::VirtualAxis => "virtual_axes",
            Self::Slave => "slaves",
        }
    }

    /// Texts of the status that its objects have, with their names.
    const fn texts(self) -> &'static [(&'static str, StatusText)] {
        match self {
            Self::Node => &[
                ("alive", StatusText::Alive),
                ("health", StatusText::Health),
                ("error_text", StatusText::Fault("error")),
                ("last_fault_text", StatusText::Fault("last_fault")),
            ],
            Self::Axis => &[],
            Self::FarNode => &[
                ("error_text", StatusText::Fault("error")),
                ("warning_text", StatusText::Fault("warning")),
            ],
            Self::VirtualAxis => &[("error_text", StatusText::Fault("error"))],
            Self::Slave => &[
                ("error_text", StatusText::Fault("error")),
                ("refusal_text", StatusText::Fault("refusal")),
                ("program_error_text", StatusText::Fault("program_error")),
            ],
        }
    }

    /// Faults among these texts: fields of the status.
    pub(crate) fn faults(self) -> impl Iterator<Item = &'static str> {
        self.texts().iter().filter_map(|(_, text)| match text {
            StatusText::Fault(field) => Some(*field),
            StatusText::Alive | StatusText::Health => None,
        })
    }

    /// Kind of the parts of a group of signals; none for a group that no running machine has.
    fn of_group(group: &str) -> Option<Self> {
        Some(match group {
            "node" => Self::Node,
            "axis" | "far axis" => Self::Axis,
            "far node" => Self::FarNode,
            "virtual axis" => Self::VirtualAxis,
            "slave" => Self::Slave,
            _ => return None,
        })
    }
}

impl PartObject {
    /// Objects of the node with these rows, the node itself first.
    #[must_use]
    pub fn of_table(table: &ReadTable) -> Vec<Self> {
        let mut parts = vec![Self::new(PartKind::Node, "")];
        for (column, of) in table.columns.iter().enumerate() {
            let Some(kind) = PartKind::of_group(&of.group) else {
                continue;
            };
            let known = parts
                .iter()
                .position(|part| part.kind == kind && part.name == of.instance);
            let part = known.unwrap_or_else(|| {
                parts.push(Self::new(kind, &of.instance));
                parts.len() - 1
            });
            // A signal is newer than the field of the status with its name.
            parts[part]
                .variables
                .retain(|known| known.name != of.signal);
            parts[part].variables.push(PartVariable {
                name: of.signal.clone(),
                unit: of.unit.clone(),
                kind: of.kind,
                source: VariableSource::Column(column),
            });
        }
        parts
    }

    /// Object of a node whose rows have not come.
    #[must_use]
    pub fn node() -> Self {
        Self::new(PartKind::Node, "")
    }

    /// Path of the object: `saw`, `saw/slaves/carriage`.
    #[must_use]
    pub fn path(&self, node: &str) -> String {
        match self.kind {
            PartKind::Node => node.to_owned(),
            kind => format!("{node}/{}/{}", kind.folder(), self.name),
        }
    }

    fn new(kind: PartKind, name: &str) -> Self {
        let texts = kind.texts().iter().map(|&(name, text)| PartVariable {
            name: name.to_owned(),
            unit: String::new(),
            kind: match text {
                StatusText::Alive => Kind::Flag,
                StatusText::Health | StatusText::Fault(_) => Kind::Text,
            },
            source: VariableSource::Status(text),
        });
        Self {
            kind,
            name: name.to_owned(),
            variables: texts.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_recording::Column;

    #[test]
    fn parts_are_where_the_status_has_them() {
        let column = |group: &str, instance: &str, signal: &str, unit: &str| Column {
            instance: instance.to_owned(),
            group: group.to_owned(),
            signal: signal.to_owned(),
            unit: unit.to_owned(),
            kind: Kind::Number,
        };
        let table = ReadTable {
            name: "saw".to_owned(),
            role: "receiver".to_owned(),
            columns: vec![
                column("node", "", "cycle", ""),
                column("slave", "carriage", "position", "mm"),
                column("truth", "carriage", "position", "mm"),
                column("slave", "carriage", "velocity", "mm/s"),
            ],
        };
        let parts = PartObject::of_table(&table);
        let paths: Vec<_> = parts.iter().map(|part| part.path("saw")).collect();
        assert_eq!(paths, ["saw", "saw/slaves/carriage"]);
        let of_rows = |part: &PartObject| -> Vec<_> {
            let variables = part.variables.iter();
            let columns = variables.filter_map(|variable| match variable.source {
                VariableSource::Column(column) => Some((variable.name.clone(), column)),
                VariableSource::Status(_) => None,
            });
            columns.collect()
        };
        assert_eq!(
            of_rows(&parts[1]),
            [("position".to_owned(), 1), ("velocity".to_owned(), 3)]
        );
    }
}
