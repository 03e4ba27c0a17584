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
    let keeps_velocity = asked.without_overspeed(&inputs.slave) == inputs.slave;
    Ok(if keeps_velocity {
        asked
    } else {
        *inputs.guard.limits()
    })
}
