//! Data that an order carries to a cycle beside its fields, and back.

use coaxle_cam::{PlateReading, PreparedTable};
use coaxle_plate::CamError;

/// Memory of an order, allocated before it reaches a cycle and freed after it has left it.
#[derive(Debug, Default)]
pub enum OrderCargo {
    /// No cargo.
    #[default]
    Nothing,
    /// A plate to select, calculated. On the way back: the plate that was replaced or deleted, if any.
    Table(Option<Box<PreparedTable>>),
    /// Error of a plate to select that is invalid.
    Wrong(CamError),
    /// Space for a plate to read, and then that plate.
    Reading(Box<PlateReading>),
}
