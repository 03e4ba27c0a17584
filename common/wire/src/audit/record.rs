//! Record of the audit.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::invalid::InvalidAudit;
use crate::keys::NodeName;
use crate::one_line::one_line;

/// Greatest length of a name in a record, in characters: that of a node's name, or an IPv6 address with its port.
const NAME_CHARACTERS: usize = 64;
/// Greatest length of a reason, in characters. Refusals of commands have some 150.
const REASON_CHARACTERS: usize = 240;

/// Part of the node that was asked for something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AuditDoor {
    /// The node itself: its start and its end.
    Run,
    /// Orders to its slaves, its plates and its far nodes.
    Order,
    /// Connections to its listeners, and links to other members.
    Connection,
    /// Its timing channel.
    Beacon,
    /// The page that it serves.
    Page,
    /// Rights: what another member denies it.
    Right,
}

impl AuditDoor {
    /// All of them, in the order of their declaration.
    pub const ALL: [Self; 6] = [
        Self::Run,
        Self::Order,
        Self::Connection,
        Self::Beacon,
        Self::Page,
        Self::Right,
    ];

    /// Name in records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Run => "run",
            Self::Order => "order",
            Self::Connection => "connection",
            Self::Beacon => "beacon",
            Self::Page => "page",
            Self::Right => "right",
        }
    }
}

/// Result of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AuditOutcome {
    /// Done, or begun.
    Accepted,
    /// Refused.
    Refused,
    /// Lost before the part that would have decided.
    NotTaken,
    /// Something that existed was ended.
    Ended,
}

impl AuditOutcome {
    const fn words(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Refused => "refused",
            Self::NotTaken => "not taken",
            Self::Ended => "ended",
        }
    }

    /// True for a request that had no effect.
    #[must_use]
    pub const fn is_refusal(self) -> bool {
        matches!(self, Self::Refused | Self::NotTaken)
    }
}

/// Report of a part of the node, with texts on one line and bounded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AuditEntry {
    /// Part of the node that was asked.
    pub door: AuditDoor,
    /// Client: the name of an operator or a node, or an address; none without a name.
    pub actor: Option<String>,
    /// Action: the PLC name of a command, `handshake`, a path of the page.
    pub action: String,
    /// Object of the action: a slave, a cam plate, a far node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
    /// Result.
    pub outcome: AuditOutcome,
    /// Reason of a refusal, or a detail of the result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl AuditEntry {
    /// Makes an entry without an object and a reason.
    #[must_use]
    pub fn new(door: AuditDoor, actor: Option<&str>, action: &str, outcome: AuditOutcome) -> Self {
        Self {
            door,
            actor: actor.map(|actor| clipped(actor, NAME_CHARACTERS)),
            action: clipped(action, NAME_CHARACTERS),
            object: None,
            outcome,
            reason: None,
        }
    }

    /// Adds the object.
    #[must_use]
    pub fn on(mut self, object: &str) -> Self {
        self.object = Some(clipped(object, NAME_CHARACTERS));
        self
    }

    /// Adds the reason.
    #[must_use]
    pub fn because(mut self, reason: &str) -> Self {
        self.reason = Some(clipped(reason, REASON_CHARACTERS));
        self
    }

    /// Returns the client in words: `order of "anna"`.
    #[must_use]
    pub fn client(&self) -> String {
        let door = self.door.name();
        match &self.actor {
            Some(actor) => format!("{door} of {actor:?}"),
            None => format!("{door} of somebody without a name"),
        }
    }

    /// Returns the request in words: `MC_Power to "carriage"`.
    #[must_use]
    pub fn request(&self) -> String {
        match &self.object {
            Some(object) => format!("{} to {object:?}", self.action),
            None => self.action.clone(),
        }
    }

    /// Returns the result in words: `refused, the axis moves`.
    #[must_use]
    pub fn result(&self) -> String {
        match &self.reason {
            Some(reason) => format!("{}, {reason}", self.outcome.words()),
            None => self.outcome.words().to_owned(),
        }
    }
}

