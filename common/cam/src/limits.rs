//! What the slave of a coupling by cam plates can do.

use coaxle_curve::profile::Limits;

use super::error::CouplingError;

/// The limits of a slave, and its cycle: how far a change of plates may go.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct CamLimits {
    /// Highest speed, u/s.
    pub velocity: f64,
    /// Highest acceleration, u/s².
    pub acceleration: f64,
    /// Highest deceleration, u/s².
    pub deceleration: f64,
    /// Highest jerk, u/s³: of the way from one course to another. What a plate asks for by itself its
    /// slave does, whatever the jerk.
    pub jerk: f64,
    /// How long a cycle is, s.
    pub cycle: f64,
}

impl CamLimits {
    /// Those of an axis with a cycle of so many seconds.
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

    /// How far the slave gets from where it would be anyway within a cycle, u.
    pub(super) fn farthest(&self) -> f64 {
        let Self { jerk, cycle, .. } = *self;
        let by_jerk = jerk * cycle * cycle * cycle / 6.0;
        by_jerk.min(self.push() * cycle * cycle / 2.0)
    }

    /// How much its velocity changes more than it would anyway within a cycle, u/s.
    pub(super) fn fastest_change(&self) -> f64 {
        let Self { jerk, cycle, .. } = *self;
        let by_jerk = jerk * cycle * cycle / 2.0;
        by_jerk.min(self.push() * cycle)
    }

    fn push(&self) -> f64 {
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
