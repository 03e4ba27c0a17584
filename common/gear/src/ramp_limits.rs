//! What a ramp of a gear may use.

use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::{Dynamics, PlanInputs};
use coaxle_curve::profile::Limits;

/// The limits of a ramp with these dynamics, or the slave's own where those are too slow to keep the
/// highest velocity from the acceleration that it has.
///
/// # Errors
/// [`GuardRefusal`]: more than the slave can do, or no limit.
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
