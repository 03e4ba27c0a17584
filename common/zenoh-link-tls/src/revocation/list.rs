//! The list as a file, and its signature.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, alg_id};
use x509_parser::prelude::{FromDer, X509Certificate};

use crate::certificate::CertifiedPeer;

/// Name of the file in the folder of a member.
pub const REVOKED_FILE: &str = "revoked.list";

/// Greatest length of the file, in bytes.
// Ten thousand names of the greatest length.
pub const MOST_LIST_BYTES: u64 = 1 << 20;

/// First line of the file. No certificate begins with it: the signature of the one is never that of the other.
const FIRST_LINE: &str = "coaxle revoked certificates 1";

/// Members whose certificates are revoked.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RevocationList {
    /// Number of the list: a later one replaces an earlier one, and never the other way round.
    pub number: u64,
    /// Of each name, the time before which its certificates are revoked: the beginning of the validity of the
    /// first one that is not, in seconds since 1970.
    pub before: BTreeMap<String, u64>,
}

/// A file that is not a list of the authority.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidRevocations {
    /// A wrong line.
    #[error("line {line}: received {received:?}, expected {expected}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// What was received.
        received: String,
        /// What a list has there.
        expected: &'static str,
    },
    /// A signature of somebody else, or of another text.
    #[error("it is not signed by the authority in ca.pem beside it")]
    Signature,
}

impl RevocationList {
    /// True if the list revokes a certificate of this name whose validity begins at `from`, in seconds since 1970.
    #[must_use]
    pub fn revokes(&self, name: &str, from: u64) -> bool {
        self.before.get(name).is_some_and(|before| from < *before)
    }

    /// Returns the reason in words if the certificate of a peer is revoked.
    pub(crate) fn revocation(&self, peer: &CertifiedPeer) -> Option<String> {
        let name = peer.name.as_deref()?;
        let is_revoked = self.revokes(name, peer.issued);
        is_revoked.then(|| format!("the certificate of {name:?} is revoked"))
    }

    /// Returns the text that the authority signs.
    #[must_use]
    pub fn unsigned(&self) -> String {
        let mut text = format!("{FIRST_LINE}\nnumber {}\n", self.number);
        for (name, before) in &self.before {
            let _ = writeln!(text, "before {before} {name}");
        }
        text
    }

    /// Writes the file with this signature of [`Self::unsigned`]: ECDSA over P-256 with SHA-256, in ASN.1.
    #[must_use]
    pub fn signed(&self, signature: &[u8]) -> String {
        let digits: String = signature.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{}signature {digits}\n", self.unsigned())
    }

    /// Reads a file that was signed by one of the authorities in a PEM file.
    ///
    /// # Errors
    /// [`InvalidRevocations`].
    pub fn read_pem(text: &str, authorities: &str) -> Result<Self, InvalidRevocations> {
        let authorities = CertificateDer::pem_slice_iter(authorities.as_bytes());
        let authorities: Vec<_> = authorities.filter_map(Result::ok).collect();
        Self::read(text, &authorities)
    }

