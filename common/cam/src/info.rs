//! `MC_CamInfo`, `MC_CamInfo_V2`: state of a coupling.

use super::change_moment::ChangeMoment;
use super::command::Activation;
use super::coupling::CamCoupling;
use super::error::{CouplingError, TableId};
use super::layer::Pending;
use super::modes::ScalingMode;
use super::tables::Tables;
use coaxle_plate::{Course, Interpolation, TableType};

/// `MC_CamInfoData`, TF5050 chapter 8.5. Axis positions in u, positions on the unscaled plate in x
/// and u of the plate.
///
/// A superposition added to the slave after the coupling is not known to the coupling: the axis fills it
/// in.
#[doc(alias = "MC_CamInfoData")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub struct CamInfo {
    /// The plate.
    #[doc(alias = "CamTableId")]
    pub table: TableId,
    /// Type of the plate.
    pub table_type: TableType,
    /// Course: linear or cyclic.
    #[doc(alias = "Periodic")]
    pub course: Course,
    /// The interpolation of a position table.
    pub interpolation: Interpolation,
    /// Number of its rows or points.
    #[doc(alias = "NumberOfRows")]
    pub rows: usize,
    /// Number of its columns.
    #[doc(alias = "NumberOfColumns")]
    pub columns: usize,
    /// The master axis.
    pub master_axis_id: u32,
    /// The slave axis.
    pub slave_axis_id: u32,
    /// First master position of the plate.
    #[doc(alias = "MasterCamStartPos")]
    pub master_cam_start: f64,
    /// Slave position there.
    #[doc(alias = "SlaveCamStartPos")]
    pub slave_cam_start: f64,
    /// Distance of the master from the first to the last point, unscaled.
    pub raw_master_period: f64,
    /// Distance of the slave from the first to the last point, unscaled.
    pub raw_slave_stroke: f64,
    /// Position of the master axis when the plate became active.
    #[doc(alias = "MasterAxisCouplingPos")]
    pub master_axis_coupling_position: f64,
    /// Position of the slave axis when the plate became active.
    #[doc(alias = "SlaveAxisCouplingPos")]
    pub slave_axis_coupling_position: f64,
    /// True if the master's positions are absolute.
    pub master_absolute: bool,
    /// True if the slave's positions are absolute.
    pub slave_absolute: bool,
    /// Total offset of the master.
    pub master_offset: f64,
    /// Total offset of the slave, without the strokes.
    pub slave_offset: f64,
    /// Scaling of the master.
    pub master_scaling: f64,
    /// Scaling of the slave.
    pub slave_scaling: f64,
    /// The strokes done since the base cycle, scaled.
    #[doc(alias = "SumOfSlaveStrokes")]
    pub sum_of_slave_strokes: f64,
    /// Distance of `MC_MoveSuperImposed`, u; 0 for a coupling without an axis.
    #[doc(alias = "SumOfSuperpositionDistance")]
    pub sum_of_superposition_distance: f64,
    /// Position of the master axis: its set position, or the one in the request.
    #[doc(alias = "ActualMasterAxisPos")]
    pub master_axis_position: f64,
    /// The slave axis at that master position.
    #[doc(alias = "ActualSlaveAxisPos")]
    pub slave_axis_position: f64,
    /// The master on the plate, within the base cycle if it is cyclic.
    #[doc(alias = "ActualMasterCamPos")]
    pub master_cam_position: f64,
    /// The slave on the plate there, without strokes.
    #[doc(alias = "ActualSlaveCamPos")]
    pub slave_cam_position: f64,
    /// The scaling that is queued.
    #[doc(alias = "ScalingPending")]
    pub scaling_pending: Option<QueuedChange>,
    /// True if points wait for their activation.
    pub cam_data_queued: bool,
    /// Activation of points: of those that wait, else of those to be written.
    #[doc(alias = "OnlineChangeActivationMode")]
    pub online_change: QueuedChange,
    /// The plate that is queued for this one's place, or this one's removal (id 0).
    #[doc(alias = "CamTableQueued")]
    #[doc(alias = "CamExchangeCamTableID")]
    pub table_queued: Option<QueuedTable>,
}

/// A plate that is queued for the place of another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub struct QueuedTable {
    /// The plate to come; 0 if the present one is only removed.
    pub table: TableId,
    /// Activation and scaling modes.
    pub change: QueuedChange,
}

/// Brief state of a coupling by the first of its plates, at low cost for every cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamState {
    /// The plate.
    pub table: TableId,
    /// The master on the plate, within the base cycle if it is cyclic, x.
    pub master_cam_position: f64,
    /// The slave on the plate there, without strokes, u of the plate.
    pub slave_cam_position: f64,
}

