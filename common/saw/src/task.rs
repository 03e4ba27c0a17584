//! A command and a coupling moment, checked and expressed over the master's position.

use coaxle_curve::profile::{InvalidLimit, Kinematics, Limits};

use super::checks::{Checklist, SyncEnds};
use super::command::{Ratio, SyncLimits};
use super::coupling_moment::CouplingMoment;
use super::demands::SlaveDemands;
use super::ramp::RampBounds;
use super::refusal::{SawRefusal, Violation};
use super::{SyncMask, SyncMode};

/// Smaller relative differences are rounding.
// Set values are sums over many cycles: their rounding is above ε, and far below any resolution.
pub(super) const NEGLIGIBLE: f64 = 1e-9;

/// Input of every plan. All numbers are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SyncTask {
    /// Slave units per master unit; not 0.
    pub(super) ratio: f64,
    pub(super) master_position: f64,
    pub(super) master_velocity: f64,
    pub(super) slave_position: f64,
    pub(super) slave_velocity: f64,
    /// Acceleration as used for planning, like the master's.
    pub(super) slave_acceleration: f64,
    pub(super) master_acceleration: f64,
    /// The limits in force. The velocity is the axis's own: the command's is only checked.
    pub(super) limits: Limits,
    pub(super) checklist: Checklist,
    /// Checks that the axis makes in any case.
    guard: Option<Checklist>,
}

impl SyncTask {
    /// # Errors
    /// The first invalid input, by name.
    pub(super) fn new(
        ratio: &Ratio,
        mode: &SyncMode,
        limits: &SyncLimits,
        moment: &CouplingMoment,
    ) -> Result<Self, SawRefusal> {
        // First, so that an invalid ratio has its own code whatever else is wrong.
        let ratio = ratio_of(ratio)?;
        check_finite(moment)?;
        let mask = mode.mask;
        let axis = &moment.axis;
        let own = &axis.dynamics;
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = moment.slave;
        let dynamics = Limits::new(
            axis.in_force(limits.velocity, own.velocity(), velocity),
            axis.in_force(limits.acceleration, own.acceleration(), acceleration),
            // Either of the two may be in use at the start, according to the direction.
            axis.in_force(limits.deceleration, own.deceleration(), acceleration),
            axis.jerk_in_force(limits.jerk),
        )?;
        let ignoring = |ignored: SyncMask, value: f64| {
            if mask.contains(ignored) { 0.0 } else { value }
        };
        let checklist = Checklist {
            mask,
            velocity: dynamics.velocity(),
            acceleration: dynamics.acceleration(),
            deceleration: dynamics.deceleration(),
            jerk: dynamics.jerk(),
            software: bounds(
                axis.min_position,
                axis.max_position,
                ["axis-min-position", "axis-max-position"],
            )?,
            optional: bounds(
                limits.min_position,
                limits.max_position,
                ["min-position", "max-position"],
            )?,
            // The codes of the checks tell the master's direction. A standing one counts as forwards.
            forward: moment.master.velocity >= 0.0,
        };
        let task = Self {
            ratio,
            master_position: moment.master.position,
            master_velocity: moment.master.velocity,
            slave_position: moment.slave.position,
            slave_velocity: moment.slave.velocity,
            slave_acceleration: ignoring(SyncMask::IGNORE_SLAVE_ACC, moment.slave.acceleration),
            master_acceleration: ignoring(
                SyncMask::IGNORE_MASTER_ACC,
                moment.master_acceleration(),
            ),
            // The command's velocity is a check, not a shape: without the check it is no reason to refuse.
            limits: dynamics.with_velocity(own.velocity())?,
            checklist,
            guard: axis.guard.map(|_| checklist.of_axis(own)),
        };
        // Checked in any case: no profile makes up for a line that the axis cannot follow.
        task.check_sync_velocity(own.velocity())?;
        Ok(task)
    }

    /// True if nothing is checked.
    pub(super) const fn checks_nothing(&self) -> bool {
        self.checklist.is_empty() && self.guard.is_none()
    }

    /// Makes the checks of the sync mode, then those of the axis.
    pub(super) fn check(&self, demands: &SlaveDemands, ends: &SyncEnds) -> Result<(), Violation> {
        self.checklist.pass(demands, ends)?;
        match &self.guard {
            Some(guard) => guard.pass(demands, ends),
            None => Ok(()),
        }
    }

    /// Returns the limits in force, with the velocity limit of the command.
    pub(super) fn limits_in_force(&self) -> Limits {
        let checked = self.limits.with_velocity(self.checklist.velocity);
        checked.unwrap_or(self.limits)
    }

    /// Returns the jerk that a profile has to keep, u/s³; infinite if that is not checked.
    pub(super) fn checked_jerk(&self) -> f64 {
        let checked = self.checklist.mask.contains(SyncMask::MAX_JERK);
        if checked || self.guard.is_some() {
            self.checklist.jerk
        } else {
            // A ramp without a limit of the jerk is as short as its acceleration allows.
            f64::INFINITY
        }
    }

