//! Bytes that are refused, and the version of the others.

/// Version of the objects of an audit.
pub const AUDIT_VERSION: u32 = 1;

/// Bytes that are not a record, a query or a reply of this version.
#[derive(Debug, thiserror::Error)]
pub enum InvalidAudit {
    /// No such object.
    #[error("{0}")]
    Json(#[from] serde_json::Error),
    /// Another version.
    #[error("version: received {0}, expected {AUDIT_VERSION}")]
    Version(u32),
}

impl InvalidAudit {
    pub(super) const fn check(version: u32) -> Result<(), Self> {
        match version {
            AUDIT_VERSION => Ok(()),
            other => Err(Self::Version(other)),
        }
    }
}
