//! An axis that is coupled from the start.

use coaxle_axis::{CommandState, Transition};
use coaxle_cam::CamIn;
use coaxle_curve::profile::Kinematics;
use coaxle_gear::LinearGear;

use super::{Accepted, SlaveAxis};
use crate::coupling::Coupling;
use crate::motion::Motion;
use crate::refusal::Refusal;

/// What an axis is coupled by from the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CoupledStart {
    /// A gear between the positions of master and slave.
    Gear(LinearGear),
    /// A plate. The slave is where it puts it.
    Cam(CamIn),
}

impl SlaveAxis {
    /// Gives power to an axis that is coupled to its master already, as the mechanics had it: it is
    /// where the coupling puts it, and moves so.
    ///
    /// # Errors
    /// [`Refusal`] if the axis has power, cannot be there or cannot be so fast, or if there is no
    /// such plate.
    pub fn switch_on_coupled(
        &mut self,
        start: &CoupledStart,
        master: &Kinematics,
    ) -> Result<Accepted, Refusal> {
        self.check_state("MC_Power", Transition::PowerOnCoupled)?;
        let (set, coupling) = match start {
            CoupledStart::Gear(gear) => (gear.slave_of(master), Coupling::Linear(*gear)),
            CoupledStart::Cam(cam_in) => (self.cams.start_on_plate(cam_in, master)?, Coupling::Cam),
        };
        if let Err(refusal) = self.check_start(&set) {
            self.cams.end();
            return Err(refusal);
        }
        self.drive
            .power_on(set.position - self.drive_zero, set.velocity);
        self.powered = true;
        self.master = Some(*master);
        self.set = set;
        self.motion = Motion::Coupled(coupling);
        self.state.follow(Transition::PowerOnCoupled);
        let number = self.job.replace(CommandState::Active);
        self.job.set(self.job_state());
        Ok(Accepted::Job(number))
    }

    fn check_start(&self, set: &Kinematics) -> Result<(), Refusal> {
        self.guard.check_target("position", set.position)?;
        self.guard.check_speed(set.velocity)?;
        Ok(())
    }
}