    /// Returns the velocity of the coupled slave, u/s.
    pub(super) fn sync_velocity(&self) -> f64 {
        self.ratio * self.master_velocity
    }

    /// Returns the slave's velocity per master velocity.
    pub(super) fn slope(&self) -> f64 {
        if self.master_velocity == 0.0 {
            0.0
        } else {
            self.slave_velocity / self.master_velocity
        }
    }

    /// Returns the slave's second derivative with respect to the master.
    pub(super) fn curvature(&self) -> f64 {
        if self.master_velocity == 0.0 {
            return 0.0;
        }
        // From a = s''·V² + s'·A.
        let by_master = self.slope() * self.master_acceleration;
        (self.slave_acceleration - by_master) / (self.master_velocity * self.master_velocity)
    }

    /// True if neither axis accelerates noticeably while the master travels `distance`.
    pub(super) fn is_free_of_acceleration(&self, distance: f64) -> bool {
        let square = self.master_velocity * self.master_velocity;
        let steep = self.slope().abs().max(self.ratio.abs());
        // The change of velocity over the distance M is a·M/V: less than 1e-9 of V.
        (self.master_acceleration * distance).abs() <= NEGLIGIBLE * square
            && (self.slave_acceleration * distance).abs() <= NEGLIGIBLE * square * steep
    }

    /// Returns the limits of a ramp of the slope over the master's position, for a master that moves.
    pub(super) fn ramp_bounds(&self, jerk: f64) -> RampBounds {
        let speed = self.master_velocity.abs();
        RampBounds {
            // Over the master, s'' = a/V² and s''' = j/V³.
            acceleration: self.checklist.acceleration / (speed * speed),
            deceleration: self.checklist.deceleration / (speed * speed),
            jerk: jerk / (speed * speed * speed),
        }
    }

    /// Checks that the slave stands still if the master does: a profile over its position has no other
    /// solution.
    ///
    /// # Errors
    /// [`SawRefusal::MasterAtRest`].
    pub(super) fn check_master(&self) -> Result<(), SawRefusal> {
        let slave_moves = self.slave_velocity != 0.0 || self.slave_acceleration != 0.0;
        if self.master_velocity == 0.0 && slave_moves {
            return Err(SawRefusal::MasterAtRest {
                slave_velocity: self.slave_velocity,
                slave_acceleration: self.slave_acceleration,
            });
        }
        Ok(())
    }

    /// # Errors
    /// [`SawRefusal::SyncVelocity`].
    pub(super) fn check_sync_velocity(&self, highest: f64) -> Result<(), SawRefusal> {
        let velocity = self.sync_velocity();
        // A gear at exactly the limit must not be refused for the rounding of its ratio.
        if velocity.abs() > highest * (1.0 + NEGLIGIBLE) {
            return Err(SawRefusal::SyncVelocity {
                velocity,
                limit: highest,
            });
        }
        Ok(())
    }
}

impl From<InvalidLimit> for SawRefusal {
    fn from(limit: InvalidLimit) -> Self {
        Self::Limit {
            field: limit.field,
            received: limit.received,
        }
    }
}

fn ratio_of(ratio: &Ratio) -> Result<f64, SawRefusal> {
    let Ratio {
        numerator,
        denominator,
    } = *ratio;
    // Before the comparison with 0, which NaN would pass.
    finite("ratio-numerator", numerator)?;
    if denominator == 0 {
        return Err(SawRefusal::DenominatorZero);
    }
    if numerator == 0.0 {
        return Err(SawRefusal::RatioZero { numerator });
    }
    Ok(numerator / f64::from(denominator))
}

fn check_finite(moment: &CouplingMoment) -> Result<(), SawRefusal> {
    let CouplingMoment { master, slave, .. } = moment;
    finite("master-position", master.position)?;
    finite("master-velocity", master.velocity)?;
    finite("master-acceleration", master.acceleration)?;
    finite("slave-position", slave.position)?;
    finite("slave-velocity", slave.velocity)?;
    finite("slave-acceleration", slave.acceleration)
}

/// Returns the position limits; infinity by default.
fn bounds(
    min: Option<f64>,
    max: Option<f64>,
    fields: [&'static str; 2],
) -> Result<(f64, f64), SawRefusal> {
    let given = |limit: Option<f64>, field, none: f64| match limit {
        Some(limit) => finite(field, limit).map(|()| limit),
        None => Ok(none),
    };
    Ok((
        given(min, fields[0], f64::NEG_INFINITY)?,
        given(max, fields[1], f64::INFINITY)?,
    ))
}

pub(super) fn finite(field: &'static str, received: f64) -> Result<(), SawRefusal> {
    if received.is_finite() {
        Ok(())
    } else {
        Err(SawRefusal::NotFinite { field, received })
    }
}
