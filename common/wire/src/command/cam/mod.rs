//! Orders about the cam plates of a slave: what TF5050 has beside commands to its coupling.
//!
//! A plate is calculated where orders are decoded, and handed to the cycle as a whole ([`OrderCargo`]). What is read of one
//! is calculated where answers are encoded.

mod cargo;
mod figures;
mod plate;
mod values;

use coaxle_cam::TableId;
use coaxle_plate::MasterQuery;
use serde::{Deserialize, Serialize};

use super::name::SlaveName;

pub use cargo::OrderCargo;
pub(super) use figures::read;
pub use figures::{
    CamFigures, CharacteristicFigures, MAX_POINTS_READ, MAX_VALUES_READ, MasterFigures,
};
pub use plate::PlateOrder;
pub use values::SelectedValues;

/// What a slave is told, or asked, about its cam plates.
#[derive(Clone, Debug, PartialEq)]
pub struct CamOrder {
    /// Which slave of the node.
    pub slave: SlaveName,
    /// What it shall do.
    pub command: CamCommand,
    /// Whether it shall only say what would come of it.
    pub dry_run: bool,
}

/// A block of TF5050 that is about a plate and not about a motion.
///
/// Masters are in x and slaves in u of the plate, raw, but where axes are said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    rename_all = "kebab-case",
    rename_all_fields = "kebab-case",
    deny_unknown_fields
)]
pub enum CamCommand {
    /// `MC_CamTableSelect`: loads a plate, or puts it in the place of another.
    #[doc(alias = "MC_CamTableSelect")]
    CamTableSelect {
        /// The number of the plate, 1 to 255; that in the plate, if it is left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        table: Option<TableId>,
        /// Whether it may take the place of one of that number.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        replace: bool,
        /// The plate, as a cam file has it.
        plate: PlateOrder,
    },
    /// Takes a plate out. TF5050 has no block for it: ADS deletes tables there.
    CamTableDelete {
        /// The plate.
        table: TableId,
    },
    /// `MC_ReadMotionFunction`: points as they are in force.
    #[doc(alias = "MC_ReadMotionFunction")]
    ReadMotionFunction {
        /// The plate.
        table: TableId,
        /// The first of the points.
        #[serde(default = "first_point")]
        point: u32,
        /// How many; all that follow for 0, as far as an answer holds them.
        #[serde(default)]
        number: usize,
    },
    /// `MC_ReadMotionFunctionPoint`: one point as it is in force.
    #[doc(alias = "MC_ReadMotionFunctionPoint")]
    ReadMotionFunctionPoint {
        /// The plate.
        table: TableId,
        /// The point.
        point: u32,
    },
    /// `MC_ReadMotionFunctionValues`: the plate as a table of values.
    #[doc(alias = "MC_ReadMotionFunctionValues")]
    ReadMotionFunctionValues {
        /// The plate.
        table: TableId,
        /// Where the master is first, x.
        from: f64,
        /// Where it is last, x.
        to: f64,
        /// How far it is from row to row, x; with the sign of the way.
        increment: f64,
        /// What of the slave is asked for.
        #[serde(default)]
        values: SelectedValues,
    },
    /// `MC_ReadCamTableSlaveDynamics`: the slave where the master is and as it moves.
    #[doc(alias = "MC_ReadCamTableSlaveDynamics")]
    ReadCamTableSlaveDynamics {
        /// The plate.
        table: TableId,
        /// Where the master is, x.
        master_position: f64,
        /// How fast it is, x/s: with 1 the answers are the derivatives of the plate.
        #[serde(default = "one")]
        master_velocity: f64,
    },
    /// `MC_ReadCamTableCharacteristics`: what the plate demands of the slave.
    #[doc(alias = "MC_ReadCamTableCharacteristics")]
    ReadCamTableCharacteristics {
        /// The plate.
        table: TableId,
        /// The velocity of the master, x/s.
        #[serde(default = "one")]
        master_velocity: f64,
    },
    /// `MC_ReadCamTableMasterPosition`: where the master is when the slave axis is somewhere.
    #[doc(alias = "MC_ReadCamTableMasterPosition")]
    ReadCamTableMasterPosition {
        /// The plate.
        table: TableId,
        /// Position of the slave axis, u.
        slave_position: f64,
        /// Position of the master axis to look from, x.
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
    /// `MC_CamInfo`, `MC_CamInfo_V2`: what the coupling is like; after an error what it was.
    #[doc(alias = "MC_CamInfo")]
    #[doc(alias = "MC_CamInfo_V2")]
    CamInfo {
        /// The plate; 0 if the slave has but one.
        #[serde(default)]
        table: TableId,
        /// Where the master axis is supposed to be, u; where it is, if it is left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        master_position: Option<f64>,
    },
}

const fn first_point() -> u32 {
    1
}

const fn one() -> f64 {
    1.0
}

impl CamCommand {
    /// The names of all on the wire.
    pub const NAMES: [&str; 9] = [
        "cam-table-select",
        "cam-table-delete",
        "read-motion-function",
        "read-motion-function-point",
        "read-motion-function-values",
        "read-cam-table-slave-dynamics",
        "read-cam-table-characteristics",
        "read-cam-table-master-position",
        "cam-info",
    ];

    /// The PLC's name of it.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::CamTableSelect { .. } => "MC_CamTableSelect",
            Self::CamTableDelete { .. } => "cam-table-delete",
            Self::ReadMotionFunction { .. } => "MC_ReadMotionFunction",
            Self::ReadMotionFunctionPoint { .. } => "MC_ReadMotionFunctionPoint",
            Self::ReadMotionFunctionValues { .. } => "MC_ReadMotionFunctionValues",
            Self::ReadCamTableSlaveDynamics { .. } => "MC_ReadCamTableSlaveDynamics",
            Self::ReadCamTableCharacteristics { .. } => "MC_ReadCamTableCharacteristics",
            Self::ReadCamTableMasterPosition { .. } => "MC_ReadCamTableMasterPosition",
            Self::CamInfo { .. } => "MC_CamInfo",
        }
    }

    /// The plate it is about; 0 where none is named.
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

    /// What the library is asked for a master position; none of another command.
    const fn master_query(&self) -> Option<MasterQuery> {
        match *self {
            Self::ReadCamTableMasterPosition {
                slave_position,
                master_start_position,
                master_offset,
                slave_offset,
                master_scaling,
                slave_scaling,
                master_accuracy,
                ..
            } => Some(MasterQuery {
                slave_position,
                master_offset,
                slave_offset,
                master_scaling,
                slave_scaling,
                master_start: master_start_position,
                accuracy: master_accuracy,
            }),
            _ => None,
        }
    }
}
