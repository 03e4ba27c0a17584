//! Kinds of files that people write. A file of another kind is named as such, instead of each of its fields.

use schemars::Schema;
use toml::{Table, Value};

use super::ConfigError;

/// Kind of a file.
#[derive(Debug, PartialEq, Eq)]
struct ConfigKind {
    name: &'static str,
    /// Command for files of this kind.
    command: &'static str,
    /// Fields of which a file of this kind has one, and no file of a later kind has any.
    marks: &'static [&'static str],
    /// List of a file of this kind. The slave of a saw or a gear is a table, and so is its axis.
    list: Option<&'static str>,
    /// A field that only the schema of this kind has.
    own_field: &'static str,
}

/// All kinds, in the order in which they are tried: a scenario has the fields of senders and receivers in its tables only, but a
/// gateway has an `axis` as a sender has.
const KINDS: [ConfigKind; 8] = [
    ConfigKind {
        name: "a gear file",
        command: "coaxle gear plan",
        marks: &["flying-gear"],
        list: None,
        own_field: "flying-gear",
    },
    ConfigKind {
        name: "a saw file",
        command: "coaxle saw plan",
        marks: &["gear-in-pos", "gear-in-velo"],
        list: None,
        own_field: "gear-in-pos",
    },
    ConfigKind {
        name: "a scenario",
        command: "coaxle run",
        marks: &["duration-s", "sender", "receiver"],
        list: None,
        own_field: "duration-s",
    },
    ConfigKind {
        name: "the config of a gateway",
        command: "coaxle gateway",
        marks: &["pipe", "udp", "ads", "layout", "output"],
        list: None,
        own_field: "layout",
    },
    ConfigKind {
        name: "the config of a server of OPC UA",
        command: "coaxle opcua",
        marks: &["endpoint", "rights"],
        list: None,
        own_field: "endpoint",
    },
    ConfigKind {
        name: "the config of a receiver",
        command: "coaxle receiver",
        marks: &["far", "virtual-axis", "cams", "sync", "observer"],
        list: Some("slave"),
        own_field: "far",
    },
    ConfigKind {
        name: "a cam file",
        command: "coaxle cam check",
        marks: &["point", "points", "table", "table-id"],
        list: None,
        own_field: "points",
    },
    ConfigKind {
        name: "the config of a sender",
        command: "coaxle sender",
        marks: &[],
        list: Some("axis"),
        own_field: "send-stamps",
    },
];

impl ConfigKind {
    fn is_of(&self, document: &Table) -> bool {
        let is_list = |list| document.get(list).is_some_and(Value::is_array);
        (self.marks.iter()).any(|mark| document.contains_key(*mark))
            || self.list.is_some_and(is_list)
    }

    fn is_described_by(&self, schema: &Schema) -> bool {
        let fields = schema.get("properties");
        fields.is_some_and(|fields| fields.get(self.own_field).is_some())
    }
}

/// Refuses a file that is in order as one of another kind.
///
/// # Errors
/// Both kinds, and the command for the file.
pub(crate) fn check_kind(file: &str, schema: &Schema, document: &Table) -> Result<(), ConfigError> {
    let received = KINDS.iter().find(|kind| kind.is_of(document));
    let expected = KINDS.iter().find(|kind| kind.is_described_by(schema));
    let (Some(received), Some(expected)) = (received, expected) else {
        return Ok(());
    };
    if received == expected {
        return Ok(());
    }
    let ConfigKind { name, command, .. } = received;
    let of = expected.name;
    let reason = format!("received {name}, expected {of}; for this one: {command} {file}");
    Err(ConfigError::whole(file, reason))
}
