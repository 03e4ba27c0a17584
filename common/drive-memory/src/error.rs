//! Errors of a shared file.

use std::path::PathBuf;

/// Reason why a file cannot be shared with a drive process.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct SharedMemoryError {
    /// The file.
    pub path: PathBuf,
    /// The reason for the error.
    #[source]
    pub reason: Reason,
}

impl SharedMemoryError {
    /// True if there is no running node, or another process is attached: a later attempt may succeed.
    #[must_use]
    pub const fn may_pass(&self) -> bool {
        matches!(
            self.reason,
            Reason::NoNode | Reason::Ended | Reason::UsedByProcess { .. }
        )
    }
}

/// Reasons why a file cannot be shared.
#[derive(Debug, thiserror::Error)]
pub enum Reason {
    /// Error of the system.
    #[error("cannot be {what}: {source}")]
    System {
        /// The operation attempted.
        what: &'static str,
        /// The system's error.
        source: std::io::Error,
    },
    /// Not a regular file.
    #[error("received {received}, expected a regular file or none")]
    NoFile {
        /// Kind of file found.
        received: &'static str,
    },
    /// Rights for others, or to execute.
    #[error(
        "received mode {received:o}, expected 660 or less, nothing for others: remove the file"
    )]
    Mode {
        /// File mode.
        received: u32,
    },
    /// In use by another node.
    #[error(
        "is used by another node (process {pid}), expected a file of its own for each slave; if that node \
         hangs, end it first"
    )]
    UsedByNode {
        /// Process id of the node.
        pid: u64,
    },
    /// In use by another drive process.
    #[error("another drive process is attached (process {pid}), expected one at a time")]
    UsedByProcess {
        /// Process id of the drive process.
        pid: u64,
    },
    /// Missing file, or not created yet.
    #[error("is not there, expected the file of a running node: start the receiver first")]
    NoNode,
    /// Left over from a node that has ended.
    #[error("was left behind by a node that has ended, expected that of a running one")]
    Ended,
    /// Another file format.
    #[error(
        "received a file that begins with {received:?}, expected \"COAXLEDR\": this is not the memory of a \
         drive, another path has to be found for it"
    )]
    Magic {
        /// First bytes of the file.
        received: String,
    },
    /// Wrong length.
    #[error("received {received} bytes, expected {expected}: remove the file")]
    Size {
        /// Length of the file, or the one in its header.
        received: u64,
        /// The length of this version.
        expected: u64,
    },
    /// Wrong version.
    #[error(
        "received layout version {received}, expected {expected}: node and drive process must be of the same \
         version; remove the file if neither runs"
    )]
    Version {
        /// Version of the file.
        received: u64,
        /// Version of this program.
        expected: u64,
    },
    /// Invalid parameter of the drive.
    #[error("{0}")]
    Parameter(coaxle_axis::drive::WrongDriveParameter),
}
