//! Time-based: the slave's own path to the velocity of its gear.

use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_curve::ramp::Ramp;

use super::{SawCoupling, SawPhase};
use crate::rollback::RollbackReaction;

impl SawCoupling {
    /// Computes one cycle of the profile over time, as long as the master has the planned velocity.
    pub(super) fn over_time(&mut self, master: &Kinematics, before: f64, dt: f64) {
        let SawPhase::OverTime { profile, since } = &mut self.phase else {
            return;
        };
        let target = self.line.ratio * master.velocity;
        let foreseen = profile.end().velocity;
        // Exactly: any other velocity needs another profile, and the ramp follows without one.
        if foreseen != target {
            let ramp = Ramp::new(&self.slave, foreseen, self.limits);
            return self.chase(ramp, master, before, dt);
        }
        // A master that passes the coupling position does so
        // within the cycle: the slave then is on the profile.
        let began = *since;
        *since += dt;
        let (profile, since) = (*profile, *since);
        if self.is_behind_start(master) {
            let reaction = RollbackReaction::of(self.command.mask(), false);
            return self.roll_back(reaction, master, before, dt, |_, part| {
                profile.at(Seconds(began + part * dt))
            });
        }
        let slave = profile.at(Seconds(since));
        if since >= profile.duration().0 {
            self.anchor(&slave, master);
        }
        self.apply_set_values(slave, master, dt);
    }

    /// Chases a master whose velocity changes, cycle by cycle: a profile planned for any of its
    /// velocities would be out of date before it ends.
    pub(super) fn chase(&mut self, mut ramp: Ramp, master: &Kinematics, before: f64, dt: f64) {
        let gear = self.line.slave_of(master);
        // Before the ramp, whose state NaN would spoil for good.
        if !gear.velocity.is_finite() {
            return self.fail_at_limit(&gear, master, dt);
        }
        let last = self.slave;
        // From the velocities of the master. Its stated acceleration only bridges a jump of them.
        ramp.step(gear.velocity, gear.acceleration, dt);
        self.phase = SawPhase::Chasing(ramp);
        if self.is_behind_start(master) {
            let reaction = RollbackReaction::of(self.command.mask(), false);
            return self.roll_back(reaction, master, before, dt, |_, part| {
                between(&last, ramp.slave(), part, dt)
            });
        }
        if ramp.is_there() {
            self.anchor(ramp.slave(), master);
        }
        self.apply_set_values(*ramp.slave(), master, dt);
    }

    /// Anchors the gear at the slave's position once it has the gear's velocity: from here on the gear
    /// leads it.
    fn anchor(&mut self, slave: &Kinematics, master: &Kinematics) {
        // Both of the same cycle, so that rounding of a duration is no step at the joint.
        self.line.master = master.position;
        self.line.slave = slave.position;
        self.become_synchronous();
    }
}

/// Returns the set values at a part of a cycle of constant jerk.
pub(super) fn between(from: &Kinematics, to: &Kinematics, part: f64, dt: f64) -> Kinematics {
    let jerk = (to.acceleration - from.acceleration) / dt;
    let t = part * dt;
    Kinematics {
        position: from.position
            + t * (from.velocity + t * (from.acceleration / 2.0 + t * jerk / 6.0)),
        velocity: from.velocity + t * (from.acceleration + t * jerk / 2.0),
        acceleration: from.acceleration + t * jerk,
    }
}
