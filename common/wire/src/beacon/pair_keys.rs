//! Keys of the timing channel, a different one for each pair of nodes.

use std::fmt::{self, Write as _};

use super::hkdf;
use super::secret::{BeaconSecret, InvalidSecret, SECRET_LEN, bytes_of_hex, hex_of};
use crate::frame::sender_id;
use crate::keys::NodeName;

/// Purpose of the derived keys: the same secret never gives a key of another protocol.
const PURPOSE: &str = "coaxle timing channel 1";

/// Secret of a network, from which the keys of all pairs are derived. It stays with the authority.
#[derive(Clone)]
pub struct TimingSecret([u8; SECRET_LEN]);

impl TimingSecret {
    /// Makes the secret of these bytes.
    #[must_use]
    pub const fn new(secret: [u8; SECRET_LEN]) -> Self {
        Self(secret)
    }

    /// Reads the secret from the text of its file: hexadecimal digits and a new line.
    ///
    /// # Errors
    /// [`InvalidSecret`], which quotes nothing of the text.
    pub fn from_hex(text: &str) -> Result<Self, InvalidSecret> {
        bytes_of_hex(text).map(Self)
    }

    /// Writes the secret as its file has it.
    #[must_use]
    pub fn to_hex(&self) -> String {
        hex_of(&self.0) + "\n"
    }

    /// Returns the key of a pair, in whatever order: HKDF-SHA-256 (RFC 5869) over the names. `generation` is
    /// that of its names, see [`PairKeys`].
    #[must_use]
    pub fn pair(&self, one: &NodeName, other: &NodeName, generation: u64) -> [u8; SECRET_LEN] {
        let (first, second) = if one <= other {
            (one, other)
        } else {
            (other, one)
        };
        // Names have no blanks and no line breaks: no two pairs share an `info`.
        let info = format!("{PURPOSE}\n{first} {second} {generation}");
        let mut key = [0; SECRET_LEN];
        hkdf::derive(&[], &self.0, info.as_bytes(), &mut key);
        key
    }
}

/// Keeps the secret out of all output.
impl fmt::Debug for TimingSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TimingSecret")
    }
}

/// Keys of a node, one for each other node that it shares a timing channel with.
///
/// The generation of a key is the time, in seconds since 1970, before which certificates of either name
/// were revoked; 0 if none was.
#[derive(Clone, Debug, Default)]
pub struct PairKeys(Vec<PairKey>);

#[derive(Clone, Debug)]
struct PairKey {
    node: NodeName,
    id: u32,
    generation: u64,
    secret: BeaconSecret,
}

/// Line of a file that is no key of a pair.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {reason}, expected NODE, a number and {} hexadecimal digits", 2 * SECRET_LEN)]
pub struct InvalidPairKeys {
    /// Number of the line, from 1.
    pub line: usize,
    /// What was received, without any part of a key.
    pub reason: String,
}

