//! Monitoring of the slave's limits as long as it is coupled.

use crate::coupling_moment::SlaveLimits;
use crate::refusal::{Check, Violation};
use coaxle_curve::profile::Kinematics;

use super::settings::{SawFault, SawTolerances};

/// Limits of the axis, independent of the checks at the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LimitMonitor {
    fastest: f64,
    margin: f64,
    lowest: f64,
    highest: f64,
}

impl LimitMonitor {
    pub(super) fn new(axis: &SlaveLimits, tolerances: &SawTolerances) -> Self {
        Self {
            fastest: axis.dynamics.velocity(),
            margin: 1.0 + tolerances.velocity_margin,
            // Not infinite, so that an infinite position is
            // outside, like NaN, which fails every comparison.
            lowest: axis.min_position.unwrap_or(f64::MIN),
            highest: axis.max_position.unwrap_or(f64::MAX),
        }
    }

    /// True if the slave is within its limits; false for values that are not finite.
    #[inline]
    pub(super) fn is_within_limits(&self, slave: &Kinematics) -> bool {
        // Acceleration and jerk are checked in the plan. A master that ripples may exceed them on the way.
        slave.velocity.abs() <= self.fastest * self.margin
            && slave.position >= self.lowest
            && slave.position <= self.highest
            && slave.acceleration.is_finite()
    }

    /// True if it gets there in a cycle without being faster on the way than at its end: a master that
    /// jumps can pass a steep part of the profile within one cycle.
    #[inline]
    pub(super) fn is_step_within_limits(
        &self,
        from: &Kinematics,
        to: &Kinematics,
        dt: f64,
    ) -> bool {
        // By positions: velocities at both ends may be small, however far apart the positions are.
        (to.position - from.position).abs() <= self.fastest * self.margin * dt
    }

    /// Returns the fault of a step from `before` to `slave`.
    pub(super) fn fault(
        &self,
        before: &Kinematics,
        slave: &Kinematics,
        master: &Kinematics,
        dt: f64,
        detailed: bool,
    ) -> SawFault {
        // If the velocity itself is within the limit, the step was too long.
        let mean = (slave.position - before.position) / dt;
        let velocity = if slave.velocity.abs() > self.fastest {
            slave.velocity
        } else {
            mean
        };
        let (check, measured, limit) = if slave.position < self.lowest {
            (Check::MinPos, slave.position, self.lowest)
        } else if slave.position > self.highest {
            (Check::MaxPos, slave.position, self.highest)
        } else if velocity > self.fastest {
            (Check::MaxVelo, velocity, self.fastest)
        } else {
            (Check::MinVelo, velocity, -self.fastest)
        };
        let numbers = [slave.position, slave.velocity, slave.acceleration];
        if !numbers.iter().all(|number| number.is_finite()) {
            return SawFault::MasterNotFinite;
        }
        SawFault::Limit(Violation {
            check,
            measured,
            limit,
            master_position: master.position,
            detailed,
        })
    }
}
