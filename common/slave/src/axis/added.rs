//! Added motions: a shift of the master before the coupling, and a distance after it, before the guard.

use coaxle_axis::guard::{check_number, limits, limits_within};
use coaxle_axis::{Dynamics, Masters};
use coaxle_curve::profile::{Kinematics, Limits, to_position};

use super::SlaveAxis;
use crate::change::Effect;
use crate::motion::{Motion, Planned};
use crate::refusal::Refusal;
use crate::shift::sum;

/// Reserve of velocity and acceleration for masters that ripple.
const RESERVE: f64 = 0.01;

/// Least share of a limit for an added motion: with less it would take too long.
// With a thousandth of a limit the motion takes a thousand times as long as with all of it.
const LEAST_LEFT: f64 = 1e-3;

/// Greatest part of the limits used by the current motion: its speed, its acceleration and its own jerk.
struct Taken {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
    reserve: f64,
}

impl SlaveAxis {
    /// The masters as the coupling sees them.
    pub(super) fn seen_masters(&self) -> Masters {
        match self.masters.first() {
            Some(first) if self.phasing.is_active() => {
                let shift = self.phasing.now();
                let is_shifting = shift.velocity != 0.0;
                self.masters.with_first(sum(first, shift), is_shifting)
            }
            _ => self.masters,
        }
    }

    /// Superimposed motion.
    pub(super) fn added(&self) -> Option<Kinematics> {
        let added = &self.superimposed;
        added.is_active().then(|| *added.now())
    }

    pub(super) fn plan_phasing(
        &self,
        shift: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<Effect, Refusal> {
        check_number("shift", shift)?;
        self.masters.first().ok_or(Refusal::NoMaster)?;
        let coupling = self.engaged().map(|kind| self.couplings.get(kind));
        let gain = coupling.and_then(|coupling| coupling.gain());
        // A gain of 0 leads nothing to the slave: no limit of the slave bounds the shift, and none can be divided by
        // it.
        let limits = match gain.filter(|gain| *gain != 0.0) {
            Some(gain) => {
                let left = self.left(&self.taken_by_coupling(), gain.abs())?;
                limits_within(&left, velocity, dynamics)?
            }
            None => given(velocity, dynamics)?,
        };
        Ok(Effect::Phase(to_position(
            self.phasing.now(),
            shift,
            &limits,
        )))
    }

    pub(super) fn plan_superimposed(
        &self,
        distance: f64,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<Effect, Refusal> {
        check_number("distance", distance)?;
        let start = self.superimposed.now();
        let end = start.position + distance;
        // A coupling is known in its present state only, an own motion to its end.
        let taken = match &self.motion {
            Motion::Coupled(_) => self.taken_by_coupling(),
            Motion::Own(planned) => {
                // Any offset may meet any position of the motion: the sums of their extremes bound all of it.
                self.check_range(planned, start.position.min(end), start.position.max(end))?;
                taken_by(planned)
            }
        };
        let limits = limits_within(&self.left(&taken, 1.0)?, velocity, dynamics)?;
        Ok(Effect::Superimpose(to_position(start, end, &limits)))
    }

    /// Checks that a motion with an end keeps the software limits with the added one.
    fn check_range(&self, planned: &Planned, least: f64, most: f64) -> Result<(), Refusal> {
        // A motion without an end is checked cycle by cycle instead.
        if planned.end().velocity == 0.0 {
            let extremes = planned.extremes();
            self.guard.check_target("distance", extremes.low + least)?;
            self.guard.check_target("distance", extremes.high + most)?;
        }
        Ok(())
    }

    /// Part used by the coupling, as long as the masters continue as they are.
    fn taken_by_coupling(&self) -> Taken {
        let added = self.superimposed.now();
        Taken {
            // The set values contain the added motion under way, which the planned one replaces.
            velocity: (self.set.velocity - added.velocity).abs(),
            acceleration: (self.set.acceleration - added.acceleration).abs(),
            // Masters at a constant acceleration need no jerk. More is caught up by the last stage.
            jerk: 0.0,
            reserve: RESERVE,
        }
    }

    /// Remaining limits, in units of an added motion that moves the slave with this `gain`.
    fn left(&self, taken: &Taken, gain: f64) -> Result<Limits, Refusal> {
        let own = self.guard.limits();
        // The added motion may speed the axis up or slow it down: only the lower of the two holds for both.
        let slowest = own.acceleration().min(own.deceleration());
        let left = |field, limit: f64, taken: f64, reserve: f64| {
            let left = limit * (1.0 - reserve) - taken;
            let least = LEAST_LEFT * limit;
            if left > least {
                Ok(left)
            } else {
                Err(Refusal::NothingLeft {
                    field,
                    taken,
                    // The condition above, solved for the part that is taken.
                    passes: limit * (1.0 - reserve) - least,
                })
            }
        };
        let velocity = left("velocity", own.velocity(), taken.velocity, taken.reserve)?;
        let acceleration = left("acceleration", slowest, taken.acceleration, taken.reserve)?;
        let jerk = left("jerk", own.jerk(), taken.jerk, 0.0)?;
        // The slave moves by gain · shift, and so do all of its derivatives.
        let left = [velocity, acceleration, acceleration, jerk].map(|limit| limit / gain);
        Ok(limits(left)?)
    }
}

/// Part still used by a profile, from its current state.
fn taken_by(planned: &Planned) -> Taken {
    // A velocity that is kept takes its part of the velocity for good, but neither acceleration nor jerk.
    if planned.is_over() {
        return Taken {
            velocity: planned.end().velocity.abs(),
            acceleration: 0.0,
            jerk: 0.0,
            reserve: 0.0,
        };
    }
    Taken {
        velocity: planned.extremes().speed,
        acceleration: planned.largest_acceleration_left(),
        jerk: planned.largest_jerk_left(),
        reserve: 0.0,
    }
}

/// The limits of the command, if there is no other source.
fn given(velocity: Option<f64>, dynamics: &Dynamics) -> Result<Limits, Refusal> {
    let needed = |field, value: Option<f64>| value.ok_or(Refusal::NotGiven { field });
    // Shifts are in units of the master, whose limits the slave does not know.
    let acceleration = needed("acceleration", dynamics.acceleration)?;
    Ok(limits([
        needed("velocity", velocity)?,
        acceleration,
        dynamics.deceleration.unwrap_or(acceleration),
        needed("jerk", dynamics.jerk)?,
    ])?)
}
