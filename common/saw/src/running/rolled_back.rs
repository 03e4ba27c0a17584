//! A master that runs back past the position at which it was coupled.

use coaxle_axis::{CommandState, TravelDirection};
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;

use super::{RollbackReaction, RollbackStop, SawCoupling, SawPhase};

/// Part of the greatest change of acceleration in a cycle that counts as none.
// Below it, dropping the acceleration is a jerk of 5 % of the limit.
const NEGLIGIBLE_STEP: f64 = 0.05;

impl SawCoupling {
    /// True if the master has run back past the coupling position.
    #[inline]
    pub(super) fn is_behind_start(&self, master: &Kinematics) -> bool {
        master.position * self.direction < self.farthest_back && !self.continues_in_direction()
    }

    /// True if the increments of the master still continue in its direction.
    fn continues_in_direction(&self) -> bool {
        let forward = |travel: TravelDirection| travel.sign() * self.direction > 0.0;
        self.travel.is_some_and(forward)
    }

    /// Stops the slave from the place where its master passed the coupling position within this cycle;
    /// `slave_of` returns the slave then, from the master and the part of the cycle.
    #[cold]
    pub(super) fn roll_back(
        &mut self,
        reaction: RollbackReaction,
        master: &Kinematics,
        before: f64,
        dt: f64,
        slave_of: impl FnOnce(&Kinematics, f64) -> Kinematics,
    ) {
        let limit = self.direction * self.farthest_back;
        // Within the cycle: at its end the master is up to 0.5 mm past it, at 500 mm/s and 1 ms.
        let part = match master.position - before {
            // Only its direction of travel turned: it was past the position before this cycle.
            0.0 => 0.0,
            gone => ((limit - before) / gone).clamp(0.0, 1.0),
        };
        let master_at_limit = Kinematics {
            position: limit,
            ..*master
        };
        let mut slave = slave_of(&master_at_limit, part);
        // A master that jumps back can drag the slave to that place faster than its limit.
        if !self.limit_monitor.is_within_limits(&slave) {
            return self.fail_at_limit(&slave, master, dt);
        }
        if reaction == RollbackReaction::Instant {
            // Cases 3, 7 and 8: the stop planned below then has no velocity to lead to zero.
            slave = Kinematics::at_rest(slave.position);
        }
        let accelerates = |slave: &Kinematics| {
            slave.acceleration.abs()
                > NEGLIGIBLE_STEP * self.limits.binding_in_cycles(dt).jerk() * dt
        };
        let (stop, since) = if accelerates(&slave) {
            // The mean velocity does not show when exactly the master passed.
            let stop = RollbackStop::from_acceleration(&self.slave, &self.limits);
            (stop, dt)
        } else {
            let (deceleration, jerk) = (self.limits.deceleration(), self.limits.jerk());
            let stop = RollbackStop::plan(&slave, deceleration, jerk);
            (stop, (1.0 - part) * dt)
        };
        // The rest of this cycle belongs to the stop.
        let next = stop.at(Seconds(since));
        if !self
            .limit_monitor
            .is_step_within_limits(&self.slave, &next, dt)
        {
            return self.fail_at_limit(&next, master, dt);
        }
        self.slave = next;
        self.phase = SawPhase::RollbackStop { stop, since };
        self.state = CommandState::Aborted;
        self.rollback = Some(reaction);
    }
}
