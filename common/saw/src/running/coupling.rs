//! The flying saw as a coupling of a slave axis.

use coaxle_axis::guard::ROUNDING;
use coaxle_axis::{
    Awaits, CommandState, Coupling, CouplingEffect, CouplingPhase, Engage, Job, NotPlanned,
    PlanInputs, Planned, Scan, Step, SyncPositions,
};
use coaxle_curve::profile::Kinematics;

use super::{SawCommand, SawCoupling, SawFault, SawTolerances};
use crate::coupling_moment::{CouplingMoment, EncoderNoise, LimitGuard, SlaveLimits};
use crate::plan::SawPlan;
use crate::refusal::SawRefusal;
use crate::rollback::RollbackReaction;

/// Part of velocity, acceleration and deceleration that a synchronisation reserves for the ripple of a
/// master, where its command names no limit. The axis keeps its limits with both together, or goes to
/// error stop.
// A ripple of the master by 1 % of its velocity then is within the slave's limit: 0.99 · 1.01 < 1.
const RESERVE: f64 = 0.01;

/// The coupling of a slave axis by flying saws, one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Saw {
    master_noise: f64,
    master_increment: Option<f64>,
    /// The saw that moves the slave, or did so last.
    saw: Option<SawCoupling>,
    moves: bool,
}

impl Saw {
    /// Makes a saw whose master may run back by `master_noise` before that counts as a rollback, u. An
    /// encoder has `master_increment` u per increment.
    #[must_use]
    pub const fn new(master_noise: f64, master_increment: Option<f64>) -> Self {
        Self {
            master_noise,
            master_increment,
            saw: None,
            moves: false,
        }
    }

    /// Returns the plan of the saw that couples the slave; while it waits, the predicted plan. Without
    /// one, that of the last saw.
    #[must_use]
    pub const fn plan_in_force(&self) -> Option<&SawPlan> {
        match &self.saw {
            Some(saw) => Some(saw.plan()),
            None => None,
        }
    }

    /// Returns the moment from which a saw is planned.
    #[must_use]
    pub fn moment(&self, master: &Kinematics, inputs: &PlanInputs) -> CouplingMoment {
        let (min_position, max_position) = inputs.guard.software_limits();
        let encoder = |scaling| EncoderNoise {
            scaling,
            cycle: inputs.cycle,
        };
        CouplingMoment {
            master: *master,
            encoder: self.master_increment.map(encoder),
            slave: inputs.slave,
            axis: SlaveLimits {
                dynamics: *inputs.guard.limits(),
                min_position,
                max_position,
                guard: Some(LimitGuard { reserve: RESERVE }),
            },
        }
    }
}

impl Engage for Saw {
    type Command = SawCommand;
    type Change = SawCoupling;
    type Refusal = SawRefusal;
    type Fault = SawFault;
    type Shared = ();

    fn plan(
        &self,
        (): &(),
        command: &SawCommand,
        inputs: &PlanInputs,
    ) -> Result<Planned<SawCoupling>, NotPlanned<SawRefusal>> {
        let moment = self.moment(inputs.master()?, inputs);
        // The axis monitors its limits itself.
        let tolerances = SawTolerances {
            master_noise: self.master_noise,
            velocity_margin: ROUNDING,
        };
        let saw = SawCoupling::start(*command, &moment, tolerances).map_err(NotPlanned::Own)?;
        // While it waits, the master may become too fast for the plan.
        let awaits = match saw.state() {
            CommandState::Waiting => Awaits::LIMITS,
            _ => Awaits::empty(),
        };
        Ok(Planned {
            change: saw,
            awaits,
            effect: CouplingEffect::Engage,
        })
    }

    fn apply(&mut self, (): &mut (), change: &SawCoupling, _: Job) {
        self.saw = Some(*change);
        self.moves = true;
    }

    fn update(&mut self, (): &mut (), scan: &Scan) -> Step {
        let Some(saw) = &mut self.saw else {
            return Step::Failed;
        };
        let was_stopping = saw.rollback_stop().is_some();
        let master = match scan.masters.first() {
            Some(master) => *master,
            // The stop does not need one any more.
            None if was_stopping => Kinematics::default(),
            None => return Step::MasterLost,
        };
        saw.set_master_travel(scan.masters.travel(0));
        // Before the update, which otherwise continues a plan that the axis is not on.
        if let Some(axis) = &scan.left_behind {
            saw.resume_from(axis);
        }
        let set = saw.update(&master, scan.elapsed);
        match *saw.state() {
            // A refusal at the end of the wait is no fault: the slave continues its motion.
            CommandState::Failed(SawFault::Refused(_)) => return Step::Refused,
            CommandState::Failed(_) => return Step::Failed,
            _ => {}
        }
        match saw.rollback_stop() {
            None => Step::Set(set),
            Some((stop, since)) => Step::Stopping {
                set,
                // In the first cycle only: the guard of the axis drops its limits for that one step.
                instant: !was_stopping && saw.rollback() == Some(RollbackReaction::Instant),
                over: since >= stop.duration(),
            },
        }
    }

    fn end(&mut self, (): &mut ()) {
        self.moves = false;
    }

    fn refusal(&self) -> Option<SawRefusal> {
        match self.fault()? {
            SawFault::Refused(refusal) => Some(refusal),
            _ => None,
        }
    }

    fn fault(&self) -> Option<SawFault> {
        match self.saw.as_ref()?.state() {
            CommandState::Failed(fault) => Some(*fault),
            _ => None,
        }
    }
}

impl Coupling for Saw {
    fn sync_positions(&self) -> Option<SyncPositions> {
        // The last plan stays readable, but its positions are no longer those of a coupling.
        let plan = self.plan_in_force().filter(|_| self.moves)?;
        Some(plan.line().sync_positions())
    }

    fn phase(&self) -> Option<CouplingPhase> {
        if !self.moves {
            return None;
        }
        let saw = self.saw.as_ref()?;
        match (saw.state(), saw.is_past_sync_position()) {
            (CommandState::Waiting, _) => Some(CouplingPhase::Waiting),
            (CommandState::Active, Some(true)) => {
                Some(CouplingPhase::SynchronizingAfterSyncPosition)
            }
            (CommandState::Active, _) => Some(CouplingPhase::Synchronizing),
            (CommandState::InSync, Some(false)) => Some(CouplingPhase::InSyncBeforeSyncPosition),
            (CommandState::InSync, _) => Some(CouplingPhase::InSync),
            _ => None,
        }
    }

    fn gain(&self) -> Option<f64> {
        let saw = self.saw.as_ref().filter(|_| self.moves)?;
        let in_sync = *saw.state() == CommandState::InSync;
        // On the profile the slope changes with the master, so there is no constant gain.
        in_sync.then(|| saw.plan().line().ratio)
    }

    fn target(&self) -> Option<f64> {
        let (stop, _) = self.saw.as_ref().filter(|_| self.moves)?.rollback_stop()?;
        Some(stop.end_position())
    }
}
