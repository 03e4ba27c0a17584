//! A command of a program that is due.

use coaxle_cam::{ReservedPlate, TableId};
use coaxle_slave::Command;

/// What a step does, ready for the cycle.
#[expect(
    clippy::large_enum_variant,
    reason = "it is copied in a cycle, where nothing is allocated"
)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Due {
    /// A command to the slave.
    Slave(Command),
    /// A plate that was reserved for it is selected.
    SelectPlate { plate: ReservedPlate, replace: bool },
    /// A plate is taken out.
    DeletePlate { table: TableId },
}
