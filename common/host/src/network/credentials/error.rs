//! Errors of a secure profile folder.

use std::fmt::Display;
use std::path::PathBuf;

/// A file that is missing or has other contents.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}, expected what `coaxle secure init` wrote there", file.display())]
pub struct BadCredentials {
    /// The file.
    pub file: PathBuf,
    /// The reason for the error.
    pub reason: String,
}

impl BadCredentials {
    pub(super) fn new(file: PathBuf, reason: impl Display) -> Self {
        let reason = reason.to_string();
        Self { file, reason }
    }
}

/// Reasons why a certificate is not trusted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CredentialsFault {
    /// Expired certificate.
    #[error("the certificate has expired on {0}: renew it with `coaxle secure renew`")]
    Expired(String),
    /// Certificate not valid yet.
    #[error("the certificate does not hold yet: is the clock of this PC right?")]
    NotYet,
    /// Certificate not signed by the authority in the folder.
    #[error(
        "the certificate is of another authority than ca.pem beside it: copy the whole folder anew"
    )]
    OtherAuthority,
    /// Key of another certificate.
    #[error("key.pem belongs to another certificate: copy the whole folder anew")]
    OtherKey,
    /// Any other reason.
    #[error("the certificate cannot be used: {0}")]
    Unusable(String),
}