/// Activation and scaling modes of a queued change.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub struct QueuedChange {
    /// Activation of the change.
    pub activation: Activation,
    /// Source of the master's offset and scaling.
    pub master_scaling_mode: ScalingMode,
    /// Source of the slave's offset and scaling.
    pub slave_scaling_mode: ScalingMode,
}

impl CamCoupling {
    /// `MC_CamInfo`, `MC_CamInfo_V2`: state of the coupling by a plate (0 if there is only one), now or
    /// for a given position of the master axis. After an error, the last valid state.
    ///
    /// # Errors
    /// 0x4256 if the slave is not coupled, 0x4261 if the plate is not one of its plates.
    #[doc(alias = "MC_CamInfo")]
    #[doc(alias = "MC_CamInfo_V2")]
    pub fn info(
        &self,
        tables: &Tables,
        table: TableId,
        at_master_position: Option<f64>,
    ) -> Result<CamInfo, CouplingError> {
        let index = self.place_of(table)?;
        let layer = self.layers[index]
            .as_ref()
            .ok_or(CouplingError::NotCoupled)?;
        let queue = &self.queues[index];
        let versions = tables.versions(&layer.table)?;
        let plate = layer.plate(tables)?;
        let placement = &layer.placement;
        let master = at_master_position.unwrap_or(self.master.position);
        // Here the set position counts, which after an error is the last valid one.
        let slave = match at_master_position {
            Some(_) => self.path_at(tables, &ChangeMoment::at(master))?.position,
            None => self.slave.position,
        };
        let (start, _) = plate.master_range();
        let on_plate = placement.on_plate(master);
        let (turn, _) = placement.turns(plate, master);
        // By the same turn as the strokes, so that both sums agree at a seam.
        let in_cycle = on_plate - turn * plate.period();
        let online = versions.queued().unwrap_or(versions.mode());
        Ok(CamInfo {
            table: layer.table.id,
            table_type: plate.table_type(),
            course: plate.course(),
            interpolation: plate.interpolation(),
            rows: plate.rows(),
            columns: plate.columns(),
            master_axis_id: self.parameters.master_axis_id,
            slave_axis_id: self.parameters.slave_axis_id,
            master_cam_start: start,
            slave_cam_start: plate.at(start).position,
            raw_master_period: plate.period(),
            raw_slave_stroke: plate.lift(),
            master_axis_coupling_position: layer.start.master,
            slave_axis_coupling_position: layer.start.slave,
            master_absolute: layer.start.master_absolute,
            slave_absolute: layer.start.slave_absolute,
            master_offset: placement.master_offset,
            slave_offset: placement.slave_offset,
            master_scaling: placement.master_scaling,
            slave_scaling: placement.slave_scaling,
            sum_of_slave_strokes: placement.strokes_at(plate, master),
            // The coupling does not know of superpositions: the axis adds them behind it.
            sum_of_superposition_distance: 0.0,
            master_axis_position: master,
            slave_axis_position: slave,
            master_cam_position: in_cycle,
            slave_cam_position: plate.at(in_cycle).position,
            scaling_pending: queue.scaling.as_ref().map(queued),
            cam_data_queued: versions.queued().is_some(),
            online_change: QueuedChange {
                activation: online.activation,
                master_scaling_mode: online.master_scaling_mode,
                slave_scaling_mode: online.slave_scaling_mode,
            },
            table_queued: queue.table.as_ref().map(|pending| QueuedTable {
                table: pending.table.map_or(0, |t| t.id),
                change: queued(pending),
            }),
        })
    }

    /// Returns the brief state of the coupling, of several plates by the first; none before one is
    /// active. After an error, the last valid state.
    #[must_use]
    pub fn cam_state(&self, tables: &Tables) -> Option<CamState> {
        // The first plate stands for all: signals have one column, and a row is filled in each cycle.
        let layer = self.layers.iter().flatten().next()?;
        let plate = layer.plate(tables).ok()?;
        let on_plate = layer.placement.on_plate(self.master.position);
        let (turn, _) = layer.placement.turns(plate, self.master.position);
        let in_cycle = on_plate - turn * plate.period();
        Some(CamState {
            table: layer.table.id,
            master_cam_position: in_cycle,
            slave_cam_position: plate.at(in_cycle).position,
        })
    }
}

fn queued(pending: &Pending) -> QueuedChange {
    QueuedChange {
        activation: pending.activation,
        master_scaling_mode: pending.scaling.master.mode,
        slave_scaling_mode: pending.scaling.slave.mode,
    }
}
