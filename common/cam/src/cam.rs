//! The cam plates of a slave axis, and its coupling by them.

use alloc::boxed::Box;

use crate::{
    CamChange, CamCoupling, CamIn, CamInfo, CamLimits, CamRequest, CamState, CouplingError,
    CouplingParameters, CouplingState, JumpHandling, OnlineChangeMode, PreparedTable,
    ReservedPlate, TableId, Tables,
};
use coaxle_axis::{
    CommandState, Coupling, CouplingEffect, CouplingPhase, Engage, Job, NotPlanned, PlanInputs,
    Planned, Scan, StateWord, Step,
};
use coaxle_curve::profile::Kinematics;
use coaxle_plate::MotionPoint;

/// The cam plates of an axis and its coupling by them, which is idle as long as something else moves the
/// axis. Without plates it can only refuse, and takes next to no memory.
///
/// The plates are its own, or shared by the axes of a node one after the other. A node
/// [lends](Self::lend) them to each axis for its update and [takes them back](Self::give_back). Only a
/// pointer changes hands, so nothing is locked or copied, and only the present holder can use the plates.
#[derive(Debug, Default)]
pub struct Cam {
    /// Plates; none while they are lent to others.
    tables: Option<Box<Tables>>,
    coupling: Option<Box<CamCoupling>>,
}

/// Plates and coupling, to read.
#[derive(Clone, Copy)]
struct Plates<'a> {
    tables: &'a Tables,
    coupling: &'a CamCoupling,
}

/// Plates and coupling, to change.
struct PlatesMut<'a> {
    tables: &'a mut Tables,
    coupling: &'a mut CamCoupling,
}

