//! The cam plates of the axis, or of its node, and their values.

use alloc::boxed::Box;

use coaxle_axis::StateWord;
use coaxle_cam::{
    CamInfo, CamLimits, CamState, CouplingError, PlateReading, PreparedTable, ReservedPlate,
    TableId, Tables,
};
use coaxle_saw::{SawRefusal, saw_table_id};

use super::SlaveAxis;
use crate::couplings::CouplingRefusal;
use crate::refusal::Refusal;

impl SlaveAxis {
    /// `MC_CamTableSelect`: sets the plates of the axis, not shared with others. The ids are those
    /// of its master and its own, for `MC_CamInfo`. A coupling by the previous plates must have
    /// ended. This allocates.
    ///
    /// # Errors
    /// 0x4A1C if the axis can move infinitely far in a cycle.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select_cams(
        &mut self,
        tables: Tables,
        master_axis_id: u32,
        slave_axis_id: u32,
    ) -> Result<(), CouplingError> {
        self.share_cams(master_axis_id, slave_axis_id)?;
        self.lend_cams(Box::new(tables));
        Ok(())
    }

    /// Prepares one of several axes that share a store of plates: table ids are then common to all
    /// of them, as in an NC, and any number of axes can be on a plate. The store is
    /// [lent](Self::lend_cams) to each axis while it acts.
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
    /// axes[0].share_cams(1, 2)?;
    /// axes[1].share_cams(1, 3)?;
    /// let mut plates = Some(Box::new(Tables::new(255)));
    ///
    /// // In a cycle the store goes from one to the next.
    /// for axis in &mut axes {
    ///     axis.lend_cams(plates.take().expect("the one before gave it back"));
    ///     axis.update(None, Seconds(1e-3));
    ///     plates = axis.give_back_cams();
    /// }
    /// # Ok::<(), coaxle_cam::CouplingError>(())
    /// ```
    ///
    /// # Errors
    /// As [`select_cams`](Self::select_cams).
    pub fn share_cams(
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

    /// Lends the axis the store of plates that it shares with others, always the same one. It needs
    /// the store for every command and query, and in every [`update`](Self::update); without it,
    /// its plates count as lost. Earlier plans must not be applied any more. This neither allocates
    /// nor locks.
    pub fn lend_cams(&mut self, tables: Box<Tables>) {
        let selections = tables.selections();
        self.couplings.cam.lend(tables);
        self.revision = self.revision.wrapping_add(1);
        if self.selections != Some(selections) {
            self.note_saw_table();
        }
    }

    /// Takes the plates back, for others.
    pub const fn give_back_cams(&mut self) -> Option<Box<Tables>> {
        self.couplings.cam.give_back()
    }

    /// `MC_CamTableSelect` while the axis runs: adds a table, like [`Tables::select`], of at most
    /// `room` points or rows. A replaced table is in `table` afterwards. This does not allocate.
    ///
    /// # Errors
    /// As there, without any change.
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

    /// Plans [`select_cam`](Self::select_cam).
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

    /// Removes a table, into `table`, like [`Tables::delete`].
    ///
    /// # Errors
    /// As there, without any change.
    pub fn delete_cam(
        &mut self,
        id: TableId,
        table: &mut Option<Box<PreparedTable>>,
    ) -> Result<(), CouplingError> {
        self.couplings.cam.delete_table(id, table)?;
        self.plates_changed();
        Ok(())
    }

    /// Plans [`delete_cam`](Self::delete_cam).
    ///
    /// # Errors
    /// As there.
    pub fn plan_delete_cam(&self, id: TableId) -> Result<(), CouplingError> {
        match self.cam_tables() {
            Some(tables) => tables.plan_delete(id),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// `MC_CamTableSelect` of a table that was reserved in the store, like
    /// [`Tables::select_reserved`], for programs.
    ///
    /// # Errors
    /// As there, without any change.
    pub fn select_reserved_cam(
        &mut self,
        reserved: ReservedPlate,
        replace: bool,
    ) -> Result<(), CouplingError> {
        self.couplings.cam.select_reserved(reserved, replace)?;
        self.plates_changed();
        Ok(())
    }

    /// Removes a table, like [`Tables::put_away`], for programs.
    ///
    /// # Errors
    /// As there, without any change.
    pub fn put_cam_away(&mut self, id: TableId) -> Result<(), CouplingError> {
        self.couplings.cam.put_away(id)?;
        self.plates_changed();
        Ok(())
    }

    /// Reads a plate for a calculation elsewhere, like [`Tables::read_plate`].
    ///
    /// # Errors
    /// As there.
    pub fn read_plate(&self, id: TableId, into: &mut PlateReading) -> Result<(), CouplingError> {
        match self.cam_tables() {
            Some(tables) => tables.read_plate(id, into),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// The plates of the axis; none before any were selected, or while another axis has them.
    #[must_use]
    pub fn cam_tables(&self) -> Option<&Tables> {
        self.couplings.cam.tables()
    }

    /// `MC_CamInfo`, `MC_CamInfo_V2`: the coupling by a cam plate (0 if there is only one), or its
    /// values at a position of the master axis. After an error the last values stay, until it is
    /// acknowledged.
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

    /// The plate that couples the axis now, the first of several, and the positions of master and
    /// slave on it; none without one.
    #[must_use]
    pub fn cam_state(&self) -> Option<CamState> {
        self.couplings.cam.cam_state()
    }

    /// Pending changes of the coupling by cam plates.
    #[must_use]
    pub fn cam_queued(&self) -> StateWord {
        self.queued()
    }

    /// Invalidates plans with other plates.
    fn plates_changed(&mut self) {
        self.revision = self.revision.wrapping_add(1);
        self.note_saw_table();
    }

    /// Notes the id of a table for a flying saw's profile.
    fn note_saw_table(&mut self) {
        let tables = self.couplings.cam.tables();
        self.selections = tables.map(Tables::selections);
        let in_use = |id| tables.is_some_and(|tables| tables.plate(id).is_ok());
        let table = match saw_table_id(self.axis_id, in_use) {
            Err(SawRefusal::TableInUse { table }) => Some(table),
            _ => None,
        };
        self.couplings.saw.set_table_in_use(table);
    }
}
