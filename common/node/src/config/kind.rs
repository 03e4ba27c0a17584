//! Kinds of files that people write. A file of another kind is named as such, instead of each of its fields.

use schemars::Schema;
use toml::{Table, Value};

use super::ConfigError;

/// Kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ConfigKind {
    Gear,
    Saw,
    Scenario,
    Gateway,
    Receiver,
    Cam,
    Sender,
}

impl ConfigKind {
    /// In the order in which they are tried: a scenario has the fields of senders and receivers in its tables only, but a gear has a
    /// `slave` as a receiver has, and a gateway an `axis` as a sender has.
    const ALL: [Self; 7] = [
        Self::Gear,
        Self::Saw,
        Self::Scenario,
        Self::Gateway,
        Self::Receiver,
        Self::Cam,
        Self::Sender,
    ];

    /// Fields of which a file of this kind has one, and no file of a later kind has any.
    const fn marks(self) -> &'static [&'static str] {
        match self {
            Self::Gear => &["flying-gear"],
            Self::Saw => &["gear-in-pos", "gear-in-velo"],
            Self::Scenario => &["duration-s", "sender", "receiver"],
            Self::Gateway => &["pipe", "udp", "ads", "layout", "output"],
            Self::Receiver => &["far", "virtual-axis", "cams", "sync", "observer"],
            Self::Cam => &["point", "points", "table", "table-id"],
            // By its list alone.
            Self::Sender => &[],
        }
    }

    /// List of a file of this kind. The slave of a saw or a gear is a table, and so is its axis.
    const fn list(self) -> Option<&'static str> {
        match self {
            Self::Receiver => Some("slave"),
            Self::Sender => Some("axis"),
            _ => None,
        }
    }

    /// A field that only the schema of this kind has.
    const fn own_field(self) -> &'static str {
        match self {
            Self::Gear => "flying-gear",
            Self::Saw => "gear-in-pos",
            Self::Scenario => "duration-s",
            Self::Gateway => "layout",
            Self::Receiver => "far",
            Self::Cam => "points",
            Self::Sender => "send-stamps",
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Gear => "a gear file",
            Self::Saw => "a saw file",
            Self::Scenario => "a scenario",
            Self::Gateway => "the config of a gateway",
            Self::Receiver => "the config of a receiver",
            Self::Cam => "a cam file",
            Self::Sender => "the config of a sender",
        }
    }

    /// Command for files of this kind.
    const fn command(self) -> &'static str {
        match self {
            Self::Gear => "coaxle gear plan",
            Self::Saw => "coaxle saw plan",
            Self::Scenario => "coaxle run",
            Self::Gateway => "coaxle gateway",
            Self::Receiver => "coaxle receiver",
            Self::Cam => "coaxle cam check",
            Self::Sender => "coaxle sender",
        }
    }

    fn of_file(document: &Table) -> Option<Self> {
        let has = |kind: &Self| {
            (kind.marks().iter()).any(|mark| document.contains_key(*mark))
                || kind
                    .list()
                    .is_some_and(|list| document.get(list).is_some_and(Value::is_array))
        };
        Self::ALL.into_iter().find(has)
    }

    fn of_schema(schema: &Schema) -> Option<Self> {
        let fields = schema.get("properties")?;
        let has = |kind: &Self| fields.get(kind.own_field()).is_some();
        Self::ALL.into_iter().find(has)
    }
}

/// Refuses a file that is in order as one of another kind.
///
/// # Errors
/// Both kinds, and the command for the file.
pub(crate) fn check_kind(file: &str, schema: &Schema, document: &Table) -> Result<(), ConfigError> {
    let (received, expected) = (ConfigKind::of_file(document), ConfigKind::of_schema(schema));
    let (Some(received), Some(expected)) = (received, expected) else {
        return Ok(());
    };
    if received == expected {
        return Ok(());
    }
    let (name, of) = (received.words(), expected.words());
    let command = received.command();
    let reason = format!("received {name}, expected {of}; for this one: {command} {file}");
    Err(ConfigError::whole(file, reason))
}
