//! Orders: commands as they travel, each with its addressee.

use std::sync::Arc;

use coaxle_cam::PreparedTable;
use coaxle_slave::Command;

use super::any_command::AnyCommand;
use super::cam::{OrderCargo, PlateCommand, PlateWork};
use super::far::FarCommand;
use super::name::{FarName, SlaveName};
use super::outcome::{CommandOutcome, NotTaken};

/// A command as it travels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order<A, C> {
    /// Slave of the node, or far node that it follows.
    pub addressee: A,
    /// Command to the slave, or about the far node.
    pub command: C,
    /// True for a dry run, which only reports the result.
    pub dry_run: bool,
}

/// Order to a slave.
pub type SlaveOrder = Order<SlaveName, Command>;

/// Order to a slave about its cam plates.
pub type CamOrder = Order<SlaveName, PlateCommand>;

/// Order to a node about a node that it follows.
pub type FarOrder = Order<FarName, FarCommand>;

/// Order to a node.
#[derive(Clone, Debug, PartialEq)]
pub enum CommandOrder {
    /// Order to one of its slaves.
    Slave(SlaveOrder),
    /// Order to one of its slaves about its cam plates.
    Plate(CamOrder),
    /// Order about a node that it follows.
    Far(FarOrder),
}

/// Addressee of an order within its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addressee {
    /// A slave of the node.
    Slave(SlaveName),
    /// A node that it follows.
    Far(FarName),
}

/// A command that its addressee cannot get.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WrongAddressee {
    /// A command about a far node, for a slave.
    #[error("received {command} for a slave, expected far beside a command about a far node")]
    Slave {
        /// Name of the command.
        command: &'static str,
    },
    /// A command to a slave, for a far node.
    #[error("received {command} for a far node, expected slave beside a command to a slave")]
    Far {
        /// Name of the command.
        command: &'static str,
    },
}

impl CommandOrder {
    /// Makes the order with a command to its addressee.
    ///
    /// # Errors
    /// [`WrongAddressee`] for a command about a far node to a slave, and the other way round.
    pub fn new(
        addressee: Addressee,
        command: AnyCommand,
        dry_run: bool,
    ) -> Result<Self, WrongAddressee> {
        let name = command.name();
        Ok(match (addressee, command) {
            (Addressee::Slave(addressee), AnyCommand::Slave(command)) => Self::Slave(Order {
                addressee,
                command,
                dry_run,
            }),
            (Addressee::Slave(addressee), AnyCommand::Plate(command)) => Self::Plate(Order {
                addressee,
                command,
                dry_run,
            }),
            (Addressee::Far(addressee), AnyCommand::Far(command)) => Self::Far(Order {
                addressee,
                command,
                dry_run,
            }),
            (Addressee::Slave(_), AnyCommand::Far(_)) => {
                return Err(WrongAddressee::Slave { command: name });
            }
            (Addressee::Far(_), AnyCommand::Slave(_) | AnyCommand::Plate(_)) => {
                return Err(WrongAddressee::Far { command: name });
            }
        })
    }

    /// Returns its addressee and its command.
    #[must_use]
    pub fn into_parts(self) -> (Addressee, AnyCommand) {
        match self {
            Self::Slave(order) => (
                Addressee::Slave(order.addressee),
                AnyCommand::Slave(order.command),
            ),
            Self::Plate(order) => (
                Addressee::Slave(order.addressee),
                AnyCommand::Plate(order.command),
            ),
            Self::Far(order) => (
                Addressee::Far(order.addressee),
                AnyCommand::Far(order.command),
            ),
        }
    }

    /// True for a dry run.
    #[must_use]
    pub const fn is_dry_run(&self) -> bool {
        match self {
            Self::Slave(order) => order.dry_run,
            Self::Plate(order) => order.dry_run,
            Self::Far(order) => order.dry_run,
        }
    }

    /// Returns the slave or far node that the order is for.
    #[must_use]
    pub fn addressee(&self) -> &str {
        match self {
            Self::Slave(order) => order.addressee.as_str(),
            Self::Plate(order) => order.addressee.as_str(),
            Self::Far(order) => order.addressee.as_str(),
        }
    }

    /// Returns the name of the command: its block, or its name on the wire.
    #[must_use]
    pub const fn command_name(&self) -> &'static str {
        match self {
            Self::Slave(order) => order.command.name(),
            Self::Plate(order) => order.command.name(),
            Self::Far(order) => order.command.name(),
        }
    }

    /// Returns the outcome at a node that has no slaves or no far nodes.
    #[must_use]
    pub const fn without_addressee(&self) -> CommandOutcome {
        CommandOutcome::NotTaken(match self {
            Self::Slave(_) | Self::Plate(_) => NotTaken::NoSlaves,
            Self::Far(_) => NotTaken::NoFarNodes,
        })
    }

    /// Makes the cargo of the order. Allocates, and calculates a plate that comes with it.
    #[must_use]
    pub fn cargo(&self) -> OrderCargo {
        let Self::Plate(order) = self else {
            return OrderCargo::Nothing;
        };
        match (order.command.row().traits, &order.command) {
            (_, PlateCommand::CamTableSelect { plate, .. }) => {
                let source = plate.source();
                let prepared = source
                    .check_size()
                    .and_then(|()| PreparedTable::new(Arc::clone(source)));
                prepared.map_or_else(OrderCargo::Wrong, |table| {
                    OrderCargo::Table(Some(Box::new(table)))
                })
            }
            (PlateWork::Changes, _) => OrderCargo::Table(None),
            (PlateWork::ReadsPlate, _) => OrderCargo::Reading(Box::default()),
            (PlateWork::ReadsCoupling, _) => OrderCargo::Nothing,
        }
    }
}

impl From<SlaveOrder> for CommandOrder {
    fn from(order: SlaveOrder) -> Self {
        Self::Slave(order)
    }
}

impl From<CamOrder> for CommandOrder {
    fn from(order: CamOrder) -> Self {
        Self::Plate(order)
    }
}

impl From<FarOrder> for CommandOrder {
    fn from(order: FarOrder) -> Self {
        Self::Far(order)
    }
}
