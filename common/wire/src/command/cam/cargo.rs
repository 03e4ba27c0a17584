//! What an order brings to a cycle beside its words, and takes back.

use std::sync::Arc;

use coaxle_cam::{PlateReading, PreparedTable};
use coaxle_plate::CamError;

use super::CamCommand;
use crate::command::CommandOrder;

/// What has to be allocated for an order is allocated before it comes to a cycle, and freed after it has left it.
#[derive(Debug, Default)]
pub enum OrderCargo {
    /// Nothing.
    #[default]
    Nothing,
    /// A plate to select, calculated; afterwards the one that was replaced or taken out, if any.
    Table(Option<Box<PreparedTable>>),
    /// The plate to select is none.
    Wrong(CamError),
    /// Room for a plate that is to be read, and then that plate.
    Reading(Box<PlateReading>),
}

impl CommandOrder {
    /// What the order brings. This allocates, and calculates a plate that comes with it.
    #[must_use]
    pub fn cargo(&self) -> OrderCargo {
        let Self::Cam(order) = self else {
            return OrderCargo::Nothing;
        };
        match &order.command {
            CamCommand::CamTableSelect { plate, .. } => {
                let source = plate.source();
                let prepared = source
                    .check_size()
                    .and_then(|()| PreparedTable::new(Arc::clone(source)));
                prepared.map_or_else(OrderCargo::Wrong, |table| {
                    OrderCargo::Table(Some(Box::new(table)))
                })
            }
            CamCommand::CamTableDelete { .. } => OrderCargo::Table(None),
            CamCommand::CamInfo { .. } => OrderCargo::Nothing,
            CamCommand::ReadMotionFunction { .. }
            | CamCommand::ReadMotionFunctionPoint { .. }
            | CamCommand::ReadMotionFunctionValues { .. }
            | CamCommand::ReadCamTableSlaveDynamics { .. }
            | CamCommand::ReadCamTableCharacteristics { .. }
            | CamCommand::ReadCamTableMasterPosition { .. } => OrderCargo::Reading(Box::default()),
        }
    }
}
