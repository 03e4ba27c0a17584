//! Node, run and cycle of a message, and the list that follows them.

use serde::{Deserialize, Serialize};

use crate::frame::{FORMAT_VERSION, read};
use crate::rejection::Rejection;

/// Node of a message, its run and its cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunCycle {
    /// Sender: the CRC-32 of its node name.
    pub sender: u32,
    /// Run of the sender.
    pub epoch: u64,
    /// The sender's cycle count when it made the message: that of a later cycle replaces it.
    pub count: u64,
}

/// Beginning of a message with a list.
#[derive(Serialize, Deserialize)]
pub(crate) struct ListPrefix {
    version: u8,
    sender: u32,
    epoch: u64,
    count: u64,
    entries: u32,
}

impl ListPrefix {
    pub(crate) fn of(header: &RunCycle, entries: usize) -> Self {
        Self {
            version: FORMAT_VERSION,
            sender: header.sender,
            epoch: header.epoch,
            count: header.count,
            entries: entries as u32,
        }
    }

    /// Reads the beginning of a message: its node, its number of entries, and the bytes that begin with them.
    pub(crate) fn read(content: &[u8], most: usize) -> Result<(RunCycle, u32, &[u8]), Rejection> {
        let (prefix, rest) = read::<Self>(content)?;
        if prefix.entries as usize > most {
            return Err(Rejection::Malformed);
        }
        let header = RunCycle {
            sender: prefix.sender,
            epoch: prefix.epoch,
            count: prefix.count,
        };
        Ok((header, prefix.entries, rest))
    }
}
