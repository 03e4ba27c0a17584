//! A synchronisation as early as possible: over time, whatever the master does.

use coaxle_curve::profile::Kinematics;

use super::pursuit::Pursuit;
use super::{Phase, SawCoupling};
use crate::SyncMask;
use crate::moment::EncoderMaster;
use crate::plan::SawPlan;

impl SawCoupling {
    /// Begins to pursue the line, if the slave is not there already.
    pub(super) fn set_out(&mut self, plan: &SawPlan) {
        let Some(profile) = plan.time_profile() else {
            return self.become_synchronous();
        };
        let line = self.line.slave_of(&Kinematics {
            position: plan.master_start(),
            velocity: plan.master_velocity(),
            acceleration: 0.0,
        });
        let chase = self.command.chase(&self.axis, &self.slave);
        self.phase = Phase::Early(Pursuit::new(chase, *profile, line));
    }

    pub(super) fn pursue(&mut self, master: &Kinematics, dt: f64) {
        let line = self.line.slave_of(&Kinematics {
            acceleration: self.planned_acceleration(master),
            ..*master
        });
        let Phase::Early(pursuit) = &mut self.phase else {
            return;
        };
        match pursuit.update(&self.slave, &line, dt) {
            Some(slave) => self.lead_to(slave, master, dt),
            None => {
                self.become_synchronous();
                self.lead_to(self.line.slave_of(master), master, dt);
            }
        }
    }

    /// The master's acceleration as planning sees it.
    fn planned_acceleration(&self, master: &Kinematics) -> f64 {
        let is_noise =
            |encoder: EncoderMaster| master.acceleration.abs() < encoder.acceleration_threshold();
        let is_ignored = self.command.mask().contains(SyncMask::IGNORE_MASTER_ACC);
        if is_ignored || self.encoder.is_some_and(is_noise) {
            0.0
        } else {
            master.acceleration
        }
    }
}