impl fmt::Display for AuditEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {}: {}",
            self.client(),
            self.request(),
            self.result()
        )
    }
}

/// Numbered entry.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AuditRecord {
    /// Version of everything else.
    pub version: u32,
    /// The node.
    pub node: NodeName,
    /// Its run: the epoch, in 16 hexadecimal digits.
    pub run: String,
    /// Number of the record in the run, from 1, without gaps: a missing one was lost on its way.
    pub number: u64,
    /// Wall clock of the node, microseconds since 1970.
    pub at_us: i64,
    /// The entry; of several, the last one.
    #[serde(flatten)]
    pub entry: AuditEntry,
    /// Number of entries that it stands for: more than one for a flood of refusals.
    pub count: u64,
}

impl AuditRecord {
    /// Writes the record.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("all keys of a record are texts")
    }

    /// Reads a record. Unknown fields are ignored.
    ///
    /// # Errors
    /// [`InvalidAudit`]: bytes that are not a record of this version.
    pub fn from_json(bytes: &[u8]) -> Result<Self, InvalidAudit> {
        let record: Self = serde_json::from_slice(bytes)?;
        InvalidAudit::check(record.version)?;
        Ok(record)
    }
}

impl fmt::Display for AuditRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.number, self.entry)?;
        match self.count {
            0 | 1 => Ok(()),
            count => write!(f, " (the last of {count} within a second)"),
        }
    }
}

/// A text of a client on one line, and not longer than this.
fn clipped(text: &str, characters: usize) -> String {
    let line = one_line(text);
    match line.char_indices().nth(characters) {
        None => line,
        Some((end, _)) => format!("{}…", &line[..end]),
    }
}

#[cfg(test)]
mod tests {
    use super::super::AUDIT_VERSION;
    use super::*;

    fn record(entry: AuditEntry, count: u64) -> AuditRecord {
        AuditRecord {
            version: AUDIT_VERSION,
            node: NodeName::new("saw").unwrap(),
            run: "000000000000f00d".to_owned(),
            number: 7,
            at_us: 1_790_000_000_000_001,
            entry,
            count,
        }
    }

    #[test]
    fn a_record_is_the_json_of_the_manual_and_comes_back() {
        let entry = AuditEntry::new(
            AuditDoor::Order,
            Some("anna"),
            "MC_Power",
            AuditOutcome::Accepted,
        );
        let entry = entry.on("carriage").because("job 3");
        let record = record(entry, 1);
        let json = r#"{"version":1,"node":"saw","run":"000000000000f00d","number":7,"at_us":1790000000000001,"door":"order","actor":"anna","action":"MC_Power","object":"carriage","outcome":"accepted","reason":"job 3","count":1}"#;
        assert_eq!(record.to_json(), json);
        assert_eq!(AuditRecord::from_json(json.as_bytes()).unwrap(), record);
        let other = json.replace("\"version\":1", "\"version\":2");
        let error = AuditRecord::from_json(other.as_bytes()).unwrap_err();
        assert!(
            error.to_string().contains("received 2, expected 1"),
            "{error}"
        );
    }

    #[test]
    fn a_record_is_one_line_for_people() {
        let refused = |actor| AuditEntry::new(actor, None, "handshake", AuditOutcome::Refused);
        let flood = record(
            refused(AuditDoor::Connection).because("no certificate"),
            7_300,
        );
        assert_eq!(
            flood.to_string(),
            "7: connection of somebody without a name: handshake: refused, no certificate \
             (the last of 7300 within a second)"
        );
    }

    #[test]
    fn texts_of_clients_are_bounded() {
        let long = "\u{1b}[2J\n".repeat(1_000);
        let entry = AuditEntry::new(AuditDoor::Page, Some(&long), &long, AuditOutcome::NotTaken);
        let json = record(entry.on(&long).because(&long), 1).to_json();
        // Escaped, so that a terminal takes no order from it.
        assert!(json.len() < 1_024 && !json.contains("\\u001b["), "{json}");
    }
}
