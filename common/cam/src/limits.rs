//! Limits of the slave of a coupling by cam plates.

use coaxle_curve::profile::Limits;

use super::error::CouplingError;

/// The limits of a slave, and its cycle: the limits for a change of plates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamLimits {
    /// Greatest speed, u/s.
    pub velocity: f64,
    /// Greatest acceleration, u/s².
    pub acceleration: f64,
    /// Greatest deceleration, u/s².
    pub deceleration: f64,
    /// Greatest jerk, u/s³, of the transition from one course to another. The slave follows a plate's own
    /// course, whatever its jerk.
    pub jerk: f64,
    /// Cycle time, s.
    pub cycle: f64,
}

impl CamLimits {
    /// Takes the limits of an axis with this cycle time, s.
    #[must_use]
    pub const fn of(limits: &Limits, cycle: f64) -> Self {
        Self {
            velocity: limits.velocity(),
            acceleration: limits.acceleration(),
            deceleration: limits.deceleration(),
            jerk: limits.jerk(),
            cycle,
        }
    }

    /// Returns the greatest deviation from the slave's own motion within a cycle, u.
    pub(super) fn farthest(&self) -> f64 {
        let Self { jerk, cycle, .. } = *self;
        // j·T³/6 from no acceleration, and a·T²/2 if the jerk reaches the acceleration's limit within the cycle.
        let by_jerk = jerk * cycle * cycle * cycle / 6.0;
        by_jerk.min(self.push() * cycle * cycle / 2.0)
    }

    /// Returns the greatest change of velocity within a cycle beyond that of the slave's own motion, u/s.
    pub(super) fn fastest_change(&self) -> f64 {
        let Self { jerk, cycle, .. } = *self;
        // A derivative lower: j·T²/2, and a·T.
        let by_jerk = jerk * cycle * cycle / 2.0;
        by_jerk.min(self.push() * cycle)
    }

    fn push(&self) -> f64 {
        // The lesser: a jump may speed the slave up or brake it.
        self.acceleration.min(self.deceleration)
    }

    pub(super) fn check(&self) -> Result<(), CouplingError> {
        for (name, received) in [
            ("velocity of the slave", self.velocity),
            ("acceleration of the slave", self.acceleration),
            ("deceleration of the slave", self.deceleration),
            ("jerk of the slave", self.jerk),
            ("cycle of the slave", self.cycle),
        ] {
            if !(received.is_finite() && received > 0.0) {
                return Err(CouplingError::Parameter {
                    name,
                    received,
                    expected: "a finite number above 0",
                });
            }
        }
        Ok(())
    }
}
