//! The coupling of a slave axis by cam plates.

use alloc::boxed::Box;

use crate::{
    CamChange, CamCoupling, CamIn, CamInfo, CamLimits, CamRequest, CamState, CouplingError,
    CouplingParameters, CouplingState, JumpHandling, TableId, Tables,
};
use coaxle_axis::{
    CommandState, Coupling, CouplingEffect, CouplingPhase, Engage, Job, MasterDemands, NotPlanned,
    PlanInputs, Planned, Scan, StateWord, Step,
};
use coaxle_curve::profile::Kinematics;

/// The coupling of an axis by cam plates, which is idle as long as something else moves the axis.
///
/// The plates are those of its node: always the same store of [`Tables`] is passed to it, so that nothing
/// is locked or copied. Before it is [prepared](Self::prepare) it can only refuse, and takes next to no
/// memory.
#[derive(Debug, Default)]
pub struct Cam {
    coupling: Option<Box<CamCoupling>>,
}

impl Cam {
    /// Prepares the coupling of a slave with these limits, with the ids of master and slave for
    /// `MC_CamInfo`. Any coupling has ended. Allocates.
    ///
    /// # Errors
    /// 0x4A1C if the limits are not finite numbers above 0.
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

    /// Plans the coupling of an axis that has always been on the plate.
    ///
    /// # Errors
    /// [`CouplingError`]: the plate does not exist.
    pub fn plan_on_plate(
        &self,
        tables: &Tables,
        cam_in: &CamIn,
        master: &Kinematics,
    ) -> Result<CamChange, CouplingError> {
        let request = CamRequest::from(CamIn {
            // The axis is put onto the plate, so there is no course before it to jump from.
            jump: JumpHandling::Allow,
            ..*cam_in
        });
        let slave = Kinematics::default();
        self.ask(|coupling| coupling.plan(tables, &request, master, &slave))
    }

    /// Couples the axis like this, and returns its position on the plate.
    ///
    /// # Errors
    /// [`CouplingError`]: the plate has no position for it.
    pub fn start_on_plate(
        &mut self,
        tables: &mut Tables,
        change: &CamChange,
        job: Job,
        master: &Kinematics,
    ) -> Result<Kinematics, CouplingError> {
        let Some(coupling) = &mut self.coupling else {
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

    /// Returns the state of the coupling for every cycle, at low cost: [`CamCoupling::cam_state`].
    #[must_use]
    pub fn cam_state(&self, tables: &Tables) -> Option<CamState> {
        self.coupling.as_ref()?.cam_state(tables)
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
    pub fn info(
        &self,
        tables: &Tables,
        table: TableId,
        at: Option<f64>,
    ) -> Result<CamInfo, CouplingError> {
        self.ask(|coupling| coupling.info(tables, table, at))
    }

    fn ask<T>(
        &self,
        ask: impl FnOnce(&CamCoupling) -> Result<T, CouplingError>,
    ) -> Result<T, CouplingError> {
        match &self.coupling {
            Some(coupling) => ask(coupling),
            None => ask(&CamCoupling::new(NONE)?),
        }
    }
}

fn plan(
    coupling: &CamCoupling,
    tables: &Tables,
    command: &CamRequest,
    inputs: &PlanInputs,
) -> Result<CamChange, CouplingError> {
    let (master, slave) = (inputs.masters.first(), &inputs.slave);
    let master = master.ok_or(CouplingError::AxisError { code: 0 })?;
    if inputs.is_engaged || coupling.state() == CommandState::Idle {
        return coupling.plan(tables, command, master, slave);
    }
    // A coupling that ended with an error is kept for `MC_CamInfo` until another begins.
    CamCoupling::new(*coupling.parameters())?.plan(tables, command, master, slave)
}

impl Engage for Cam {
    type Command = CamRequest;
    type Change = CamChange;
    type Refusal = CouplingError;
    type Fault = CouplingError;
    type Shared = Tables;

    fn plan(
        &self,
        tables: &Tables,
        command: &CamRequest,
        inputs: &PlanInputs,
    ) -> Result<Planned<CamChange>, NotPlanned<CouplingError>> {
        inputs.master()?;
        let change = self
            .ask(|coupling| plan(coupling, tables, command, inputs))
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

    fn apply(&mut self, tables: &mut Tables, change: &CamChange, job: Job) {
        if let Some(coupling) = &mut self.coupling {
            coupling.apply(tables, change, job);
        }
    }

    fn update(&mut self, tables: &mut Tables, scan: &Scan) -> Step {
        let Some(master) = scan.masters.first() else {
            return Step::MasterLost;
        };
        let Some(coupling) = &mut self.coupling else {
            return Step::Failed;
        };
        let waited = coupling.state() == CommandState::Waiting;
        let slave = coupling.update(tables, master);
        match coupling.state() {
            CommandState::Failed(_) => Step::Failed,
            CommandState::Idle if waited && self.refusal().is_some() => Step::Refused,
            CommandState::Idle if waited => Step::GivenUp,
            CommandState::Idle => Step::Ended(slave),
            _ => Step::Set(slave),
        }
    }

    fn end(&mut self, tables: &mut Tables) {
        if let Some(coupling) = &mut self.coupling {
            coupling.end(tables);
        }
    }

    fn fail(&mut self, tables: &mut Tables, code: u32) {
        if let Some(coupling) = &mut self.coupling {
            coupling.axis_error(tables, code);
        }
    }

    fn queued(&self, tables: &Tables) -> StateWord {
        let word = |coupling: &CamCoupling| coupling.state_word(tables);
        (self.coupling.as_deref()).map_or(StateWord::empty(), word)
    }

    fn master_scaling(&self, tables: &Tables) -> f64 {
        self.info(tables, 0, None)
            .map_or(1.0, |info| info.master_scaling)
    }

    fn demands_of(&self, tables: &Tables, master: usize) -> MasterDemands {
        let coupling = self.coupling.as_ref().filter(|_| master == 0);
        coupling.map_or(MasterDemands::default(), |coupling| {
            coupling.demands(tables)
        })
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

    fn ended(&mut self) -> Option<Job> {
        self.coupling.as_mut()?.next_ended()
    }
}

/// Parameters of a coupling that was not prepared, which can only refuse.
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
