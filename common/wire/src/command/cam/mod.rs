//! Orders about the cam plates of a slave: the blocks of TF5050 beside the commands to its coupling.
//!
//! A plate is calculated where orders are decoded, and handed to the cycle as a whole ([`OrderCargo`]).
//! Values read of a plate are calculated where responses are encoded.

mod cargo;
mod figures;
mod plate;
mod values;

use coaxle_cam::TableId;
use coaxle_slave::commands;
use serde::{Deserialize, Serialize};

pub use cargo::OrderCargo;
pub(super) use figures::read;
pub use figures::{
    CamFigures, CharacteristicFigures, MAX_POINTS_READ, MAX_VALUES_READ, MasterFigures,
};
pub use plate::PlateOrder;
pub use values::SelectedValues;

commands! {
    /// A block of TF5050 that is about a plate and not about a motion.
    ///
    /// Masters are in x and slaves in u of the plate, raw, unless axes are named.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    #[cfg_attr(
        feature = "schema",
        derive(schemars::JsonSchema),
        schemars(rename = "PlateCommand")
    )]
    #[serde(
        rename_all = "kebab-case",
        rename_all_fields = "kebab-case",
        deny_unknown_fields
    )]
    pub enum PlateCommand<P = PlateOrder>, each PlateWork = PlateWork::ReadsPlate;

    /// `MC_CamTableSelect`: loads a plate, or replaces one.
    "MC_CamTableSelect" CamTableSelect {
        /// Number of the plate, 1 to 255; by default the number in the plate.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        table: Option<TableId>,
        /// True if it may replace a plate of that number.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        replace: bool,
        /// Plate, with the fields of a cam file.
        plate: P,
    } => PlateWork::Changes,
    /// Deletes a plate. TF5050 has no block for it: ADS deletes tables there.
    "cam-table-delete" CamTableDelete {
        /// Number of the plate.
        table: TableId,
    } => PlateWork::Changes,
    /// `MC_ReadMotionFunction`: points in force.
    "MC_ReadMotionFunction" ReadMotionFunction {
        /// Number of the plate.
        table: TableId,
        /// First point.
        #[serde(default = "first_point")]
        point: u32,
        /// Number of points; 0 for all that follow, as far as a response holds them.
        #[serde(default)]
        number: usize,
    },
    /// `MC_ReadMotionFunctionPoint`: one point in force.
    "MC_ReadMotionFunctionPoint" ReadMotionFunctionPoint {
        /// Number of the plate.
        table: TableId,
        /// Number of the point.
        point: u32,
    },
    /// `MC_ReadMotionFunctionValues`: the plate as a table of values.
    "MC_ReadMotionFunctionValues" ReadMotionFunctionValues {
        /// Number of the plate.
        table: TableId,
        /// First master position, x.
        from: f64,
        /// Last master position, x.
        to: f64,
        /// Increment from row to row, x, with the sign of the direction.
        increment: f64,
        /// Values of the slave to read.
        #[serde(default)]
        values: SelectedValues,
    },
    /// `MC_ReadCamTableSlaveDynamics`: the slave's values at a master position and velocity.
    "MC_ReadCamTableSlaveDynamics" ReadCamTableSlaveDynamics {
        /// Number of the plate.
        table: TableId,
        /// Position of the master, x.
        master_position: f64,
        /// Velocity of the master, x/s: with 1 the results are the derivatives of the plate.
        #[serde(default = "one")]
        master_velocity: f64,
    },
    /// `MC_ReadCamTableCharacteristics`: the demands of the plate on the slave.
    "MC_ReadCamTableCharacteristics" ReadCamTableCharacteristics {
        /// Number of the plate.
        table: TableId,
        /// Velocity of the master, x/s.
        #[serde(default = "one")]
        master_velocity: f64,
    },
    /// `MC_ReadCamTableMasterPosition`: the master position for a position of the slave axis.
    "MC_ReadCamTableMasterPosition" ReadCamTableMasterPosition {
        /// Number of the plate.
        table: TableId,
        /// Position of the slave axis, u.
        slave_position: f64,
        /// Position of the master axis at which the search starts, x.
        #[serde(default)]
        master_start_position: f64,
        /// Offset of the master, x.
        #[serde(default)]
        master_offset: f64,
        /// Offset of the slave, u.
        #[serde(default)]
        slave_offset: f64,
        /// Scaling of the master.
        #[serde(default = "one")]
        master_scaling: f64,
        /// Scaling of the slave.
        #[serde(default = "one")]
        slave_scaling: f64,
        /// Masters no farther than this from the start count as on both sides of it, x.
        #[serde(default)]
        master_accuracy: f64,
    },
    /// `MC_CamInfo`, `MC_CamInfo_V2`: state of the coupling; after an error, its last state.
    #[doc(alias = "MC_CamInfo_V2")]
    "MC_CamInfo" CamInfo {
        /// Number of the plate; 0 if the slave has only one.
        #[serde(default)]
        table: TableId,
        /// Assumed position of the master axis, u; by default its actual position.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        master_position: Option<f64>,
    } => PlateWork::ReadsCoupling,
}

/// Work of a command on the cam plates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlateWork {
    /// Brings a plate or takes one away.
    Changes,
    /// Reads values of a plate, which are calculated outside of the cycle.
    ReadsPlate,
    /// Reads the state of the coupling.
    ReadsCoupling,
}

const fn first_point() -> u32 {
    1
}

const fn one() -> f64 {
    1.0
}

impl PlateCommand {
    /// Returns the plate that the command is about; 0 if none is named.
    #[must_use]
    pub fn table(&self) -> TableId {
        match self {
            Self::CamTableSelect { table, plate, .. } => {
                table.or(plate.table_id()).unwrap_or_default()
            }
            Self::CamTableDelete { table }
            | Self::ReadMotionFunction { table, .. }
            | Self::ReadMotionFunctionPoint { table, .. }
            | Self::ReadMotionFunctionValues { table, .. }
            | Self::ReadCamTableSlaveDynamics { table, .. }
            | Self::ReadCamTableCharacteristics { table, .. }
            | Self::ReadCamTableMasterPosition { table, .. }
            | Self::CamInfo { table, .. } => *table,
        }
    }
}
