//! Commands to the slaves of a node, and about the nodes that it follows, from anywhere in the network:
//! `docs/WIRE.md` describes them.
//!
//! Commands are rows of three tables: to slaves ([`Command`](coaxle_slave::Command)), about cam plates
//! ([`PlateCommand`]), about far nodes ([`FarCommand`]). [`ListedCommand::all`] walks them, and
//! [`AnyCommand`] is read by its name wherever a command is written.
//!
//! An order arrives as JSON, so that any tool can send it, and is decoded before it gets near a cycle. A
//! [`CommandOrder`] is plain data of fixed size except for a cam plate, which it shares, and so is the
//! [`CommandOutcome`] of the node. Memory for it is allocated in its [`OrderCargo`]. The
//! [`CommandAnswer`] is the response.

mod answer;
mod any_command;
mod by_name;
mod cam;
mod command_name;
mod far;
mod name;
mod order;
mod outcome;
mod saw;

use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};

use crate::document::from_json;
use crate::one_line::one_line;
use command_name::CommandName;

pub use answer::{CommandAnswer, CommandVerdict};
pub use any_command::{AnyCommand, CommandFamily, ListedCommand};
pub use cam::{
    CamFigures, CharacteristicFigures, MAX_POINTS_READ, MAX_VALUES_READ, MasterFigures, OrderCargo,
    PlateCommand, PlateOrder, PlateWork, SelectedValues,
};
pub use far::{FarCommand, FarRefusal, FarView, ParameterPart};
pub use name::{FarName, InvalidName, SlaveName};
pub use order::{Addressee, CamOrder, CommandOrder, FarOrder, Order, SlaveOrder, WrongAddressee};
pub use outcome::{CommandOutcome, MAX_KNOWN, NotTaken, SlaveView};
pub use saw::{NamedValue, SawAttempt, SawFigures, SawRefused, SawView, ViolatedCheck};

/// Version of orders and responses that this code writes, and the only one it reads.
pub const COMMAND_VERSION: u32 = 1;

/// Greatest length of an order without a plate, in bytes of JSON.
pub const MAX_ORDER_BYTES: usize = 4096;

/// Greatest length of an order with a plate, in bytes of JSON: some ten thousand points.
pub const MAX_PLATE_ORDER_BYTES: usize = 1 << 20;

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
        if slave.is_some() && far.is_some() {
            return Err(InvalidOrder::TwoAddressees);
        }
        // The addressee decides which commands an error lists, wherever it stands in the order.
        let is_for_addressee = |family: CommandFamily| family.is_about_far_node() == far.is_some();
        if let Some(name) = command.as_deref() {
            by_name::find(name, is_for_addressee)
                .map_err(|reason| malformed("command", &reason))?;
        }
        read::<OrderOnWire>(bytes)?.try_into()
    }

    /// Writes the order. The reader refuses numbers that are not finite.
    #[must_use]
    pub fn to_json(&self) -> String {
        let order = OrderOnWire::from(self.clone());
        serde_json::to_string(&order).expect("all keys of an order are texts")
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
    read::<Addressed>(bytes).is_ok_and(|order| order.command.as_deref() == Some("cam-table-select"))
}

/// An order as JSON.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct OrderOnWire {
    version: u32,
    #[serde(
        default,
        deserialize_with = "given",
        skip_serializing_if = "Option::is_none"
    )]
    slave: Option<SlaveName>,
    #[serde(
        default,
        deserialize_with = "given",
        skip_serializing_if = "Option::is_none"
    )]
    far: Option<FarName>,
    command: AnyCommand,
    #[serde(default)]
    dry_run: bool,
}

/// Reads a field that may be absent, but not null.
fn given<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

impl TryFrom<OrderOnWire> for CommandOrder {
    type Error = InvalidOrder;

    fn try_from(order: OrderOnWire) -> Result<Self, InvalidOrder> {
        let addressee = match (order.slave, order.far) {
            (Some(_), Some(_)) => return Err(InvalidOrder::TwoAddressees),
            (Some(slave), None) => Addressee::Slave(slave),
            (None, Some(far)) => Addressee::Far(far),
            (None, None) => return Err(malformed(".", "missing field `slave`")),
        };
        let order = Self::new(addressee, order.command, order.dry_run);
        order.map_err(|wrong| malformed("command", &wrong.to_string()))
    }
}

impl From<CommandOrder> for OrderOnWire {
    fn from(order: CommandOrder) -> Self {
        let dry_run = order.is_dry_run();
        let (addressee, command) = order.into_parts();
        let (slave, far) = match addressee {
            Addressee::Slave(slave) => (Some(slave), None),
            Addressee::Far(far) => (None, Some(far)),
        };
        Self {
            version: COMMAND_VERSION,
            slave,
            far,
            command,
            dry_run,
        }
    }
}

fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, InvalidOrder> {
    from_json(bytes).map_err(|misread| malformed(&misread.field(), misread.reason()))
}

fn malformed(field: &str, reason: &str) -> InvalidOrder {
    InvalidOrder::Malformed {
        field: one_line(field),
        reason: one_line(reason),
    }
}
