//! Data that an order carries to a cycle beside its fields, and back.

use std::sync::Arc;

use coaxle_cam::{PlateReading, PreparedTable};
use coaxle_plate::CamError;

use super::{PlateCommand, PlateWork};
use crate::command::CommandOrder;

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

impl CommandOrder {
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