impl PairKeys {
    /// Derives the keys of a node that holds the secret of the network, as all nodes did in earlier versions.
    #[must_use]
    pub fn derived<'a>(
        secret: &TimingSecret,
        own: &NodeName,
        others: impl IntoIterator<Item = &'a NodeName>,
    ) -> Self {
        let mut keys = Self::default();
        for other in others {
            keys.add(other.clone(), 0, &secret.pair(own, other, 0));
        }
        keys
    }

    /// Adds the key of the pair with this node. An earlier one of it is replaced.
    pub fn add(&mut self, node: NodeName, generation: u64, key: &[u8; SECRET_LEN]) {
        self.0.retain(|known| known.node != node);
        self.0.push(PairKey {
            id: sender_id(&node),
            node,
            generation,
            secret: BeaconSecret::new(key),
        });
    }

    /// Reads the file of a node: a line `NODE GENERATION KEY` for each pair; lines with `#` are comments.
    ///
    /// # Errors
    /// [`InvalidPairKeys`], which quotes nothing of a key.
    pub fn from_text(text: &str) -> Result<Self, InvalidPairKeys> {
        let mut keys = Self::default();
        for (line, text) in (1..).zip(text.lines()) {
            let wrong = |reason: String| InvalidPairKeys { line, reason };
            if text.trim().is_empty() || text.starts_with('#') {
                continue;
            }
            let words: Vec<_> = text.split_whitespace().collect();
            let [node, generation, key] = words[..] else {
                return Err(wrong(format!("received {} words", words.len())));
            };
            let node = NodeName::new(node).map_err(|error| wrong(error.to_string()))?;
            let generation = generation.parse();
            let generation = generation.map_err(|_| wrong("received no number".to_owned()))?;
            let key = bytes_of_hex(key).map_err(|error| wrong(error.to_string()))?;
            keys.add(node, generation, &key);
        }
        Ok(keys)
    }

    /// Writes a line of such a file.
    #[must_use]
    pub fn line(node: &NodeName, generation: u64, key: &[u8; SECRET_LEN]) -> String {
        let mut line = format!("{node} {generation} ");
        let _ = writeln!(line, "{}", hex_of(key));
        line
    }

    /// True without any key.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Key of the pair with this node.
    #[must_use]
    pub fn of(&self, node: &NodeName) -> Option<&BeaconSecret> {
        let found = self.0.iter().find(|key| key.node == *node);
        found.map(|key| &key.secret)
    }

    /// Key of the pair with the requester of a beacon.
    pub(super) fn of_requester(&self, id: u32) -> Option<&BeaconSecret> {
        let found = self.0.iter().find(|key| key.id == id);
        found.map(|key| &key.secret)
    }

    /// Withdraws the key of a node whose certificates from before this time were revoked, unless it was made for
    /// that: no beacon is sealed or accepted with it any more, by any copy of it.
    pub fn withdraw(&self, node: &str, before: u64) {
        let old = self.0.iter();
        let old = old.filter(|key| key.node.as_str() == node && key.generation < before);
        old.for_each(|key| key.secret.withdraw());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(name: &str) -> NodeName {
        NodeName::new(name).unwrap()
    }

    #[test]
    fn a_pair_has_one_key_and_every_other_pair_another() {
        let secret = TimingSecret::new([7; SECRET_LEN]);
        let (line, saw, press) = (name("line"), name("saw"), name("press"));
        let key = secret.pair(&line, &saw, 0);
        assert_eq!(key, secret.pair(&saw, &line, 0));
        for other in [
            secret.pair(&line, &press, 0),
            secret.pair(&saw, &press, 0),
            secret.pair(&line, &saw, 1),
            TimingSecret::new([8; SECRET_LEN]).pair(&line, &saw, 0),
        ] {
            assert_ne!(key, other);
        }
        // By hmac and hashlib of Python; fixed, so that nodes of different versions stay compatible.
        let expected = "464ccef8ffdf0499b73a709b733762d85cf7770a116f3e795807e01ae0588a70";
        assert_eq!(hex_of(&key), expected);
    }

    #[test]
    fn a_file_of_keys_comes_back_and_a_wrong_line_is_named() {
        let key = [0xab; SECRET_LEN];
        let text = format!("# of saw\n\n{}", PairKeys::line(&name("line"), 7, &key));
        let keys = PairKeys::from_text(&text).unwrap();
        assert!(keys.of(&name("line")).is_some() && keys.of(&name("saw")).is_none());
        assert!(!format!("{keys:?}").contains("abab"));
        for (bad, expected) in [
            ("line 7", "line 1: received 2 words, expected NODE"),
            ("a/b 7 ab", "line 1: \"a/b\" is no node name"),
            ("\nline x ab", "line 2: received no number"),
            ("line 7 secret", "line 1: received 6 characters"),
        ] {
            let error = PairKeys::from_text(bad).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
            assert!(!error.contains("secret"), "{error}");
        }
    }
}
