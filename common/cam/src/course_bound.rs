//! A bound of the slave's demands, by which most of a course need not be checked in detail.

use super::limits::CamLimits;
use super::placement::{Path, PlacedPlate};
use coaxle_plate::PeakDemands;

/// Slack for rounding, relative to the limit.
// Half of that with which each place is checked, so that no place left out could be refused.
const ROUNDING: f64 = 0.5e-6;

/// A plate of a course, with all that is beside it.
pub(super) struct CourseBound<'a> {
    pub(super) placed: PlacedPlate<'a>,
    /// Magnitudes that the other plates and the ramp do not exceed in sum.
    pub(super) beside: Path,
    /// Velocity of the master, u/s.
    pub(super) velocity: f64,
    pub(super) limits: &'a CamLimits,
}

impl CourseBound<'_> {
    /// True if the slave can exceed its limits where the plate has these demands.
    pub(super) fn can_be_exceeded(&self, demands: &PeakDemands) -> bool {
        let limits = self.limits;
        let speed = self.velocity.abs();
        let own = self.placed.placement.bound(demands);
        let velocity = (own.slope + self.beside.slope) * speed;
        // Not negated, as NaN has to be checked in detail.
        let within = |value: f64, limit: f64| value <= limit * (1.0 + ROUNDING);
        if !within(velocity, limits.velocity) {
            return true;
        }
        let acceleration = (own.curvature + self.beside.curvature) * speed * speed;
        if within(acceleration, limits.acceleration.min(limits.deceleration)) {
            return false;
        }
        // Beside others the sum determines whether the slave brakes.
        if self.beside.slope != 0.0 || self.beside.curvature != 0.0 {
            return true;
        }
        let runs_forwards = self.velocity * self.placed.placement.master_scaling > 0.0;
        let (speeding_up, braking) = if runs_forwards {
            (demands.speeding_up, demands.braking)
        } else {
            (demands.braking, demands.speeding_up)
        };
        let over_time = |curvature: f64| {
            let alone = PeakDemands {
                speeding_up: curvature,
                ..PeakDemands::default()
            };
            self.placed.placement.bound(&alone).curvature * speed * speed
        };
        !(within(over_time(speeding_up), limits.acceleration)
            && within(over_time(braking), limits.deceleration))
    }
}
