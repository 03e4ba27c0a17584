//! A command of any kind, and the list of all that there are.

use coaxle_slave::Command;
use serde::Serialize;

use super::cam::{PlateCommand, PlateOrder, PlateWork};
use super::far::FarCommand;

/// A command, identified by its name.
///
/// Scenarios, programs, the command line and the network read it in one way. `P` is the form that a
/// plate has there.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "AnyCommand")
)]
#[serde(untagged)]
pub enum AnyCommand<P = PlateOrder> {
    /// To a slave.
    Slave(Command),
    /// To a slave about its cam plates.
    Plate(PlateCommand<P>),
    /// About a far node.
    Far(FarCommand),
}

/// Kind of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandFamily {
    /// To a slave.
    Slave,
    /// To a slave about its cam plates, with the work that it means for them.
    Plate(PlateWork),
    /// About a far node.
    Far,
}

/// Entry in the list of all commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListedCommand {
    /// Kind of the command.
    pub family: CommandFamily,
    /// Key of the command in files and messages.
    pub key: &'static str,
    /// PLC name of the command; its key if there is no such block.
    pub name: &'static str,
}

impl CommandFamily {
    /// True for a command about a far node; false for one to a slave.
    #[must_use]
    pub const fn is_about_far_node(self) -> bool {
        matches!(self, Self::Far)
    }
}

impl ListedCommand {
    /// Lists all commands: to slaves, about plates, about far nodes.
    pub fn all() -> impl Iterator<Item = Self> {
        let slave = Command::ROWS.iter().map(|row| Self {
            family: CommandFamily::Slave,
            key: row.key,
            name: row.name,
        });
        let plate = <PlateCommand>::ROWS.iter().map(|row| Self {
            family: CommandFamily::Plate(row.traits),
            key: row.key,
            name: row.name,
        });
        let far = FarCommand::ROWS.iter().map(|row| Self {
            family: CommandFamily::Far,
            key: row.key,
            name: row.name,
        });
        slave.chain(plate).chain(far)
    }

    /// Finds the command with a key.
    #[must_use]
    pub fn of(key: &str) -> Option<Self> {
        Self::all().find(|command| command.key == key)
    }
}

impl<P> AnyCommand<P> {
    /// Returns the PLC name of the command; its key if there is no such block.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Slave(command) => command.name(),
            Self::Plate(command) => command.name(),
            Self::Far(command) => command.name(),
        }
    }
}