impl Cam {
    /// `MC_CamTableSelect`: takes these plates as its own, for a slave with these limits, with the ids of
    /// master and slave for `MC_CamInfo`. Any coupling has ended. Allocates.
    ///
    /// # Errors
    /// 0x4A1C if the limits are not finite numbers above 0.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select(
        &mut self,
        tables: Tables,
        limits: CamLimits,
        axes: [u32; 2],
    ) -> Result<(), CouplingError> {
        self.prepare(limits, axes)?;
        self.lend(Box::new(tables));
        Ok(())
    }

    /// Prepares an axis that is lent its plates.
    ///
    /// # Errors
    /// As [`select`](Self::select).
    pub fn prepare(
        &mut self,
        limits: CamLimits,
        [master_axis_id, slave_axis_id]: [u32; 2],
    ) -> Result<(), CouplingError> {
        let coupling = CamCoupling::new(CouplingParameters {
            master_axis_id,
            slave_axis_id,
            limits,
        })?;
        self.coupling = Some(Box::new(coupling));
        Ok(())
    }

    /// Lends it these plates from now on: always the same store, which others may have changed meanwhile.
    pub fn lend(&mut self, tables: Box<Tables>) {
        self.tables = Some(tables);
    }

    /// Gives the plates back. Until it is lent them again it can only refuse; while it moves the axis it
    /// needs them in each of its cycles.
    pub const fn give_back(&mut self) -> Option<Box<Tables>> {
        self.tables.take()
    }

    /// Plans the coupling of an axis that has always been on the plate.
    ///
    /// # Errors
    /// [`CouplingError`]: the plate does not exist.
    pub fn plan_on_plate(
        &self,
        cam_in: &CamIn,
        master: &Kinematics,
    ) -> Result<CamChange, CouplingError> {
        let request = CamRequest::from(CamIn {
            // The axis is put onto the plate, so there is no course before it to jump from.
            jump: JumpHandling::Allow,
            ..*cam_in
        });
        let slave = Kinematics::default();
        self.ask(|plates| {
            plates
                .coupling
                .plan(plates.tables, &request, master, &slave)
        })
    }

    /// Couples the axis like this, and returns its position on the plate.
    ///
    /// # Errors
    /// [`CouplingError`]: the plate has no position for it.
    pub fn start_on_plate(
        &mut self,
        change: &CamChange,
        job: Job,
        master: &Kinematics,
    ) -> Result<Kinematics, CouplingError> {
        let Some(PlatesMut { tables, coupling }) = self.plates_mut() else {
            return Err(CouplingError::NotCoupled);
        };
        // A second start would otherwise find the plate of the first in its place.
        coupling.end(tables);
        coupling.apply(tables, change, job);
        let slave = coupling.update(tables, master);
        match coupling.state_of(job) {
            CommandState::Failed(error) => Err(error),
            _ => Ok(slave),
        }
    }

    /// `MC_CamTableSelect` while the axis runs, as [`Tables::select`]. A store, possibly empty, was
    /// selected before.
    ///
    /// # Errors
    /// As there.
    #[doc(alias = "MC_CamTableSelect")]
    pub fn select_table(
        &mut self,
        id: TableId,
        replace: bool,
        table: &mut Option<Box<PreparedTable>>,
        room: usize,
    ) -> Result<(), CouplingError> {
        match &mut self.tables {
            Some(tables) => tables.select(id, replace, table, room),
            None => Err(CouplingError::StoreFull { capacity: 0 }),
        }
    }

    /// `MC_CamTableSelect` of a table that was reserved, as [`Tables::select_reserved`].
    ///
    /// # Errors
    /// As there.
    pub fn select_reserved(
        &mut self,
        reserved: ReservedPlate,
        replace: bool,
    ) -> Result<(), CouplingError> {
        match &mut self.tables {
            Some(tables) => tables.select_reserved(reserved, replace),
            None => Err(CouplingError::StoreFull { capacity: 0 }),
        }
    }

    /// Removes a table, as [`Tables::put_away`].
    ///
    /// # Errors
    /// As there.
    pub fn put_away(&mut self, id: TableId) -> Result<(), CouplingError> {
        match &mut self.tables {
            Some(tables) => tables.put_away(id),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// Removes a table, as [`Tables::delete`].
    ///
    /// # Errors
    /// As there.
    pub fn delete_table(
        &mut self,
        id: TableId,
        table: &mut Option<Box<PreparedTable>>,
    ) -> Result<(), CouplingError> {
        match &mut self.tables {
            Some(tables) => tables.delete(id, table),
            None => Err(CouplingError::TableUnknown { table: id }),
        }
    }

    /// Returns the state of the coupling for every cycle, at low cost: [`CamCoupling::cam_state`].
    #[must_use]
    pub fn cam_state(&self) -> Option<CamState> {
        let Plates { tables, coupling } = self.plates()?;
        coupling.cam_state(tables)
    }

    /// Checks `MC_SetCamOnlineChangeMode` without applying it.
    ///
    /// # Errors
    /// [`CouplingError`].
    pub fn plan_mode(&self, table: TableId, mode: &OnlineChangeMode) -> Result<(), CouplingError> {
        self.ask(|plates| plates.tables.plan_online_change_mode(table, mode))
    }

    /// `MC_SetCamOnlineChangeMode`.
    ///
    /// # Errors
    /// As [`plan_mode`](Self::plan_mode).
    pub fn set_mode(
        &mut self,
        table: TableId,
        mode: OnlineChangeMode,
    ) -> Result<(), CouplingError> {
        match &mut self.tables {
            Some(tables) => tables.set_online_change_mode(table, mode),
            // Without plates the plan refuses, with the same error as for an unknown table.
            None => self.plan_mode(table, &mode),
        }
    }

    /// Checks `MC_WriteMotionFunction` without applying it.
    ///
    /// # Errors
    /// [`CouplingError`].
    pub fn plan_write(&self, table: TableId, points: &[MotionPoint]) -> Result<(), CouplingError> {
        self.ask(|plates| plates.tables.plan_write(table, points))
    }

    /// `MC_WriteMotionFunction`.
    ///
    /// # Errors
    /// As [`plan_write`](Self::plan_write).
    pub fn write(&mut self, table: TableId, points: &[MotionPoint]) -> Result<(), CouplingError> {
        match &mut self.tables {
            Some(tables) => tables.write(table, points),
            None => self.plan_write(table, points),
        }
    }

    /// Returns the reason why written points did not take effect when they were due, once for each write.
    pub fn take_rejected_points(&mut self) -> Option<CouplingError> {
        self.coupling.as_mut()?.take_rejected_points()
    }

    /// `MC_CamInfo`, as [`CamCoupling::info`]: of a coupling that ended with an error, its last state.
    ///
    /// # Errors
    /// As there.
    #[doc(alias = "MC_CamInfo")]
    pub fn info(&self, table: TableId, at: Option<f64>) -> Result<CamInfo, CouplingError> {
        self.ask(|plates| plates.coupling.info(plates.tables, table, at))
    }

    /// Returns the plates; none if there are none, or while they are lent to others.
    #[must_use]
    pub fn tables(&self) -> Option<&Tables> {
        self.tables.as_deref()
    }

    fn ask<T>(
        &self,
        ask: impl FnOnce(Plates<'_>) -> Result<T, CouplingError>,
    ) -> Result<T, CouplingError> {
        match self.plates() {
            Some(plates) => ask(plates),
            None => ask(Plates {
                tables: &Tables::new(0),
                coupling: &CamCoupling::new(NONE)?,
            }),
        }
    }

    fn plates(&self) -> Option<Plates<'_>> {
        Some(Plates {
            tables: self.tables.as_deref()?,
            coupling: self.coupling.as_deref()?,
        })
    }

    fn plates_mut(&mut self) -> Option<PlatesMut<'_>> {
        Some(PlatesMut {
            tables: self.tables.as_deref_mut()?,
            coupling: self.coupling.as_deref_mut()?,
        })
    }
}

