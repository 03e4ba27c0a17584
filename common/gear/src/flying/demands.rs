//! Demands of the windows of a flying gear on the slave.

use coaxle_curve::law::Quantity;
use coaxle_curve::profile::Limits;

use super::error::FlyingGearError;
use super::window::GearWindow;

/// Slack for rounding, relative to the limit.
// Roots round: at exactly the speed that `fastest` reports, a demand may exceed its limit by a few ε.
const ROUNDING: f64 = 1e-9;

/// Limits of the slave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlaveDynamics {
    velocity: f64,
    /// Limit in either direction: a master that reverses in a window turns one into the other.
    acceleration: f64,
    jerk: f64,
}

impl SlaveDynamics {
    pub(super) fn of(limits: &Limits) -> Self {
        Self {
            velocity: limits.velocity(),
            acceleration: limits.acceleration().min(limits.deceleration()),
            jerk: limits.jerk(),
        }
    }

    /// Checks whether the slave can follow a window, with this cycle time, s, while its master runs at
    /// this speed, u/s.
    ///
    /// # Errors
    /// [`FlyingGearError::TooFast`].
    pub(super) fn check(
        &self,
        window: &GearWindow,
        speed: f64,
        cycle: f64,
    ) -> Result<(), FlyingGearError> {
        for (quantity, received, limit) in self.demands(window, speed, cycle) {
            if received > limit * (1.0 + ROUNDING) {
                return Err(FlyingGearError::TooFast {
                    quantity,
                    received,
                    limit,
                    speed,
                    fastest: self.fastest(window, cycle),
                });
            }
        }
        Ok(())
    }

    /// Returns the demands of a window, with the limits of the slave.
    fn demands(&self, window: &GearWindow, speed: f64, cycle: f64) -> [(Quantity, f64, f64); 3] {
        let [velocity, acceleration, jerk] = window.demands(speed, cycle);
        [
            (Quantity::Velocity, velocity, self.velocity),
            (Quantity::Acceleration, acceleration, self.acceleration),
            (Quantity::Jerk, jerk, self.jerk),
        ]
    }

    /// Returns the master's greatest speed at which the slave can follow, u/s.
    pub(super) fn fastest(&self, window: &GearWindow, cycle: f64) -> f64 {
        let (slope, length) = (window.slope, window.master_length);
        let by_velocity = self.velocity / slope;
        if length > 0.0 {
            // 1.5·slope·V²/L = a, and 6·slope·V³/L² = j, each solved for V.
            let by_acceleration = libm::sqrt(self.acceleration * length / (1.5 * slope));
            let by_jerk = libm::cbrt(self.jerk * length * length / (6.0 * slope));
            by_velocity.min(by_acceleration).min(by_jerk)
        } else {
            // A step within a cycle: slope·V/T = a.
            by_velocity.min(self.acceleration * cycle / slope)
        }
    }
}
