//! An axis with cam plates of its own.

use std::boxed::Box;
use std::ops::{Deref, DerefMut};

use coaxle_axis::drive::Drive;
use coaxle_axis::{Job, Masters, NcToPlcAxis, Origin, StateWord};
use coaxle_cam::{CamInfo, CamState, CouplingError, PlateReading, PreparedTable, TableId, Tables};
use coaxle_clock::{CycleTime, Seconds};
use coaxle_curve::profile::Kinematics;

use crate::{
    Change, Command, CoupledStart, Refusal, SlaveAxis, SlaveParameters, WrongSlaveParameter,
};

/// An axis, and the plates that it acts on.
#[derive(Debug)]
pub(super) struct AxisWithPlates {
    axis: SlaveAxis,
    pub(super) plates: Tables,
}

impl AxisWithPlates {
    pub(super) fn new(
        parameters: &SlaveParameters,
        drive: Box<dyn Drive>,
        cycle_time: CycleTime,
    ) -> Result<Self, WrongSlaveParameter> {
        Ok(Self {
            axis: SlaveAxis::new(parameters, drive, cycle_time)?,
            plates: Tables::new(0),
        })
    }

    pub(super) fn select_cams(
        &mut self,
        plates: Tables,
        master_axis_id: u32,
        slave_axis_id: u32,
    ) -> Result<(), CouplingError> {
        self.axis.prepare_cams(master_axis_id, slave_axis_id)?;
        self.plates = plates;
        Ok(())
    }

    pub(super) fn update(&mut self, masters: impl Into<Masters>, elapsed: Seconds) -> Kinematics {
        self.axis.update(&mut self.plates, masters, elapsed)
    }

    pub(super) fn plan(&self, command: &Command) -> Result<Change, Refusal> {
        self.axis.plan(&self.plates, command)
    }

    pub(super) fn apply(&mut self, change: Change, origin: Origin) -> Job {
        self.axis.apply(&mut self.plates, change, origin)
    }

    pub(super) fn command(&mut self, command: &Command) -> Result<Job, Refusal> {
        self.axis.command(&mut self.plates, command)
    }

    pub(super) fn switch_on_coupled(
        &mut self,
        start: &CoupledStart,
        masters: impl Into<Masters>,
    ) -> Result<Job, Refusal> {
        self.axis
            .switch_on_coupled(&mut self.plates, start, masters)
    }

    pub(super) fn select_cam(
        &mut self,
        id: TableId,
        replace: bool,
        table: &mut Option<Box<PreparedTable>>,
        room: usize,
    ) -> Result<(), CouplingError> {
        self.plates.select(id, replace, table, room)
    }

    pub(super) fn plan_select_cam(
        &self,
        id: TableId,
        replace: bool,
        table: Option<&PreparedTable>,
        room: usize,
    ) -> Result<(), CouplingError> {
        self.plates.plan_select(id, replace, table, room)
    }

    pub(super) fn delete_cam(
        &mut self,
        id: TableId,
        table: &mut Option<Box<PreparedTable>>,
    ) -> Result<(), CouplingError> {
        self.plates.delete(id, table)
    }

    pub(super) fn read_plate(
        &self,
        id: TableId,
        into: &mut PlateReading,
    ) -> Result<(), CouplingError> {
        self.plates.read_plate(id, into)
    }

    pub(super) fn cam_info(
        &self,
        table: TableId,
        at: Option<f64>,
    ) -> Result<CamInfo, CouplingError> {
        self.axis.cam_info(&self.plates, table, at)
    }

    pub(super) fn cam_state(&self) -> Option<CamState> {
        self.axis.cam_state(&self.plates)
    }

    pub(super) fn cam_queued(&self) -> StateWord {
        self.axis.cam_queued(&self.plates)
    }

    pub(super) fn axis_struct(&self, id: u32) -> NcToPlcAxis {
        self.axis.axis_struct(&self.plates, id)
    }
}

impl Deref for AxisWithPlates {
    type Target = SlaveAxis;

    fn deref(&self) -> &SlaveAxis {
        &self.axis
    }
}

impl DerefMut for AxisWithPlates {
    fn deref_mut(&mut self) -> &mut SlaveAxis {
        &mut self.axis
    }
}
