//! An axis that is coupled from the start.

use coaxle_axis::drive::{Actual, DriveState};
use coaxle_axis::guard::{GuardFault, GuardRefusal};
use coaxle_axis::{CommandState, Engage, Job, Masters, Origin, Transition};
use coaxle_cam::{CamIn, Tables};
use coaxle_curve::profile::Kinematics;
use coaxle_gear::LinearGear;

use super::SlaveAxis;
use crate::couplings::{CouplingRefusal, Kind};
use crate::motion::Motion;
use crate::refusal::Refusal;

/// Coupling of an axis from the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoupledStart {
    /// A gear between the positions of master and slave.
    Gear(LinearGear),
    /// A plate. The slave starts at the plate's position.
    Cam(CamIn),
}

impl SlaveAxis {
    /// Switches on an axis that its mechanics have coupled to its first master already: it starts
    /// with the position and velocity of the coupling.
    ///
    /// # Errors
    /// [`Refusal`] if the axis has power, if the position or velocity is impossible or it could not
    /// stop before a software limit from there, or if the plate or the master does not exist.
    pub fn switch_on_coupled(
        &mut self,
        plates: &mut Tables,
        start: &CoupledStart,
        masters: impl Into<Masters>,
    ) -> Result<Job, Refusal> {
        let masters = masters.into();
        let master = masters.first().ok_or(Refusal::NoMaster)?;
        self.check_state("MC_Power", Transition::PowerOnCoupled)?;
        self.check_circle("MC_Power")?;
        let couplings = &mut self.couplings;
        let (job, kind, set) = match start {
            CoupledStart::Gear(gear) => {
                let job = self.jobs.number("MC_GearIn", Origin::Start);
                couplings.gear.apply(&mut (), &(*gear).into(), job);
                (job, Kind::Gear, gear.slave_of(master))
            }
            CoupledStart::Cam(cam_in) => {
                let change = couplings
                    .cam
                    .plan_on_plate(plates, cam_in, master)
                    .map_err(CouplingRefusal::Cam)?;
                let job = self.jobs.number(CamIn::NAME, Origin::Start);
                let set = couplings
                    .cam
                    .start_on_plate(plates, &change, job, master)
                    .map_err(CouplingRefusal::Cam)?;
                (job, Kind::Cam, set)
            }
        };
        // Checked after the coupling has its state, because only then the start is known. A refusal takes it back.
        if let Err(refusal) = self.check_start(&set) {
            self.couplings.end(kind, plates);
            return Err(refusal);
        }
        self.revision = self.revision.wrapping_add(1);
        if let Err(refusal) = self.power_on_moving(&set) {
            self.couplings.end(kind, plates);
            return Err(refusal);
        }
        self.powered = true;
        self.masters = masters;
        self.place(&self.startable(&set));
        // No cycle lies behind yet: the axis moves with its coupling.
        self.mean_velocity = set.velocity;
        // The way to the start is no motion of the axis.
        self.set_anew = self.set_anew.wrapping_add(1);
        self.motion = Motion::Coupled(kind);
        self.state.follow(Transition::PowerOnCoupled);
        self.jobs.replace(job, CommandState::Active);
        self.jobs.set(self.job_state());
        Ok(job)
    }

    /// Switches on a drive that the mechanics have at `set`. A drive elsewhere would have to jump.
    fn power_on_moving(&mut self, set: &Kinematics) -> Result<(), Refusal> {
        let in_drive = Kinematics {
            position: set.position - self.drive_zero,
            ..*set
        };
        let expected = self.drive.power_on_moving(&in_drive, self.hold_back);
        let Actual {
            state, position, ..
        } = *self.drive.actual();
        // A position that is up to a cycle old differs by this way at most.
        let cycle = self.guard.limits().velocity() * self.cycle_time;
        let is_there = (position - expected).abs() <= cycle;
        // At once: a drive that switches on later would be left behind by a coupling that moves.
        if state == DriveState::Following && is_there {
            return Ok(());
        }
        let received = self.actual_position();
        // Otherwise the drive would have power without a motion of the axis.
        self.drive.reset();
        self.drive.release();
        Err(Refusal::DriveElsewhere {
            received,
            expected: expected + self.drive_zero,
        })
    }

    /// A state within its limits from which a coupled axis can continue: the coupling may have any
    /// acceleration at this moment, and is caught up.
    fn startable(&self, set: &Kinematics) -> Kinematics {
        let limits = self.guard.limits();
        let most = limits.acceleration().max(limits.deceleration());
        self.guard.taken_over(&Kinematics {
            // Beyond its limit the axis would be led away until the jerk has brought the acceleration back.
            acceleration: set.acceleration.clamp(-most, most),
            ..*set
        })
    }

    fn check_start(&self, set: &Kinematics) -> Result<(), Refusal> {
        self.guard.check_target("position", set.position)?;
        self.guard.check_speed(set.velocity)?;
        match self.guard.check_stop(set.position, &self.startable(set)) {
            Err(GuardFault::SoftwareLimit { reached, limit }) => {
                Err(GuardRefusal::SoftwareLimit { reached, limit }.into())
            }
            _ => Ok(()),
        }
    }
}
