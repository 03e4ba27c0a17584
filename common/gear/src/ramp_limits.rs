//! Limits of the ramp of a gear.

use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::{Dynamics, PlanInputs};
use coaxle_curve::profile::Limits;

/// Returns the limits of a ramp with these dynamics, or the slave's own if those are too slow to keep the
/// greatest velocity from its acceleration.
///
/// # Errors
/// [`GuardRefusal`]: dynamics beyond the slave's, or an invalid limit.
pub(super) fn ramp_limits(
    dynamics: &Dynamics,
    inputs: &PlanInputs,
) -> Result<Limits, GuardRefusal> {
    let asked = inputs.guard.limits_of(None, dynamics)?;
    // With v + a²/2j ≤ v_max the acceleration can be led to zero in time. Beyond it, a ramp
    // at the jerk asked for could keep the velocity only by a jump of the acceleration.
    let keeps_velocity = asked.without_overspeed(&inputs.slave) == inputs.slave;
    Ok(if keeps_velocity {
        asked
    } else {
        *inputs.guard.limits()
    })
}
