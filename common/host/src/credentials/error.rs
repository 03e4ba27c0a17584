//! What is wrong with a folder of the secure profile.

use std::fmt::Display;
use std::path::PathBuf;

/// A file that is missing, or that holds something else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}, expected what `coaxle secure init` wrote there", file.display())]
pub struct BadCredentials {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub reason: String,
}

impl BadCredentials {
    pub(super) fn new(file: PathBuf, reason: impl Display) -> Self {
        let reason = reason.to_string();
        Self { file, reason }
    }
}

/// Why nobody believes what the files say.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CredentialsFault {
    /// Its time is over.
    #[error("the certificate has expired on {0}: renew it with `coaxle secure renew`")]
    Expired(String),
    /// Its time has not come.
    #[error("the certificate does not hold yet: is the clock of this PC right?")]
    NotYet,
    /// It is not signed by the authority beside it.
    #[error(
        "the certificate is of another authority than ca.pem beside it: copy the whole folder anew"
    )]
    OtherAuthority,
    /// The key is that of another certificate.
    #[error("key.pem belongs to another certificate: copy the whole folder anew")]
    OtherKey,
    /// Something else.
    #[error("the certificate cannot be used: {0}")]
    Unusable(String),
}
