//! The course of a flying gear, calculated in advance.

use coaxle_curve::profile::{Kinematics, Limits};

use super::demands::SlaveDynamics;
use super::window::GearWindow;
use super::{FlyingGear, FlyingGearError};

/// The range of the master over which a flying gear is engaged or released, and its demands on the slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlyingGearRange {
    /// Position of the master when the slave stands, u.
    pub master_free: f64,
    /// Position of the master when the slave is fully coupled, u.
    pub master_coupled: f64,
    /// Position of the slave when it stands, u.
    pub slave_free: f64,
    /// Position of the slave when it is fully coupled, u.
    pub slave_coupled: f64,
    /// The slave's greatest |velocity|, u/s.
    pub velocity: f64,
    /// The slave's greatest |acceleration|, u/s². For a length of zero it is that of a step within a
    /// cycle.
    pub acceleration: f64,
    /// The slave's greatest |jerk|, u/s³.
    pub jerk: f64,
}

impl FlyingGear {
    /// Ranges of engaging and release, with a master of this speed, u/s, and this cycle time, s.
    #[must_use]
    pub fn ranges(&self, speed: f64, cycle: f64) -> [FlyingGearRange; 2] {
        [&self.engaging, &self.releasing].map(|window| self.range(window, speed.abs(), cycle))
    }

    /// Returns the direction of the master for engaging: 1 or -1.
    #[must_use]
    pub const fn master_direction(&self) -> f64 {
        self.master_direction
    }

    /// True if the release is on the way back, against the working direction.
    #[must_use]
    pub const fn returns(&self) -> bool {
        self.returns
    }

    /// Checks whether a slave can follow while its master runs at this speed, u/s, with this cycle time,
    /// s.
    ///
    /// # Errors
    /// [`FlyingGearError::TooFast`] with the greatest speed at which it can.
    pub fn check_limits(
        &self,
        limits: &Limits,
        speed: f64,
        cycle: f64,
    ) -> Result<(), FlyingGearError> {
        self.check_demands(&SlaveDynamics::of(limits), speed.abs(), cycle)
    }

    /// Returns the master's greatest speed at which a slave can follow, u/s.
    #[must_use]
    pub fn fastest(&self, limits: &Limits, cycle: f64) -> f64 {
        let dynamics = SlaveDynamics::of(limits);
        dynamics
            .fastest(&self.engaging, cycle)
            // Windows may differ in length, as in sample 3 of the
            // manual. The shorter one takes more acceleration.
            .min(dynamics.fastest(&self.releasing, cycle))
    }

    fn range(&self, window: &GearWindow, speed: f64, cycle: f64) -> FlyingGearRange {
        let [velocity, acceleration, jerk] = window.demands(speed, cycle);
        // Positions do not depend on the master's velocity, so any will do.
        let standing = Kinematics::default();
        let slave = |course| self.slave_of(&course, &standing).position;
        let master = |progress: f64| self.master_sync + self.master_direction * progress;
        FlyingGearRange {
            master_free: master(window.free_master()),
            master_coupled: master(window.coupled_master),
            slave_free: slave(window.freed()),
            slave_coupled: slave(window.rigid(window.coupled_master)),
            velocity,
            acceleration,
            jerk,
        }
    }
}
