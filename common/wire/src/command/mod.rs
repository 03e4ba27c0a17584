//! Commands to the slaves of a node, from anywhere in the network: `docs/WIRE.md` describes them.
//!
//! An order arrives as JSON, so that any tool can send it, and is decoded before it gets near a
//! cycle: a [`CommandOrder`] is plain data of fixed size, and so is the [`CommandOutcome`] that the
//! node gives for it. The [`CommandAnswer`] is what the asker reads.

mod answer;
mod name;
mod outcome;
mod saw;

use coaxle_slave::Command;
use serde::{Deserialize, Serialize};

pub use answer::{CommandAnswer, CommandVerdict};
pub use name::{InvalidSlaveName, SlaveName};
pub use outcome::{CommandOutcome, MAX_KNOWN_SLAVES, NotTaken, SlaveView};
pub use saw::{NamedValue, SawFigures, SawRefused, SawView, ViolatedCheck};

/// The version of orders and answers that this code writes, and the only one it reads.
pub const COMMAND_VERSION: u32 = 1;

/// Longest order, in bytes of JSON.
pub const MAX_ORDER_BYTES: usize = 4096;

/// What a slave is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandOrder {
    /// Which slave of the node.
    pub slave: SlaveName,
    /// What it shall do.
    pub command: Command,
    /// Whether it shall only say what would come of it.
    pub dry_run: bool,
}

impl CommandOrder {
    /// Reads an order.
    ///
    /// # Errors
    /// [`BadOrder`]: too long, then another version, then a field that is wrong.
    pub fn from_json(bytes: &[u8]) -> Result<Self, BadOrder> {
        if bytes.len() > MAX_ORDER_BYTES {
            let received = bytes.len();
            return Err(BadOrder::TooLong { received });
        }
        let version = read::<Versioned>(bytes)?.version;
        if version != COMMAND_VERSION {
            return Err(BadOrder::WrongVersion { received: version });
        }
        let order = read::<OrderOnWire>(bytes)?;
        Ok(Self {
            slave: order.slave,
            command: order.command,
            dry_run: order.dry_run,
        })
    }

    /// Writes the order. Whoever reads it refuses numbers that are not finite.
    #[must_use]
    pub fn to_json(&self) -> String {
        let order = OrderOnWire {
            version: COMMAND_VERSION,
            slave: self.slave,
            command: self.command,
            dry_run: self.dry_run,
        };
        serde_json::to_string(&order).expect("all keys of an order are texts")
    }
}

/// An order that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadOrder {
    /// It has too many bytes.
    #[error("received an order of {received} bytes, expected at most {MAX_ORDER_BYTES}")]
    TooLong {
        /// How many.
        received: usize,
    },
    /// It is sent to more than one node.
    #[error("key: received {received:?}, expected that of one node, without wildcards")]
    ManyNodes {
        /// The key expression.
        received: String,
    },
    /// It is of another version.
    #[error("version: received {received}, expected {COMMAND_VERSION}")]
    WrongVersion {
        /// Which.
        received: u32,
    },
    /// It is no JSON, or a field is missing, unknown or wrong.
    #[error("{field}: {reason}")]
    Malformed {
        /// The field; a dot for the order as a whole.
        field: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// What all versions have in common.
#[derive(Deserialize)]
struct Versioned {
    version: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct OrderOnWire {
    version: u32,
    slave: SlaveName,
    command: Command,
    #[serde(default)]
    dry_run: bool,
}

fn read<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, BadOrder> {
    let malformed = |field: String, reason: &serde_json::Error| BadOrder::Malformed {
        field,
        reason: reason.to_string(),
    };
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut json)
        .map_err(|error| malformed(error.path().to_string(), error.inner()))?;
    json.end()
        .map_err(|error| malformed(".".to_owned(), &error))?;
    Ok(value)
}
