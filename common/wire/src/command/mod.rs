//! Commands to the slaves of a node, and about the nodes that it follows, from anywhere in the network:
//! `docs/WIRE.md` describes them.
//!
//! An order arrives as JSON, so that any tool can send it, and is decoded before it gets near a cycle. A
//! [`CommandOrder`] is plain data of fixed size except for a cam plate, which it shares, and so is the
//! [`CommandOutcome`] of the node. Memory for it is allocated in its [`OrderCargo`]. The
//! [`CommandAnswer`] is the response.

mod answer;
mod cam;
mod command_name;
mod far;
mod name;
mod outcome;
mod saw;

use coaxle_slave::Command;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use crate::one_line::one_line;
use command_name::CommandName;

pub use answer::{CommandAnswer, CommandVerdict};
pub use cam::{
    CamCommand, CamFigures, CamOrder, CharacteristicFigures, MAX_POINTS_READ, MAX_VALUES_READ,
    MasterFigures, OrderCargo, PlateOrder, SelectedValues,
};
pub use far::{FarCommand, FarOrder, FarRefusal, FarView, ParameterPart};
pub use name::{FarName, InvalidName, SlaveName};
pub use outcome::{CommandOutcome, MAX_KNOWN, NotTaken, SlaveView};
pub use saw::{NamedValue, SawAttempt, SawFigures, SawRefused, SawView, ViolatedCheck};

/// Version of orders and responses that this code writes, and the only one it reads.
pub const COMMAND_VERSION: u32 = 1;

/// Greatest length of an order without a plate, in bytes of JSON.
pub const MAX_ORDER_BYTES: usize = 4096;

/// Greatest length of an order with a plate, in bytes of JSON: some ten thousand points.
pub const MAX_PLATE_ORDER_BYTES: usize = 1 << 20;

/// Order to a node.
#[derive(Clone, Debug, PartialEq)]
pub enum CommandOrder {
    /// Order to one of its slaves.
    Slave(SlaveOrder),
    /// Order to one of its slaves about its cam plates.
    Cam(CamOrder),
    /// Order about a node that it follows.
    Far(FarOrder),
}

/// Order to a slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveOrder {
    /// Slave of the node.
    pub slave: SlaveName,
    /// Command to the slave.
    pub command: Command,
    /// True for a dry run, which only reports the result.
    pub dry_run: bool,
}

impl CommandOrder {
    /// Reads an order.
    ///
    /// # Errors
    /// [`InvalidOrder`]: too long, then another version, then a field that is wrong.
    pub fn from_json(bytes: &[u8]) -> Result<Self, InvalidOrder> {
        let received = bytes.len();
        if received > MAX_PLATE_ORDER_BYTES {
            return Err(InvalidOrder::TooLong { received });
        }
        if received > MAX_ORDER_BYTES && !brings_plate(bytes) {
            return Err(InvalidOrder::TooLong { received });
        }
        let version = read::<Versioned>(bytes)?.version;
        if version != COMMAND_VERSION {
            return Err(InvalidOrder::WrongVersion { received: version });
        }
        let Addressed {
            slave,
            far,
            command,
        } = read(bytes)?;
        match far {
            None if command.is_one_of(&CamCommand::NAMES) => {
                read::<CamOrderOnWire>(bytes).map(|order| Self::Cam(order.into()))
            }
            None => read::<SlaveOrderOnWire>(bytes).map(|order| Self::Slave(order.into())),
            Some(_) if slave.is_some() => Err(InvalidOrder::TwoAddressees),
            Some(_) => read::<FarOrderOnWire>(bytes).map(|order| Self::Far(order.into())),
        }
    }

    /// Writes the order. The reader refuses numbers that are not finite.
    #[must_use]
    pub fn to_json(&self) -> String {
        match self {
            Self::Slave(order) => serde_json::to_string(&SlaveOrderOnWire {
                version: COMMAND_VERSION,
                slave: order.slave,
                command: order.command,
                dry_run: order.dry_run,
            }),
            Self::Cam(order) => serde_json::to_string(&CamOrderOnWire {
                version: COMMAND_VERSION,
                slave: order.slave,
                command: order.command.clone(),
                dry_run: order.dry_run,
            }),
            Self::Far(order) => serde_json::to_string(&FarOrderOnWire {
                version: COMMAND_VERSION,
                far: order.far,
                command: order.command,
                dry_run: order.dry_run,
            }),
        }
        .expect("all keys of an order are texts")
    }

    /// True for a dry run.
    #[must_use]
    pub const fn is_dry_run(&self) -> bool {
        match self {
            Self::Slave(order) => order.dry_run,
            Self::Cam(order) => order.dry_run,
            Self::Far(order) => order.dry_run,
        }
    }

