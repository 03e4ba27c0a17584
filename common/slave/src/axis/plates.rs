//! The axis on the cam plates of its node.

use coaxle_axis::{NotPlanned, PlanInputs, Planned, StateWord};
use coaxle_cam::{CamInfo, CamLimits, CamState, CouplingError, TableId, Tables};
use coaxle_saw::{SawCommand, SawRefusal, saw_table_id};

use super::SlaveAxis;
use crate::couplings::{CouplingRefusal, Engagement};
use crate::refusal::Refusal;

impl SlaveAxis {
    /// Prepares the axis for cam plates, with the ids of its master and its own for `MC_CamInfo`. This
    /// allocates. A coupling by plates must have ended.
    ///
    /// The plates are a store that is passed to the axis when it acts, always the same one. Several axes can
    /// share it: table ids are then common to all of them, as in an NC, and any number of axes can be on a
    /// plate.
    ///
    /// ```
    /// # use coaxle_axis::drive::{DriveParameters, SimulatedDrive};
    /// # use coaxle_cam::Tables;
    /// # use coaxle_clock::{CycleTime, Seconds, Span};
    /// # use coaxle_slave::{SlaveAxis, SlaveParameters};
    /// # let cycle = CycleTime::new(Span::from_millis(1)).unwrap();
    /// # let parameters = SlaveParameters::new(1_000.0, 10_000.0, 1e6);
    /// # let axis = || {
    /// #     let drive = SimulatedDrive::new(DriveParameters::default()).unwrap();
    /// #     SlaveAxis::new(&parameters, Box::new(drive), cycle).unwrap()
    /// # };
    /// let mut axes = [axis(), axis()];
    /// axes[0].prepare_cams(1, 2)?;
    /// axes[1].prepare_cams(1, 3)?;
    /// let mut plates = Tables::new(255);
    ///
    /// for axis in &mut axes {
    ///     axis.update(&mut plates, None, Seconds(1e-3));
    /// }
    /// # Ok::<(), coaxle_cam::CouplingError>(())
    /// ```
    ///
    /// # Errors
    /// 0x4A1C if the axis can move infinitely far in a cycle.
    pub fn prepare_cams(
        &mut self,
        master_axis_id: u32,
        slave_axis_id: u32,
    ) -> Result<(), CouplingError> {
        self.axis_id = slave_axis_id;
        let limits = CamLimits::of(self.guard.limits(), self.cycle_time);
        let axes = [master_axis_id, slave_axis_id];
        self.couplings.cam.prepare(limits, axes)
    }

    /// Takes the reason why the coupling did not take points of a plate when they were due, once
    /// for each time that points are written: the points stay pending.
    pub fn take_held_back(&mut self) -> Option<Refusal> {
        let why = self.couplings.cam.take_rejected_points()?;
        Some(Refusal::Coupling(CouplingRefusal::Cam(why)))
    }

    /// `MC_CamInfo`, `MC_CamInfo_V2`: the coupling by a cam plate (0 if there is only one), or its
    /// values at a position of the master axis. After an error the last values stay, until it is
    /// acknowledged.
    ///
    /// # Errors
    /// As [`CamCoupling::info`](coaxle_cam::CamCoupling::info).
    #[doc(alias = "MC_CamInfo")]
    #[doc(alias = "MC_CamInfo_V2")]
    pub fn cam_info(
        &self,
        plates: &Tables,
        table: TableId,
        at: Option<f64>,
    ) -> Result<CamInfo, CouplingError> {
        let info = self.couplings.cam.info(plates, table, at)?;
        Ok(CamInfo {
            // The plate does not know the offset that is added behind it.
            sum_of_superposition_distance: self.superimposed.now().position,
            ..info
        })
    }

    /// The plate that couples the axis now, the first of several, and the positions of master and
    /// slave on it; none without one.
    #[must_use]
    pub fn cam_state(&self, plates: &Tables) -> Option<CamState> {
        self.couplings.cam.cam_state(plates)
    }

    /// Pending changes of the coupling by cam plates.
    #[must_use]
    pub fn cam_queued(&self, plates: &Tables) -> StateWord {
        self.queued(plates)
    }

    /// Plans a flying saw, whose profile takes a table of its own.
    pub(super) fn plan_saw(
        &self,
        plates: &Tables,
        command: &SawCommand,
        inputs: &PlanInputs,
    ) -> Result<Planned<Engagement>, NotPlanned<CouplingRefusal>> {
        inputs.master()?;
        // The profile of a saw has the table id 256 − axis id (TS5055 13), which a plate may have taken.
        let in_use = |id| plates.plate(id).is_ok();
        if let Err(why @ SawRefusal::TableInUse { .. }) = saw_table_id(self.axis_id, in_use) {
            return Err(NotPlanned::Own(why.into()));
        }
        self.couplings.saw(plates, command, inputs)
    }
}
