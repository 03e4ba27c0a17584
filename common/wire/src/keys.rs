//! Key expressions: `coaxle/<node>/axes`, `/slaves`, `/far-axes`, `/time-requests`, `/time-responses`,
//! `/plans`, `/followers`, `/command`, `/command/<operator>`, `/status`, `/about`, `/rows`, `/audit`, `/alive`, `/seen-by/<node>`, `/runs/<epoch>`.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::channel::Channel;

/// The status of all nodes.
pub const ANY_STATUS_KEY: &str = "coaxle/*/status";
/// The liveliness tokens of all nodes.
pub const ANY_ALIVE_KEY: &str = "coaxle/*/alive";

/// A node's name: one chunk of a key expression.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(inline, extend(
        "pattern" = "^[A-Za-z0-9._-]{1,64}$",
        "x-kind" = "a name of 1 to 64 letters, digits, `-`, `_` or `.`"
    ))
)]
#[serde(try_from = "String", into = "String")]
pub struct NodeName(String);

impl NodeName {
    /// Greatest length of a name, in bytes.
    pub const MAX_LEN: usize = 64;

    /// # Errors
    /// [`InvalidNodeName`] unless the name is 1 to 64 letters, digits, `-`, `_` or `.`.
    pub fn new(name: impl Into<String>) -> Result<Self, InvalidNodeName> {
        let name = name.into();
        let fits = (1..=Self::MAX_LEN).contains(&name.len());
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        if fits && name.chars().all(plain) {
            Ok(Self(name))
        } else {
            Err(InvalidNodeName { received: name })
        }
    }

    /// Returns the name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Returns the node that a key belongs to; none if the key is not a node's.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        let (name, _) = key.strip_prefix("coaxle/")?.split_once('/')?;
        Self::new(name).ok()
    }

    /// Returns the key of the frames of one of its channels.
    #[must_use]
    pub fn channel_key(&self, channel: Channel) -> String {
        format!("coaxle/{self}/{}", channel.name())
    }

    /// Returns the key of its command queryable, see [`crate::command`].
    #[must_use]
    pub fn command_key(&self) -> String {
        format!("coaxle/{self}/command")
    }

    /// Returns the key of the commands of one operator: under access control, only that operator may send
    /// there.
    #[must_use]
    pub fn operator_command_key(&self, operator: &Self) -> String {
        format!("coaxle/{self}/command/{operator}")
    }

    /// Keys of all operators.
    #[must_use]
    pub fn operator_command_keys(&self) -> String {
        format!("coaxle/{self}/command/*")
    }

    /// Returns the key of its status, JSON a few times a second.
    #[must_use]
    pub fn status_key(&self) -> String {
        format!("coaxle/{self}/status")
    }

    /// Returns the key of the description of its axes, JSON: published, and a queryable.
    #[must_use]
    pub fn about_key(&self) -> String {
        format!("coaxle/{self}/about")
    }

    /// Returns the key of its rows for observers: small recordings, published while there is a
    /// subscriber.
    #[must_use]
    pub fn rows_key(&self) -> String {
        format!("coaxle/{self}/rows")
    }

    /// Returns the key of its audit, see [`crate::audit`]: a record when it is made, and a queryable for
    /// the newest ones.
    #[must_use]
    pub fn audit_key(&self) -> String {
        format!("coaxle/{self}/audit")
    }

    /// Returns the key of its liveliness token.
    #[must_use]
    pub fn alive_key(&self) -> String {
        format!("coaxle/{self}/alive")
    }

    /// Returns the key of the liveliness token with which another node reports that it receives what it
    /// follows of this one.
    #[must_use]
    pub fn seen_by_key(&self, other: &Self) -> String {
        format!("coaxle/{self}/seen-by/{other}")
    }

    /// Keys of all such tokens.
    #[must_use]
    pub fn seen_by_keys(&self) -> String {
        format!("coaxle/{self}/seen-by/*")
    }

    /// Returns the key of the liveliness token of one run of it.
    #[must_use]
    pub fn run_key(&self, epoch: u64) -> String {
        format!("coaxle/{self}/runs/{epoch:016x}")
    }

    /// Keys of all of its runs. More than one at a time are nodes of the same name.
    #[must_use]
    pub fn runs_key(&self) -> String {
        format!("coaxle/{self}/runs/*")
    }
}

impl fmt::Display for NodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl TryFrom<String> for NodeName {
    type Error = InvalidNodeName;
    fn try_from(name: String) -> Result<Self, InvalidNodeName> {
        Self::new(name)
    }
}

impl From<NodeName> for String {
    fn from(name: NodeName) -> Self {
        name.0
    }
}

/// Text that cannot be part of a key expression.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{received:?} is no node name, expected 1 to 64 letters, digits, '-', '_' or '.'")]
pub struct InvalidNodeName {
    /// Text received.
    pub received: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_hang_under_the_node() {
        let name = NodeName::new("saw-1").unwrap();
        assert_eq!(name.channel_key(Channel::Axes), "coaxle/saw-1/axes");
        assert_eq!(name.channel_key(Channel::Slaves), "coaxle/saw-1/slaves");
        assert_eq!(name.channel_key(Channel::FarAxes), "coaxle/saw-1/far-axes");
        let requests = name.channel_key(Channel::TimeRequests);
        assert_eq!(requests, "coaxle/saw-1/time-requests");
        assert_eq!(
            name.channel_key(Channel::TimeResponses),
            "coaxle/saw-1/time-responses"
        );
        assert_eq!(name.channel_key(Channel::Plans), "coaxle/saw-1/plans");
        assert_eq!(name.command_key(), "coaxle/saw-1/command");
        let anna = NodeName::new("anna").unwrap();
        assert_eq!(
            name.operator_command_key(&anna),
            "coaxle/saw-1/command/anna"
        );
        assert_eq!(name.operator_command_keys(), "coaxle/saw-1/command/*");
        assert_eq!(name.status_key(), "coaxle/saw-1/status");
        assert_eq!(name.about_key(), "coaxle/saw-1/about");
        assert_eq!(name.audit_key(), "coaxle/saw-1/audit");
        assert_eq!(name.alive_key(), "coaxle/saw-1/alive");
        assert_eq!(name.seen_by_key(&anna), "coaxle/saw-1/seen-by/anna");
        assert_eq!(name.seen_by_keys(), "coaxle/saw-1/seen-by/*");
        assert_eq!(name.run_key(0xab), "coaxle/saw-1/runs/00000000000000ab");
        assert_eq!(name.runs_key(), "coaxle/saw-1/runs/*");
        for key in [name.runs_key(), name.status_key(), name.alive_key()] {
            assert_eq!(NodeName::of_key(&key).as_ref(), Some(&name));
        }
        for key in [
            "coaxle/saw-1",
            "coaxle//alive",
            "other/saw-1/alive",
            "coaxle/*/alive",
        ] {
            assert_eq!(NodeName::of_key(key), None, "{key}");
        }
    }

    #[test]
    fn names_that_would_change_a_key_are_refused() {
        for name in ["", "a/b", "*", "a b", "ä", &"x".repeat(65)] {
            assert!(NodeName::new(name).is_err(), "{name:?}");
        }
    }
}
