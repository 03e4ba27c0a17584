//! A synchronisation over time that follows any motion of the master: as early as possible, and again
//! after the limits of the axis have left the slave behind.

use coaxle_curve::profile::{Kinematics, Profile};

use super::over_time::between;
use super::pursuit::LinePursuit;
use super::{SawCoupling, SawPhase};
use crate::SyncMask;
use crate::coupling_moment::EncoderNoise;
use crate::plan::SawPlan;
use crate::rollback::RollbackReaction;

impl SawCoupling {
    /// Begins to pursue the line, if the slave is not on it already.
    pub(super) fn start_pursuit(&mut self, plan: &SawPlan) {
        let Some(profile) = plan.time_profile() else {
            return self.become_synchronous();
        };
        self.phase = SawPhase::Early(self.pursuit_along(*profile, plan.master_start()));
    }

    /// Pursues the line from the position at which the limits have left the axis.
    pub(super) fn pursuit_from(&self, axis: &Kinematics) -> LinePursuit {
        let stop = self.command.chase(&self.axis, axis).stopping(axis);
        let mut pursuit = self.pursuit_along(stop, self.master_position);
        // The stop only is a valid profile until the next cycle plans the way back.
        pursuit.plan_again();
        pursuit
    }

    fn pursuit_along(&self, profile: Profile, master: f64) -> LinePursuit {
        let line = self.line.slave_of(&Kinematics {
            position: master,
            velocity: self.plan.master_velocity(),
            acceleration: 0.0,
        });
        let chase = self.command.chase(&self.axis, &self.slave);
        let start = self.plan.slave_start().position;
        LinePursuit::new(chase, self.command.range(&self.axis, start), profile, line)
    }

    pub(super) fn follow_line(&mut self, master: &Kinematics, before: f64, dt: f64) {
        let line = self.line.slave_of(&Kinematics {
            // An encoder's noise as an acceleration would lead every path to another place.
            acceleration: self.planned_acceleration(master),
            ..*master
        });
        let SawPhase::Early(pursuit) = &mut self.phase else {
            return;
        };
        let from = self.slave;
        // Before the check for a rollback, whose place within the cycle lies between the two set values.
        let next = pursuit.update(&from, &line, dt);
        if self.is_behind_start(master) {
            let reaction = RollbackReaction::of(self.command.mask(), false);
            let to = next.unwrap_or(line);
            return self.roll_back(reaction, master, before, dt, |_, part| {
                between(&from, &to, part, dt)
            });
        }
        match next {
            Some(slave) => self.apply_set_values(slave, master, dt),
            None => {
                self.become_synchronous();
                self.apply_set_values(self.line.slave_of(master), master, dt);
            }
        }
    }

    /// Returns the acceleration of the master, as used for planning.
    fn planned_acceleration(&self, master: &Kinematics) -> f64 {
        let is_noise =
            |encoder: EncoderNoise| master.acceleration.abs() < encoder.acceleration_threshold();
        let is_ignored = self.command.mask().contains(SyncMask::IGNORE_MASTER_ACC);
        if is_ignored || self.encoder.is_some_and(is_noise) {
            0.0
        } else {
            master.acceleration
        }
    }
}
