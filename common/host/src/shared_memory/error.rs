//! What is wrong with a file that shall be shared.

use std::path::PathBuf;

/// Why a file cannot be shared with a drive process.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct SharedMemoryError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub reason: Reason,
}

/// What is wrong with it.
#[derive(Debug, thiserror::Error)]
pub enum Reason {
    /// The system refuses it.
    #[error("cannot be {what}: {source}")]
    System {
        /// What was tried.
        what: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is no file.
    #[error("received {received}, expected a regular file or none")]
    NoFile {
        /// What it is.
        received: &'static str,
    },
    /// Others may write to it.
    #[error(
        "received mode {received:o}, expected 660 or less, nothing for others: remove the file"
    )]
    Mode {
        /// Its mode.
        received: u32,
    },
    /// A node has it.
    #[error(
        "is used by another node (process {pid}), expected a file of its own for each slave; if that node \
         hangs, end it first"
    )]
    UsedByNode {
        /// Its process.
        pid: u64,
    },
    /// A drive process has it.
    #[error("another drive process is attached (process {pid}), expected one at a time")]
    UsedByProcess {
        /// Its process.
        pid: u64,
    },
    /// It is not there, or not yet.
    #[error("is not there, expected the file of a running node: start the receiver first")]
    NoNode,
    /// The node that made it has ended.
    #[error("was left behind by a node that has ended, expected that of a running one")]
    Ended,
    /// It is something else.
    #[error(
        "received a file that begins with {received:?}, expected \"COAXLEDR\": this is not the memory of a \
         drive, another path has to be found for it"
    )]
    Magic {
        /// Its first bytes.
        received: String,
    },
    /// It has another length.
    #[error("received {received} bytes, expected {expected}: remove the file")]
    Size {
        /// Its length, or what it says of it.
        received: u64,
        /// The length of this version.
        expected: u64,
    },
    /// It is of another version.
    #[error(
        "received layout version {received}, expected {expected}: node and drive process must be of the same \
         version; remove the file if neither runs"
    )]
    Version {
        /// Its version.
        received: u64,
        /// The one of this program.
        expected: u64,
    },
    /// A parameter of the drive.
    #[error("{0}")]
    Parameter(coaxle_axis::drive::WrongDriveParameter),
}
