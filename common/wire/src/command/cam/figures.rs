//! Cam plate values in the response to an order.

use coaxle_cam::{CamInfo, CouplingError};
use coaxle_curve::law::MinMax;
use coaxle_curve::profile::Kinematics;
use coaxle_plate::{
    CamError, Characteristics, Course, MasterPosition, MasterQuery, Plate, TableType, VelocityStep,
    WrittenPoint,
};
use serde::{Deserialize, Serialize};

use super::{OrderCargo, PlateCommand, SelectedValues};
use crate::command::saw::NamedValue;

/// Greatest number of points in a response. More are read by several orders.
pub const MAX_POINTS_READ: usize = 4096;

/// Greatest number of rows of values in a response. More are read by several orders.
pub const MAX_VALUES_READ: usize = 4096;

/// Values that were read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case")]
pub enum CamFigures {
    /// Points in force.
    Points {
        /// Number of points of the plate.
        number_of_rows: usize,
        /// Points read, in their order.
        points: Vec<WrittenPoint>,
    },
    /// A table of values.
    Values {
        /// Columns: the master, x, and of the slave the position, u, and its derivatives.
        columns: Vec<String>,
        /// The rows.
        rows: Vec<Vec<f64>>,
    },
    /// Slave values at a master position.
    SlaveDynamics {
        /// Position of the slave, u.
        position: f64,
        /// Velocity of the slave, u/s.
        velocity: f64,
        /// Acceleration of the slave, u/s².
        acceleration: f64,
    },
    /// Demands of the plate on the slave.
    Characteristics(Box<CharacteristicFigures>),
    /// Nearest master positions for a slave position: none where no such master position exists.
    MasterPosition {
        /// Position below the start.
        low: Option<MasterFigures>,
        /// Position above the start.
        high: Option<MasterFigures>,
    },
    /// State of the coupling.
    Info(Box<CamInfo>),
}

/// `MC_TableCharacValues`, TF5050 chapter 8.11.
#[doc(alias = "MC_TableCharacValues")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct CharacteristicFigures {
    /// The 31 values in their order, under their names there.
    pub values: Vec<NamedValue>,
    /// Number of the plate.
    pub table: u32,
    /// Number of its points or rows.
    pub number_of_rows: usize,
    /// Number of its columns.
    pub number_of_columns: usize,
    /// Type of its content.
    pub table_type: TableType,
    /// Course: linear or cyclic.
    pub course: Course,
    /// Lift: gain of the slave per cycle, u.
    pub lift: f64,
    /// Number of places at which the velocity of the slave steps.
    pub velocity_steps: usize,
    /// Largest of these steps, at that velocity of the master.
    pub largest_velocity_step: Option<StepFigures>,
}

/// Step of the velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct StepFigures {
    /// Position of the master, x.
    pub master: f64,
    /// Velocity before the step, u/s.
    pub before: f64,
    /// Velocity after the step, u/s.
    pub after: f64,
}

/// `CamMasterData`, TF5050 chapter 8.17.
#[doc(alias = "CamMasterData")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MasterFigures {
    /// Position of the master axis, x.
    pub master_axis_position: f64,
    /// Position of the master in the base cycle of the plate, x.
    pub master_cam_position: f64,
    /// Slave offset with which a coupling there leaves the slave in its position, u.
    pub slave_offset: f64,
}

/// Executes a reading command on the plate that came with it; none for another command or without a
/// plate.
pub(in crate::command) fn read(
    command: &PlateCommand,
    cargo: &OrderCargo,
) -> Result<Option<CamFigures>, CouplingError> {
    let OrderCargo::Reading(reading) = cargo else {
        return Ok(None);
    };
    let Some(source) = reading.source() else {
        return Ok(None);
    };
    let plate = source.plate()?;
    let v = |position, velocity| Kinematics {
        position,
        velocity,
        acceleration: 0.0,
    };
    Ok(Some(match *command {
        PlateCommand::ReadMotionFunction { point, number, .. } => points(&plate, point, number)?,
        PlateCommand::ReadMotionFunctionPoint { point, .. } => points(&plate, point, 1)?,
        PlateCommand::ReadMotionFunctionValues {
            from,
            to,
            increment,
            values: selected,
            ..
        } => values(&plate, [from, to, increment], selected)?,
        PlateCommand::ReadCamTableSlaveDynamics {
            master_position,
            master_velocity,
            ..
        } => {
            finite("master position", master_position)?;
            finite("master velocity", master_velocity)?;
            let slave = plate.slave_dynamics(&v(master_position, master_velocity));
            CamFigures::SlaveDynamics {
                position: slave.position,
                velocity: slave.velocity,
                acceleration: slave.acceleration,
            }
        }
        PlateCommand::ReadCamTableCharacteristics {
            table,
            master_velocity,
        } => {
            let found = plate.characteristics(master_velocity)?;
            CamFigures::Characteristics(Box::new(CharacteristicFigures::of(table, &plate, &found)))
        }
        PlateCommand::ReadCamTableMasterPosition {
            table: _,
            slave_position,
            master_start_position,
            master_offset,
            slave_offset,
            master_scaling,
            slave_scaling,
            master_accuracy,
        } => {
            let [low, high] = plate.master_positions(&MasterQuery {
                slave_position,
                master_offset,
                slave_offset,
                master_scaling,
                slave_scaling,
                master_start: master_start_position,
                accuracy: master_accuracy,
            })?;
            CamFigures::MasterPosition {
                low: low.map(MasterFigures::from),
                high: high.map(MasterFigures::from),
            }
        }
        PlateCommand::CamTableSelect { .. }
        | PlateCommand::CamTableDelete { .. }
        | PlateCommand::CamInfo { .. } => return Ok(None),
    }))
}

