//! Set values for a drive process on this machine, over shared memory.
//!
//! A node and the process map one file: the node writes a block of set values in each of its
//! cycles, the process a block of actual values at any time. Neither makes a system call for that,
//! and neither waits for the other. [`SharedMemoryDrive`] is the node's end, a
//! [`Drive`](coaxle_axis::drive::Drive); [`DriveProcess`] is the other one. `docs/DRIVE.md`
//! describes every byte, for processes in other languages.
//!
//! ```no_run
//! use coaxle_drive_memory::{DriveProcess, ProcessValues};
//!
//! let mut drive = DriveProcess::attach("/dev/shm/coaxle-carriage".as_ref())?;
//! loop {
//!     let Some(set) = drive.set_values() else { continue };
//!     // … hand them to the drive, ask it where it is …
//!     drive.answer(&ProcessValues::following(set.position, set.velocity).of(&set));
//!     # break;
//! }
//! # Ok::<(), coaxle_drive_memory::SharedMemoryError>(())
//! ```

mod block;
mod error;
mod file;
pub mod layout;
mod mapping;
mod node_end;
mod process_end;
#[cfg(test)]
mod tests;

pub use error::SharedMemoryError;
pub use node_end::{DriveIdentity, SharedMemoryDrive};
pub use process_end::{DriveProcess, ProcessValues, SetValues};
