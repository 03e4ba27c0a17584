//! Authentication of beacons in a secure network by a secret that two nodes share.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use hmac::{Hmac, Mac};
use sha2::Sha256;

/// Length of a secret, in bytes.
pub const SECRET_LEN: usize = 32;
/// Length of the tag at the end of a beacon, in bytes.
pub(super) const TAG_LEN: usize = 16;

/// Secret with its key schedule prepared: HMAC-SHA-256, truncated to its first half when sent.
#[derive(Clone)]
pub struct BeaconSecret {
    mac: Hmac<Sha256>,
    /// Shared by all copies.
    is_withdrawn: Arc<AtomicBool>,
}

/// Text that is not a secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("received {received} characters, expected {} hexadecimal digits", 2 * SECRET_LEN)]
pub struct InvalidSecret {
    /// Number of characters received.
    pub received: usize,
}

impl BeaconSecret {
    /// Makes the secret of these bytes.
    #[must_use]
    pub fn new(secret: &[u8; SECRET_LEN]) -> Self {
        Self {
            mac: Hmac::new_from_slice(secret).expect("a key of any length will do"),
            is_withdrawn: Arc::default(),
        }
    }

    /// Reads the secret from the text of its file: hexadecimal digits and a new line.
    ///
    /// # Errors
    /// [`InvalidSecret`], which quotes nothing of the text.
    pub fn from_hex(text: &str) -> Result<Self, InvalidSecret> {
        bytes_of_hex(text).map(|secret| Self::new(&secret))
    }

    /// Withdraws the secret with all copies of it: nothing is sealed or accepted with it any more.
    pub(super) fn withdraw(&self) {
        self.is_withdrawn.store(true, Ordering::Relaxed);
    }

    /// True after [`Self::withdraw`].
    pub(super) fn is_withdrawn(&self) -> bool {
        // A flag on its own: a beacon more or less does not matter.
        self.is_withdrawn.load(Ordering::Relaxed)
    }

    pub(super) fn tag(&self, key: &str, content: &[u8]) -> [u8; TAG_LEN] {
        let whole = self.over(key, content).finalize().into_bytes();
        let mut tag = [0; TAG_LEN];
        tag.copy_from_slice(&whole[..TAG_LEN]);
        tag
    }

    /// Compares the tag in constant time.
    pub(super) fn fits(&self, key: &str, content: &[u8], tag: &[u8; TAG_LEN]) -> bool {
        !self.is_withdrawn() && self.over(key, content).verify_truncated_left(tag).is_ok()
    }

    /// Starts the HMAC over key and content. The key contains no zero byte, so no part of it can be taken
    /// for content.
    fn over(&self, key: &str, content: &[u8]) -> Hmac<Sha256> {
        let mut mac = self.mac.clone();
        mac.update(key.as_bytes());
        mac.update(&[0]);
        mac.update(content);
        mac
    }
}

/// Reads the bytes of a secret from hexadecimal digits.
pub(super) fn bytes_of_hex(text: &str) -> Result<[u8; SECRET_LEN], InvalidSecret> {
    let text = text.trim();
    let received = text.chars().count();
    let mut secret = [0; SECRET_LEN];
    if text.len() != 2 * SECRET_LEN || !text.is_ascii() {
        return Err(InvalidSecret { received });
    }
    for (byte, digits) in secret.iter_mut().zip(text.as_bytes().chunks(2)) {
        let digits = std::str::from_utf8(digits).map_err(|_| InvalidSecret { received })?;
        // A sign would be taken for part of the number.
        let are_digits = digits.chars().all(|digit| digit.is_ascii_hexdigit());
        let number = u8::from_str_radix(digits, 16).ok().filter(|_| are_digits);
        *byte = number.ok_or(InvalidSecret { received })?;
    }
    Ok(secret)
}

/// Writes bytes as hexadecimal digits.
pub(super) fn hex_of(secret: &[u8; SECRET_LEN]) -> String {
    secret.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Keeps the secret out of all output.
impl fmt::Debug for BeaconSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("BeaconSecret")
    }
}