    /// Reads a file that was signed by one of these authorities.
    ///
    /// # Errors
    /// [`InvalidRevocations`].
    pub fn read(
        text: &str,
        authorities: &[CertificateDer<'_>],
    ) -> Result<Self, InvalidRevocations> {
        let wrong = |line, received: &str, expected| InvalidRevocations::Line {
            line,
            received: received.chars().take(80).collect(),
            expected,
        };
        let lines: Vec<_> = text.lines().collect();
        let at = |line: usize| lines.get(line).copied().unwrap_or_default();
        if at(0) != FIRST_LINE {
            return Err(wrong(
                1,
                at(0),
                "the first line of a list of revoked certificates",
            ));
        }
        let number = at(1).strip_prefix("number ").and_then(|it| it.parse().ok());
        let mut list = Self {
            number: number.ok_or_else(|| wrong(2, at(1), "`number` and its number"))?,
            before: BTreeMap::new(),
        };
        let last = lines.len() - 1;
        for line in 2..last {
            let words: Vec<_> = at(line).split(' ').collect();
            let entry = match words[..] {
                ["before", before, name] => before.parse().ok().map(|before| (name, before)),
                _ => None,
            };
            let entry = entry.ok_or_else(|| wrong(line + 1, at(line), "`before SECONDS NAME`"))?;
            list.before.insert(entry.0.to_owned(), entry.1);
        }
        let signature = at(last).strip_prefix("signature ").and_then(bytes);
        let signature = signature
            .ok_or_else(|| wrong(last + 1, at(last), "`signature` and hexadecimal digits"))?;
        // Over the list as it was understood: what is not understood is not signed.
        let unsigned = list.unsigned();
        let is_by = |authority: &CertificateDer<'_>| is_signed(&unsigned, &signature, authority);
        match authorities.iter().any(is_by) {
            true => Ok(list),
            false => Err(InvalidRevocations::Signature),
        }
    }
}

fn is_signed(text: &str, signature: &[u8], authority: &CertificateDer<'_>) -> bool {
    let Ok((_, authority)) = X509Certificate::from_der(authority) else {
        return false;
    };
    let key = &authority.public_key().subject_public_key.data;
    let known = ring::default_provider().signature_verification_algorithms;
    let mut fitting = known.all.iter().filter(|algorithm| {
        algorithm.public_key_alg_id() == alg_id::ECDSA_P256
            && algorithm.signature_alg_id() == alg_id::ECDSA_SHA256
    });
    fitting.any(|algorithm| {
        let verified = algorithm.verify_signature(key, text.as_bytes(), signature);
        verified.is_ok()
    })
}

fn bytes(digits: &str) -> Option<Vec<u8>> {
    if !digits.len().is_multiple_of(2) || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let byte = |at| u8::from_str_radix(&digits[at..at + 2], 16).ok();
    (0..digits.len()).step_by(2).map(byte).collect()
}

#[cfg(test)]
mod tests {
    use rcgen::{BasicConstraints, CertificateParams, IsCa, KeyPair, SigningKey};

    use super::*;

    fn authority() -> (KeyPair, CertificateDer<'static>) {
        let key = KeyPair::generate().expect("a key");
        let mut params = CertificateParams::default();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let certificate = params.self_signed(&key).expect("a certificate");
        (key, certificate.der().clone())
    }

    #[test]
    fn only_a_list_of_the_authority_is_a_list() {
        let ((key, ours), (other_key, theirs)) = (authority(), authority());
        let list = RevocationList {
            number: 3,
            before: [("saw".to_owned(), 1_790_000_000)].into(),
        };
        let sign = |key: &KeyPair| list.signed(&key.sign(list.unsigned().as_bytes()).expect("it"));
        let text = sign(&key);
        let both = [theirs, ours];
        assert_eq!(RevocationList::read(&text, &both), Ok(list.clone()));
        let refused = |text: &str| {
            RevocationList::read(text, &both[1..])
                .expect_err("no list")
                .to_string()
        };
        let not_signed = "it is not signed by the authority in ca.pem beside it";
        assert_eq!(refused(&sign(&other_key)), not_signed);
        // Nothing can be changed, added or left out.
        for (from, to) in [
            ("number 3", "number 4"),
            ("1790000000", "1790000001"),
            ("before 1790000000 saw\n", ""),
            ("signature", "before 7 line\nsignature"),
        ] {
            assert_eq!(refused(&text.replace(from, to)), not_signed, "{to}");
        }
        for (bad, expected) in [
            (String::new(), "line 1: received \"\""),
            (
                text.replace("number 3", "number"),
                "line 2: received \"number\"",
            ),
            (
                text.replace("before", "after"),
                "line 3: received \"after 17",
            ),
            (
                text.replace("signature ", "signature x"),
                "line 4: received",
            ),
            (
                text.lines()
                    .take(2)
                    .map(|line| format!("{line}\n"))
                    .collect(),
                "line 2",
            ),
        ] {
            assert!(refused(&bad).starts_with(expected), "{}", refused(&bad));
        }
        assert!(list.revokes("saw", 1_789_999_999) && !list.revokes("saw", 1_790_000_000));
        assert!(!list.revokes("line", 0));
    }
}
