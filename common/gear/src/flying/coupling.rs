//! The flying gear as a coupling of a slave axis.

use coaxle_axis::{
    Awaits, Coupling, CouplingPhase, Engage, Job, Manner, NoFault, NotPlanned, PlanInputs, Planned,
    Scan, Step,
};

use super::{FlyingGear, FlyingGearError, FlyingGearParameters, FlyingGearPhase};

/// The coupling by a [`FlyingGear`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlyingGearCoupling {
    gear: Option<FlyingGear>,
}

impl Engage for FlyingGearCoupling {
    type Command = FlyingGearParameters;
    type Change = FlyingGear;
    type Refusal = FlyingGearError;
    type Fault = NoFault;

    fn plan(
        &self,
        command: &FlyingGearParameters,
        inputs: &PlanInputs,
    ) -> Result<Planned<FlyingGear>, NotPlanned<FlyingGearError>> {
        let master = inputs.master()?;
        inputs.check_rest()?;
        let gear =
            FlyingGear::enable(command, master, inputs.slave.position).map_err(NotPlanned::Own)?;
        Ok(Planned {
            change: gear,
            awaits: Awaits::empty(),
            manner: Manner::Engage,
        })
    }

    fn apply(&mut self, change: &FlyingGear, _: Job) {
        self.gear = Some(*change);
    }
}

impl Coupling for FlyingGearCoupling {
    fn update(&mut self, scan: &Scan) -> Step {
        match (&mut self.gear, scan.masters.first()) {
            (_, None) => Step::MasterLost,
            (None, _) => Step::Failed,
            (Some(gear), Some(master)) => Step::Set(gear.update(master)),
        }
    }

    fn phase(&self) -> Option<CouplingPhase> {
        Some(self.gear?.phase().into())
    }

    fn end(&mut self) {
        self.gear = None;
    }

    fn gain(&self) -> Option<f64> {
        let gear = self.gear?;
        (gear.phase() == FlyingGearPhase::Engaged).then(|| gear.ratio())
    }
}
