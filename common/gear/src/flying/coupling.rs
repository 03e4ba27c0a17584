//! The flying gear as a coupling of a slave axis.

use coaxle_axis::{
    Awaits, Coupling, CouplingEffect, CouplingPhase, Engage, Job, NoFault, NotPlanned, PlanInputs,
    Planned, Scan, Step, SyncPositions,
};
use coaxle_curve::profile::Kinematics;

use super::{FlyingGear, FlyingGearError, FlyingGearParameters, FlyingGearPhase, SlaveDynamics};

/// The coupling by a [`FlyingGear`].
///
/// A gear is refused if its demands on the slave's velocity, acceleration or jerk exceed its limits at
/// the speed of the master: at the command, and again when engaging begins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlyingGearCoupling {
    state: FlyingGearState,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum FlyingGearState {
    #[default]
    Idle,
    Enabled(FlyingGearChange),
    /// Refusal when engaging begins.
    Refused(FlyingGearError),
}

/// Change by a command to a flying gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingGearChange {
    gear: FlyingGear,
    dynamics: SlaveDynamics,
}

impl Engage for FlyingGearCoupling {
    type Command = FlyingGearParameters;
    type Change = FlyingGearChange;
    type Refusal = FlyingGearError;
    type Fault = NoFault;
    type Shared = ();

    fn plan(
        &self,
        (): &(),
        command: &FlyingGearParameters,
        inputs: &PlanInputs,
    ) -> Result<Planned<FlyingGearChange>, NotPlanned<FlyingGearError>> {
        let master = inputs.master()?;
        // The slope begins at 0, so a slave in motion would be stopped within a cycle.
        inputs.check_rest()?;
        let gear =
            FlyingGear::enable(command, master, inputs.slave.position).map_err(NotPlanned::Own)?;
        // A slave released on the way back turns where its master does, which no
        // plan can know. Its software limits are then kept by the guard of the axis.
        for (field, position) in [
            ("slave-sync-position", command.slave_sync_position),
            ("slave-desync-position", command.slave_desync_position),
            ("slave-stop-position", command.slave_stop_position),
        ] {
            inputs.guard.check_target(field, position)?;
        }
        // Kept with the change: when the gear is due, limits are not among the inputs of a cycle.
        let dynamics = SlaveDynamics::of(inputs.guard.limits());
        gear.check_demands(&dynamics, master.velocity.abs(), inputs.cycle.0)
            .map_err(NotPlanned::Own)?;
        Ok(Planned {
            change: FlyingGearChange { gear, dynamics },
            // The master may be slow now and fast where engaging begins.
            awaits: Awaits::LIMITS,
            effect: CouplingEffect::Engage,
        })
    }

    fn apply(&mut self, (): &mut (), change: &FlyingGearChange, _: Job) {
        self.state = FlyingGearState::Enabled(*change);
    }

    fn update(&mut self, (): &mut (), scan: &Scan) -> Step {
        let Some(master) = scan.masters.first() else {
            return Step::MasterLost;
        };
        let FlyingGearState::Enabled(change) = &mut self.state else {
            return Step::Failed;
        };
        match change.update(master, scan.elapsed.0) {
            Ok(slave) => Step::Set(slave),
            Err(refusal) => {
                self.state = FlyingGearState::Refused(refusal);
                Step::Refused
            }
        }
    }

    fn end(&mut self, (): &mut ()) {
        self.state = FlyingGearState::Idle;
    }

    fn refusal(&self) -> Option<FlyingGearError> {
        match self.state {
            FlyingGearState::Refused(refusal) => Some(refusal),
            FlyingGearState::Idle | FlyingGearState::Enabled(_) => None,
        }
    }
}

impl Coupling for FlyingGearCoupling {
    fn phase(&self) -> Option<CouplingPhase> {
        Some(self.gear()?.phase().into())
    }

    fn gain(&self) -> Option<f64> {
        let gear = self.gear()?;
        // In the windows the slope changes with the master, so there is no constant gain.
        (gear.phase() == FlyingGearPhase::Engaged).then(|| gear.ratio())
    }

    fn sync_positions(&self) -> Option<SyncPositions> {
        Some(self.gear()?.sync_positions())
    }
}

impl FlyingGearCoupling {
    const fn gear(&self) -> Option<&FlyingGear> {
        match &self.state {
            FlyingGearState::Enabled(change) => Some(&change.gear),
            FlyingGearState::Idle | FlyingGearState::Refused(_) => None,
        }
    }
}

impl FlyingGearChange {
    /// Returns the positions of master and slave at which the gear is fully engaged.
    #[must_use]
    pub const fn sync_positions(&self) -> SyncPositions {
        self.gear.sync_positions()
    }

    /// Computes one cycle. When engaging begins, the master may have become too fast.
    fn update(&mut self, master: &Kinematics, cycle: f64) -> Result<Kinematics, FlyingGearError> {
        let waited = self.gear.phase() == FlyingGearPhase::Waiting;
        // Only the update shows whether the window is reached. After a
        // refusal its set values are not used, so the slave still stands.
        let slave = self.gear.update(master);
        if waited && self.gear.phase() != FlyingGearPhase::Waiting {
            let speed = master.velocity.abs();
            self.gear.check_demands(&self.dynamics, speed, cycle)?;
        }
        Ok(slave)
    }
}
