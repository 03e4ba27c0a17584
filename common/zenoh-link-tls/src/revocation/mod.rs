//! Revoked certificates: a list signed by the authority of the network, obeyed while the node runs.
//!
//! The list is a file beside the certificate of the authority. It names members whose certificates from before a
//! time are revoked, so that nobody has to keep a record of serial numbers. New handshakes of such a
//! certificate are refused, and its links end.

mod list;
mod verifier;
mod watch;

pub use list::{InvalidRevocations, MOST_LIST_BYTES, REVOKED_FILE, RevocationList};
pub(crate) use verifier::UnrevokedClients;
pub use watch::RevocationWatch;
