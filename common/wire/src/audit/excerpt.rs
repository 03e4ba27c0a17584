//! Queries of the audit of a running node, and their replies.

use serde::{Deserialize, Serialize};

use super::invalid::{AUDIT_VERSION, InvalidAudit};
use super::record::AuditRecord;
use super::trail::AuditTrail;
use crate::keys::NodeName;

/// Greatest length of a reply, in bytes: in a secure network a longer one than 1 MiB is dropped.
pub const MAX_EXCERPT_BYTES: usize = 1 << 19;

/// Number of records in the reply to a query that names none.
const NEWEST: u64 = 100;

/// Query of records. An empty one is for the newest hundred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditQuery {
    /// Version of everything else.
    pub version: u32,
    /// Greatest number of records: the newest ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub newest: Option<u64>,
    /// Only records after the one of this number: the oldest of them first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<u64>,
}

impl AuditQuery {
    /// Makes a query for the newest records.
    #[must_use]
    pub const fn newest(count: u64) -> Self {
        Self {
            version: AUDIT_VERSION,
            newest: Some(count),
            after: None,
        }
    }

    /// Makes a query for the records after a known one.
    #[must_use]
    pub const fn after(number: u64) -> Self {
        Self {
            version: AUDIT_VERSION,
            newest: None,
            after: Some(number),
        }
    }

    /// Reads a query.
    ///
    /// # Errors
    /// [`InvalidAudit`]: bytes that are not a query of this version.
    pub fn from_json(bytes: &[u8]) -> Result<Self, InvalidAudit> {
        if bytes.is_empty() {
            return Ok(Self::newest(NEWEST));
        }
        let query: Self = serde_json::from_slice(bytes)?;
        InvalidAudit::check(query.version)?;
        Ok(query)
    }

    /// Writes the query.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("all keys of a query are texts")
    }
}

/// Reply to a query.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AuditExcerpt {
    /// Version of everything else.
    pub version: u32,
    /// The node.
    pub node: NodeName,
    /// Its run.
    pub run: String,
    /// Number of its newest record; 0 without any.
    pub newest: u64,
    /// Records, the oldest first.
    pub records: Vec<AuditRecord>,
}

impl AuditExcerpt {
    /// Answers a query.
    #[must_use]
    pub fn of(trail: &AuditTrail, query: &AuditQuery) -> Self {
        let most = query.newest.unwrap_or(match query.after {
            Some(_) => u64::MAX,
            None => NEWEST,
        });
        let mut bytes = 0;
        let mut fits = |record: &&AuditRecord| {
            bytes += record.to_json().len() + 1;
            bytes <= MAX_EXCERPT_BYTES
        };
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        let records = match query.after {
            Some(after) => {
                let next = trail.after(after).take(most).take_while(&mut fits);
                next.cloned().collect()
            }
            // From the newest one back, and then turned round.
            None => {
                let newest = trail.after(0).rev().take(most).take_while(&mut fits);
                let mut records: Vec<_> = newest.cloned().collect();
                records.reverse();
                records
            }
        };
        Self {
            version: AUDIT_VERSION,
            node: trail.node().clone(),
            run: trail.run().to_owned(),
            newest: trail.newest(),
            records,
        }
    }

    /// Reads a reply. Unknown fields are ignored.
    ///
    /// # Errors
    /// [`InvalidAudit`]: bytes that are not a reply of this version.
    pub fn from_json(bytes: &[u8]) -> Result<Self, InvalidAudit> {
        let excerpt: Self = serde_json::from_slice(bytes)?;
        InvalidAudit::check(excerpt.version)?;
        Ok(excerpt)
    }

    /// Writes the reply.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("all keys of an excerpt are texts")
    }
}

#[cfg(test)]
mod tests {
    use coaxle_clock::Span;

    use super::super::{AuditDoor, AuditEntry, AuditOutcome, AuditTime};
    use super::*;

    fn trail(count: i64, reason: &str) -> AuditTrail {
        let mut trail = AuditTrail::new(NodeName::new("saw").unwrap(), 5);
        for n in 0..count {
            let at = AuditTime {
                wall_us: n,
                since_start: Span::from_millis(n),
            };
            let entry = AuditEntry::new(AuditDoor::Order, None, "MC_Power", AuditOutcome::Accepted);
            trail.note(at, entry.because(reason), &mut |_| {});
        }
        trail
    }

    fn numbers(trail: &AuditTrail, query: &str) -> Vec<u64> {
        let query = AuditQuery::from_json(query.as_bytes()).unwrap();
        let excerpt = AuditExcerpt::of(trail, &query);
        let again = AuditExcerpt::from_json(excerpt.to_json().as_bytes()).unwrap();
        assert_eq!(again, excerpt);
        assert_eq!(excerpt.newest, trail.newest());
        excerpt.records.iter().map(|record| record.number).collect()
    }

    #[test]
    fn the_newest_or_those_after_a_known_one_are_returned() {
        let trail = trail(300, "");
        assert_eq!(numbers(&trail, ""), (201..=300).collect::<Vec<_>>());
        let newest = AuditQuery::newest(3).to_json();
        assert_eq!(newest, r#"{"version":1,"newest":3}"#);
        assert_eq!(numbers(&trail, &newest), [298, 299, 300]);
        let after = AuditQuery::after(297).to_json();
        assert_eq!(numbers(&trail, &after), [298, 299, 300]);
        assert_eq!(
            numbers(&trail, r#"{"version":1,"newest":2,"after":100}"#),
            [101, 102]
        );
        assert!(numbers(&trail, r#"{"version":1,"after":300}"#).is_empty());
        for bad in [r#"{"version":2}"#, r#"{"version":1,"last":3}"#, "{", "7"] {
            assert!(AuditQuery::from_json(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_reply_fits_into_a_message() {
        // Two bytes each, and escaped: the longest reason.
        let trail = trail(1_100, &"\"ä".repeat(200));
        let all = AuditExcerpt::of(&trail, &AuditQuery::newest(u64::MAX));
        assert!(all.records.len() > 500, "{}", all.records.len());
        assert_eq!(all.records.last().map(|record| record.number), Some(1_100));
        assert!(all.to_json().len() < MAX_EXCERPT_BYTES + 200);
        let next = AuditExcerpt::of(&trail, &AuditQuery::after(0));
        assert_eq!(next.records.first().map(|record| record.number), Some(77));
        assert!(next.to_json().len() < MAX_EXCERPT_BYTES + 200);
    }
}
