//! The cam plates of a slave axis, and its coupling by them.

use crate::{
    CamCoupling, CamIn, Command, CouplingError, CouplingParameters, CouplingState, JumpHandling,
    OnlineChangeMode, TableId, Tables, Ticket,
};
use coaxle_axis::{CommandState, CouplingPhase, StateWord};
use coaxle_curve::profile::Kinematics;
use coaxle_plate::MotionPoint;

/// The plates, and the coupling; it is idle as long as something else moves the axis.
#[derive(Debug)]
pub struct Cams {
    tables: Tables,
    coupling: CamCoupling,
    /// The command that coupled the axis.
    first: Option<Ticket>,
}

impl Cams {
    /// No plates. `jump_limit` is how far the axis can go in a cycle, u: above 0.
    ///
    /// # Panics
    /// With another jump limit.
    #[must_use]
    pub fn none(jump_limit: f64) -> Self {
        Self {
            tables: Tables::new(0),
            coupling: coupling(0, 0, jump_limit),
            first: None,
        }
    }

    /// `MC_CamTableSelect`: other plates, with the ids of master and slave for `MC_CamInfo`. Any coupling
    /// has ended.
    ///
    /// # Panics
    /// With a jump limit that is not above 0.
    pub fn select(&mut self, tables: Tables, [master, slave]: [u32; 2], jump_limit: f64) {
        self.tables = tables;
        self.coupling = coupling(master, slave, jump_limit);
        self.first = None;
    }

    /// A command to an axis that is coupled by plates, or shall be.
    ///
    /// # Errors
    /// [`CouplingError`]; the coupling is as it was.
    pub fn start(
        &mut self,
        is_coupled: bool,
        command: &Command,
        master: &Kinematics,
        slave: &Kinematics,
    ) -> Result<Ticket, CouplingError> {
        if !is_coupled {
            // One that broke off was kept to be asked about.
            self.end();
        }
        let ticket = self
            .coupling
            .start(&mut self.tables, command, master, slave)?;
        if !is_coupled {
            self.first = Some(ticket);
        }
        Ok(ticket)
    }

    /// Couples an axis that has always been where the plate puts it.
    ///
    /// # Errors
    /// [`CouplingError`]: there is no such plate.
    pub fn start_on_plate(
        &mut self,
        cam_in: &CamIn,
        master: &Kinematics,
    ) -> Result<Kinematics, CouplingError> {
        let command = Command::CamIn(CamIn {
            jump: JumpHandling::Allow,
            ..*cam_in
        });
        let ticket = self.start(false, &command, master, &Kinematics::default())?;
        let slave = self.coupling.update(&mut self.tables, master);
        match self.coupling.state_of(ticket) {
            CommandState::Failed(error) => Err(error),
            _ => Ok(slave),
        }
    }

    /// The slave's set values for the master's.
    ///
    /// # Errors
    /// [`CouplingError`]: the coupling broke off.
    pub fn update(&mut self, master: &Kinematics) -> Result<Kinematics, CouplingError> {
        let slave = self.coupling.update(&mut self.tables, master);
        match self.coupling.state() {
            CommandState::Failed(error) => Err(error),
            _ => Ok(slave),
        }
    }

    /// How far the coupling is; none once it is over.
    #[must_use]
    pub fn phase(&self) -> Option<CouplingPhase> {
        match self.coupling.state() {
            CommandState::Waiting => Some(CouplingPhase::Waiting),
            CommandState::Active => Some(CouplingPhase::Synchronizing),
            CommandState::InSync => Some(CouplingPhase::InSync),
            CommandState::Idle
            | CommandState::Done
            | CommandState::Aborted
            | CommandState::Failed(_) => None,
        }
    }

    /// Why the command that coupled the axis failed, if it did.
    #[must_use]
    pub fn failure(&self) -> Option<CouplingError> {
        match self.coupling.state_of(self.first?) {
            CommandState::Failed(error) => Some(error),
            _ => None,
        }
    }

    /// Something else moves the axis from now on.
    pub fn end(&mut self) {
        if self.coupling.state() != CommandState::Idle {
            let at = Kinematics::default();
            // It cannot be refused to a coupling that is not idle.
            let _ = self
                .coupling
                .start(&mut self.tables, &Command::CamOut, &at, &at);
        }
    }

    /// The axis has an error. What the coupling was can still be asked about.
    pub fn break_off(&mut self, code: u32) {
        self.coupling.axis_error(&mut self.tables, code);
    }

    /// `MC_SetCamOnlineChangeMode`.
    ///
    /// # Errors
    /// [`CouplingError`].
    pub fn set_mode(
        &mut self,
        table: TableId,
        mode: OnlineChangeMode,
    ) -> Result<(), CouplingError> {
        self.tables.set_online_change_mode(table, mode)
    }

    /// `MC_WriteMotionFunction`.
    ///
    /// # Errors
    /// [`CouplingError`].
    pub fn write(&mut self, table: TableId, points: &[MotionPoint]) -> Result<(), CouplingError> {
        self.tables.write(table, points)
    }

    /// How far a command is.
    #[must_use]
    pub fn state_of(&self, ticket: Ticket) -> CouplingState {
        self.coupling.state_of(ticket)
    }

    /// The bits of `nStateDWord` for what waits.
    #[must_use]
    pub fn state_word(&self) -> StateWord {
        self.coupling.state_word(&self.tables)
    }

    /// The plates.
    #[must_use]
    pub const fn tables(&self) -> &Tables {
        &self.tables
    }

    /// The coupling.
    #[must_use]
    pub const fn coupling(&self) -> &CamCoupling {
        &self.coupling
    }
}

fn coupling(master_axis_id: u32, slave_axis_id: u32, jump_limit: f64) -> CamCoupling {
    CamCoupling::new(CouplingParameters {
        master_axis_id,
        slave_axis_id,
        jump_limit,
    })
    .expect("the limits of an axis are finite and above 0")
}