impl Plates<'_> {
    fn plan(self, command: &CamRequest, inputs: &PlanInputs) -> Result<CamChange, CouplingError> {
        let (master, slave) = (inputs.masters.first(), &inputs.slave);
        let master = master.ok_or(CouplingError::AxisError { code: 0 })?;
        if inputs.is_engaged || self.coupling.state() == CommandState::Idle {
            return self.coupling.plan(self.tables, command, master, slave);
        }
        // A coupling that ended with an error is kept for `MC_CamInfo` until another begins.
        CamCoupling::new(*self.coupling.parameters())?.plan(self.tables, command, master, slave)
    }
}

impl Engage for Cam {
    type Command = CamRequest;
    type Change = CamChange;
    type Refusal = CouplingError;
    type Fault = CouplingError;

    fn plan(
        &self,
        command: &CamRequest,
        inputs: &PlanInputs,
    ) -> Result<Planned<CamChange>, NotPlanned<CouplingError>> {
        inputs.master()?;
        let change = self
            .ask(|plates| plates.plan(command, inputs))
            .map_err(NotPlanned::Own)?;
        Ok(Planned {
            awaits: change.awaits(),
            change,
            effect: if inputs.is_engaged {
                CouplingEffect::Adjust
            } else {
                CouplingEffect::Engage
            },
        })
    }

    fn apply(&mut self, change: &CamChange, job: Job) {
        if let Some(PlatesMut { tables, coupling }) = self.plates_mut() {
            coupling.apply(tables, change, job);
        }
    }

    fn refusal(&self) -> Option<CouplingError> {
        let coupling = self.coupling.as_ref()?;
        match coupling.state_of(coupling.first()?) {
            CommandState::Failed(error) => Some(error),
            _ => None,
        }
    }

    fn fault(&self) -> Option<CouplingError> {
        match self.coupling.as_ref()?.state() {
            CommandState::Failed(error) => Some(error),
            _ => None,
        }
    }

    fn state_of(&self, job: Job) -> CouplingState {
        self.coupling
            .as_ref()
            .map_or(CommandState::Idle, |coupling| coupling.state_of(job))
    }
}

impl Coupling for Cam {
    fn update(&mut self, scan: &Scan) -> Step {
        let Some(master) = scan.masters.first() else {
            return Step::MasterLost;
        };
        let Some(PlatesMut { tables, coupling }) = self.plates_mut() else {
            return Step::Failed;
        };
        // Before the update: afterwards a refused coupling and one that ended are both idle.
        let waited = coupling.state() == CommandState::Waiting;
        let slave = coupling.update(tables, master);
        match coupling.state() {
            CommandState::Failed(_) => Step::Failed,
            // Refused first: a coupling given up has no error to report.
            CommandState::Idle if waited && self.refusal().is_some() => Step::Refused,
            CommandState::Idle if waited => Step::GivenUp,
            CommandState::Idle => Step::Ended(slave),
            _ => Step::Set(slave),
        }
    }

    fn phase(&self) -> Option<CouplingPhase> {
        match self.coupling.as_ref()?.state() {
            CommandState::Waiting => Some(CouplingPhase::Waiting),
            CommandState::Active => Some(CouplingPhase::Synchronizing),
            CommandState::InSync => Some(CouplingPhase::InSync),
            CommandState::Idle
            | CommandState::Done
            | CommandState::Aborted
            | CommandState::Failed(_) => None,
        }
    }

    fn end(&mut self) {
        if let Some(PlatesMut { tables, coupling }) = self.plates_mut() {
            coupling.end(tables);
        }
    }

    fn fail(&mut self, code: u32) {
        if let Some(PlatesMut { tables, coupling }) = self.plates_mut() {
            coupling.axis_error(tables, code);
        }
    }

    fn queued(&self) -> StateWord {
        let word = |plates: Plates<'_>| plates.coupling.state_word(plates.tables);
        self.plates().map_or(StateWord::empty(), word)
    }

    fn master_scaling(&self) -> f64 {
        // No plate of several stands for the coupling, and 1 is the master as it is.
        self.info(0, None).map_or(1.0, |info| info.master_scaling)
    }

    fn ended(&mut self) -> Option<Job> {
        self.coupling.as_mut()?.next_ended()
    }
}

/// Parameters of a coupling without plates, which can only refuse.
const NONE: CouplingParameters = CouplingParameters {
    master_axis_id: 0,
    slave_axis_id: 0,
    limits: CamLimits {
        // Any positive limits pass the check. Without plates no course is ever compared with them.
        velocity: 1.0,
        acceleration: 1.0,
        deceleration: 1.0,
        jerk: 1.0,
        cycle: 1.0,
    },
};
