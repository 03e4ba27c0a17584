//! A command of a program that is due.

use coaxle_cam::{ReservedPlate, TableId};
use coaxle_slave::Command;

/// A step's command, ready for the cycle.
#[expect(
    clippy::large_enum_variant,
    reason = "it is copied in a cycle, where nothing is allocated"
)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Due {
    /// A command to the slave.
    Slave(Command),
    /// Selects a plate that was reserved for it.
    SelectPlate { plate: ReservedPlate, replace: bool },
    /// Deletes a plate.
    DeletePlate { table: TableId },
}
