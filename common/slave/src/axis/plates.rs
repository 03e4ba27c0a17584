//! The cam plates of the axis, and what they say.

use alloc::boxed::Box;

use coaxle_axis::StateWord;
use coaxle_cam::{
    CamInfo, CamLimits, CamState, CouplingError, PlateReading, PreparedTable, TableId, Tables,
};
use coaxle_saw::{SawRefusal, saw_table_id};

use super::SlaveAxis;

impl SlaveAxis {
    /// `MC_CamTableSelect`: the plates that the axis can be coupled by. The ids are those of its
    /// master and its own, for `MC_CamInfo`. A coupling by the plates before must have ended. This
    /// allocates.
    ///
    /// # Errors
    /// 0x4A1C if the axis can go infinitely far in a cycle.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select_cams(
        &mut self,
        tables: Tables,
        master_axis_id: u32,
        slave_axis_id: u32,
    ) -> Result<(), CouplingError> {
        self.axis_id = slave_axis_id;
        let limits = CamLimits::of(self.guard.limits(), self.cycle_time);
        let axes = [master_axis_id, slave_axis_id];
        self.couplings.cam.select(tables, limits, axes)?;
        self.note_saw_table();
        Ok(())
    }

    /// `MC_CamTableSelect` while the axis runs: takes a table in, as [`Tables::select`], of at most `room` points or rows.
    /// What was replaced is in `table` afterwards. Nothing is allocated.
    ///
    /// # Errors
    /// As there. Then everything is as it was.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select_cam(
        &mut self,
        id: TableId,
        replace: bool,
        table: &mut Option<Box<PreparedTable>>,
        room: usize,
    ) -> Result<(), CouplingError> {
        let cam = &mut self.couplings.cam;
        cam.select_table(id, replace, table, room)?;
        self.plates_changed();
        Ok(())
    }

    /// Whether [`select_cam`](Self::select_cam) would do it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_select_cam(
        &self,
        id: TableId,
        replace: bool,
        table: Option<&PreparedTable>,
        room: usize,
    ) -> Result<(), CouplingError> {
        match self.cam_tables() {
            Some(tables) => tables.plan_select(id, replace, table, room),
            None => Err(CouplingError::StoreFull { capacity: 0 }),
        }
    }

    /// Takes a table out, into `table`, as [`Tables::delete`].
    ///
    /// # Errors
    /// As there. Then everything is as it was.
    pub fn delete_cam(
        &mut self,
        id: TableId,
        table: &mut Option<Box<PreparedTable>>,
    ) -> Result<(), CouplingError> {
        self.couplings.cam.delete_table(id, table)?;
        self.plates_changed();
        Ok(())
    }

    /// Whether [`delete_cam`](Self::delete_cam) would do it.
    ///
    /// # Errors
    /// As there.
    pub fn plan_delete_cam(&self, id: TableId) -> Result<(), CouplingError> {
        match self.cam_tables() {
            Some(tables) => tables.plan_delete(id),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// Reads a plate for somebody who calculates elsewhere, as [`Tables::read_plate`].
    ///
    /// # Errors
    /// As there.
    pub fn read_plate(&self, id: TableId, into: &mut PlateReading) -> Result<(), CouplingError> {
        match self.cam_tables() {
            Some(tables) => tables.read_plate(id, into),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// The plates of the axis; none before any were selected.
    #[must_use]
    pub fn cam_tables(&self) -> Option<&Tables> {
        self.couplings.cam.tables()
    }

    /// `MC_CamInfo`, `MC_CamInfo_V2`: the coupling by a cam plate (0 if there is but one), or as it would be at a
    /// position of the master axis. After an error it is what it was, until that is acknowledged.
    ///
    /// # Errors
    /// As [`CamCoupling::info`](coaxle_cam::CamCoupling::info).
    #[doc(alias = "MC_CamInfo")]
    #[doc(alias = "MC_CamInfo_V2")]
    pub fn cam_info(&self, table: TableId, at: Option<f64>) -> Result<CamInfo, CouplingError> {
        let info = self.couplings.cam.info(table, at)?;
        Ok(CamInfo {
            sum_of_superposition_distance: self.superimposed.now().position,
            ..info
        })
    }

    /// The plate that couples the axis now, of several the first, and where master and slave are on it; none without.
    #[must_use]
    pub fn cam_state(&self) -> Option<CamState> {
        self.couplings.cam.cam_state()
    }

    /// What waits in the coupling by cam plates.
    #[must_use]
    pub fn cam_queued(&self) -> StateWord {
        self.queued()
    }

    /// What was planned before was planned with other plates.
    fn plates_changed(&mut self) {
        self.revision = self.revision.wrapping_add(1);
        self.note_saw_table();
    }

    /// A flying saw needs the id of a table for its profile.
    fn note_saw_table(&mut self) {
        let tables = self.couplings.cam.tables();
        let in_use = |id| tables.is_some_and(|tables| tables.plate(id).is_ok());
        let table = match saw_table_id(self.axis_id, in_use) {
            Err(SawRefusal::TableInUse { table }) => Some(table),
            _ => None,
        };
        self.couplings.saw.set_table_in_use(table);
    }
}