fn points(plate: &Plate, first: u32, number: usize) -> Result<CamFigures, CamError> {
    let received = plate.table_type();
    let function = plate
        .function()
        .ok_or(CamError::NotAMotionFunction { received })?;
    let points = function.read(first, number)?;
    Ok(CamFigures::Points {
        number_of_rows: plate.rows(),
        points: points
            .iter()
            .take(MAX_POINTS_READ)
            .map(WrittenPoint::from)
            .collect(),
    })
}

fn values(
    plate: &Plate,
    [from, to, increment]: [f64; 3],
    selected: SelectedValues,
) -> Result<CamFigures, CamError> {
    let table = plate.values(from, to, increment, selected.0)?;
    let (received, _) = table.size_hint();
    if received > MAX_VALUES_READ {
        return Err(CamError::TooManyValues {
            received,
            most: MAX_VALUES_READ,
        });
    }
    let rows: Vec<Vec<f64>> = table.map(|row| row.to_vec()).collect();
    let columns = ["master"].into_iter().chain(selected.names());
    Ok(CamFigures::Values {
        columns: columns.map(str::to_owned).collect(),
        rows,
    })
}

fn finite(name: &'static str, received: f64) -> Result<(), CamError> {
    if received.is_finite() {
        return Ok(());
    }
    let expected = "a finite number";
    Err(CamError::Parameter {
        name,
        received,
        expected,
    })
}

impl From<MasterPosition> for MasterFigures {
    fn from(found: MasterPosition) -> Self {
        Self {
            master_axis_position: found.axis,
            master_cam_position: found.cam,
            slave_offset: found.slave_offset,
        }
    }
}

impl CharacteristicFigures {
    /// Figures of the characteristics found for the plate with that number.
    #[must_use]
    pub fn of(table: u32, plate: &Plate, found: &Characteristics) -> Self {
        let step = |step: VelocityStep| StepFigures {
            master: step.master,
            before: step.before,
            after: step.after,
        };
        Self {
            values: named(found),
            table,
            number_of_rows: found.rows,
            number_of_columns: found.columns,
            table_type: found.table_type,
            course: found.course,
            lift: plate.lift(),
            velocity_steps: found.velocity_steps,
            largest_velocity_step: found.largest_velocity_step.map(step),
        }
    }
}

/// Returns the values under the names and in the order of TF5050 chapter 8.11.
fn named(c: &Characteristics) -> Vec<NamedValue> {
    let (start, end) = (&c.start, &c.end);
    let [position, velocity, acceleration, jerk]: [&MinMax; 4] = [
        &c.extremes.position,
        &c.extremes.velocity,
        &c.extremes.acceleration,
        &c.extremes.jerk,
    ];
    let values = [
        ("fMasterVeloNom", c.master_velocity),
        ("fMasterPosStart", start.master),
        ("fSlavePosStart", start.slave.position),
        ("fSlaveVeloStart", start.slave.velocity),
        ("fSlaveAccStart", start.slave.acceleration),
        ("fSlaveJerkStart", start.slave.jerk),
        ("fMasterPosEnd", end.master),
        ("fSlavePosEnd", end.slave.position),
        ("fSlaveVeloEnd", end.slave.velocity),
        ("fSlaveAccEnd", end.slave.acceleration),
        ("fSlaveJerkEnd", end.slave.jerk),
        ("fMPosAtSPosMin", position.minimum.master),
        ("fSlavePosMin", position.minimum.value),
        ("fMPosAtSVeloMin", velocity.minimum.master),
        ("fSlaveVeloMin", velocity.minimum.value),
        ("fMPosAtSAccMin", acceleration.minimum.master),
        ("fSlaveAccMin", acceleration.minimum.value),
        ("fSVeloAtSAccMin", c.velocity_at_minimum_acceleration),
        ("fSlaveJerkMin", jerk.minimum.value),
        ("fSlaveDynMomMin", c.dynamic_momentum.minimum.value),
        ("fMPosAtSPosMax", position.maximum.master),
        ("fSlavePosMax", position.maximum.value),
        ("fMPosAtSVeloMax", velocity.maximum.master),
        ("fSlaveVeloMax", velocity.maximum.value),
        ("fMPosAtSAccMax", acceleration.maximum.master),
        ("fSlaveAccMax", acceleration.maximum.value),
        ("fSVeloAtSAccMax", c.velocity_at_maximum_acceleration),
        ("fSlaveJerkMax", jerk.maximum.value),
        ("fSlaveDynMomMax", c.dynamic_momentum.maximum.value),
        ("fSlaveVeloMean", c.mean_velocity),
        ("fSlaveAccEff", c.effective_acceleration),
    ];
    let named = |(name, value): (&str, f64)| NamedValue {
        name: name.to_owned(),
        value,
    };
    values.into_iter().map(named).collect()
}