    /// Returns the slave or far node that the order is for.
    #[must_use]
    pub fn addressee(&self) -> &str {
        match self {
            Self::Slave(order) => order.slave.as_str(),
            Self::Cam(order) => order.slave.as_str(),
            Self::Far(order) => order.far.as_str(),
        }
    }

    /// Returns the name of the command: its block, or its name on the wire.
    #[must_use]
    pub fn command_name(&self) -> &'static str {
        match self {
            Self::Slave(order) => order.command.name(),
            Self::Cam(order) => order.command.name(),
            Self::Far(order) => order.command.name(),
        }
    }

    /// Returns the outcome at a node that has no slaves or no far nodes.
    #[must_use]
    pub const fn without_addressee(&self) -> CommandOutcome {
        CommandOutcome::NotTaken(match self {
            Self::Slave(_) | Self::Cam(_) => NotTaken::NoSlaves,
            Self::Far(_) => NotTaken::NoFarNodes,
        })
    }
}

impl From<SlaveOrder> for CommandOrder {
    fn from(order: SlaveOrder) -> Self {
        Self::Slave(order)
    }
}

impl From<CamOrder> for CommandOrder {
    fn from(order: CamOrder) -> Self {
        Self::Cam(order)
    }
}

impl From<FarOrder> for CommandOrder {
    fn from(order: FarOrder) -> Self {
        Self::Far(order)
    }
}

/// Error of an order that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidOrder {
    /// The order has too many bytes.
    #[error(
        "received an order of {received} bytes, expected at most {MAX_ORDER_BYTES}, or {MAX_PLATE_ORDER_BYTES} with a plate"
    )]
    TooLong {
        /// Number of bytes received.
        received: usize,
    },
    /// The order is sent to more than one node, or by an operator without a name.
    #[error(
        "key: received {received:?}, expected that of one node, and of one operator if any, without wildcards"
    )]
    AmbiguousKey {
        /// Key expression received.
        received: String,
    },
    /// The order is of another version.
    #[error("version: received {received}, expected {COMMAND_VERSION}")]
    WrongVersion {
        /// Version received.
        received: u32,
    },
    /// The order names both a slave and a far node.
    #[error("far: received one beside slave, expected either of them")]
    TwoAddressees,
    /// The order is no JSON, or a field is missing, unknown or wrong.
    #[error("{field}: {reason}")]
    Malformed {
        /// Name of the field; a dot for the order as a whole.
        field: String,
        /// Reason for the refusal of the field.
        reason: String,
    },
}

/// Field that all versions have in common.
#[derive(Deserialize)]
struct Versioned {
    version: u32,
}

/// Addressee and name of the command.
#[derive(Deserialize)]
struct Addressed {
    slave: Option<IgnoredAny>,
    far: Option<IgnoredAny>,
    #[serde(default)]
    command: CommandName,
}

/// True if the order may bring a plate, and may therefore be longer than others.
fn brings_plate(bytes: &[u8]) -> bool {
    read::<Addressed>(bytes).is_ok_and(|order| order.command.is_one_of(&["cam-table-select"]))
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct SlaveOrderOnWire {
    version: u32,
    slave: SlaveName,
    command: Command,
    #[serde(default)]
    dry_run: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct CamOrderOnWire {
    version: u32,
    slave: SlaveName,
    command: CamCommand,
    #[serde(default)]
    dry_run: bool,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct FarOrderOnWire {
    version: u32,
    far: FarName,
    command: FarCommand,
    #[serde(default)]
    dry_run: bool,
}

impl From<SlaveOrderOnWire> for SlaveOrder {
    fn from(order: SlaveOrderOnWire) -> Self {
        Self {
            slave: order.slave,
            command: order.command,
            dry_run: order.dry_run,
        }
    }
}

impl From<CamOrderOnWire> for CamOrder {
    fn from(order: CamOrderOnWire) -> Self {
        Self {
            slave: order.slave,
            command: order.command,
            dry_run: order.dry_run,
        }
    }
}

impl From<FarOrderOnWire> for FarOrder {
    fn from(order: FarOrderOnWire) -> Self {
        Self {
            far: order.far,
            command: order.command,
            dry_run: order.dry_run,
        }
    }
}

fn read<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, InvalidOrder> {
    let malformed = |field: String, reason: &serde_json::Error| InvalidOrder::Malformed {
        field: one_line(&field),
        reason: one_line(&reason.to_string()),
    };
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut json)
        .map_err(|error| malformed(error.path().to_string(), error.inner()))?;
    json.end()
        .map_err(|error| malformed(".".to_owned(), &error))?;
    Ok(value)
}
