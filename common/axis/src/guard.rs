//! Limits of an axis's set values, for every motion.
//!
//! Motions with an end are checked as a whole, before they begin: a violation is a
//! [`GuardRefusal`]. Motions without an end, and coupled motions, are checked cycle by cycle: a
//! [`GuardFault`] stops the axis early enough to stay within the software limits.

use coaxle_curve::profile::{
    InvalidLimit, Kinematics, Limits, Profile, ProfileExtremes, to_velocity,
};

use super::dynamics::Dynamics;
pub use super::guard_error::{GuardFault, GuardRefusal};

/// Largest set value, in any unit.
// There neighbouring doubles are 1.2e-4 apart: no position of an axis has a meaning beyond.
const OUT_OF_RANGE: f64 = 1e12;

fn out_of_range(number: f64) -> bool {
    // Infinities are above it. NaN compares as false, so it is asked for.
    number.is_nan() || number.abs() > OUT_OF_RANGE
}

/// Range of an axis limit: within it, no square or quotient overflows.
pub const EXPECTED_LIMIT: &str = "a number from 1e-9 to 1e15";

/// True if a number is valid as a limit of an axis.
#[must_use]
pub fn is_limit(number: f64) -> bool {
    (1e-9..=1e15).contains(&number)
}

/// Slack for rounding, relative to the quantity at hand.
pub const ROUNDING: f64 = 1e-9;

/// Keeps an axis within its limits.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    limits: Limits,
    /// Software limits, infinite if there is none.
    min: f64,
    max: f64,
}

impl Guard {
    /// Creates the guard of an axis with these limits, between its software limits, u: infinite if
    /// there is none.
    #[must_use]
    pub const fn new(limits: Limits, min: f64, max: f64) -> Self {
        Self { limits, min, max }
    }

    /// Limits of the axis.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The software limits, lower and upper, u, if any.
    #[must_use]
    pub fn software_limits(&self) -> (Option<f64>, Option<f64>) {
        let given = |limit: f64| Some(limit).filter(|limit| limit.is_finite());
        (given(self.min), given(self.max))
    }

    /// The limits without the jerk limit: the full deceleration is reached within one cycle of
    /// `cycle_time` s.
    #[must_use]
    pub fn without_jerk_limit(&self, cycle_time: f64) -> Limits {
        let limits = &self.limits;
        let most = limits.acceleration().max(limits.deceleration());
        Limits::new(
            limits.velocity(),
            limits.acceleration(),
            limits.deceleration(),
            // At most one cycle from no acceleration to all of it.
            limits.jerk().max(most / cycle_time),
        )
        .unwrap_or(*limits)
    }

    /// Computes the limits of a command.
    ///
    /// # Errors
    /// [`GuardRefusal`]: above the axis's limits, or not a valid limit.
    pub fn limits_of(
        &self,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<Limits, GuardRefusal> {
        limits_within(&self.limits, velocity, dynamics)
    }

    /// Checks a position of rest.
    ///
    /// # Errors
    /// [`GuardRefusal`]: not a number, or beyond a software limit.
    pub fn check_target(&self, field: &'static str, position: f64) -> Result<(), GuardRefusal> {
        check_number(field, position)?;
        let beyond = |limit: f64| {
            Err(GuardRefusal::SoftwareLimit {
                reached: position,
                limit,
            })
        };
        if self.is_below(position) {
            beyond(self.min)
        } else if self.is_above(position) {
            beyond(self.max)
        } else {
            Ok(())
        }
    }

    /// Checks a velocity, in both directions.
    ///
    /// # Errors
    /// [`GuardRefusal::AboveLimit`].
    pub fn check_speed(&self, velocity: f64) -> Result<(), GuardRefusal> {
        let (received, limit) = (velocity.abs(), self.limits.velocity());
        if received > limit {
            Err(GuardRefusal::AboveLimit {
                field: "velocity",
                received,
                limit,
            })
        } else {
            Ok(())
        }
    }

    /// True if a motion keeps the highest velocity.
    #[must_use]
    pub fn keeps_velocity(&self, extremes: &ProfileExtremes) -> bool {
        extremes.speed <= self.limits.velocity() * (1.0 + ROUNDING)
    }

    /// Checks that a motion from `here` keeps the software limits. From beyond one it may return.
    ///
    /// # Errors
    /// [`GuardRefusal::SoftwareLimit`].
    pub fn check_way(&self, here: f64, extremes: &ProfileExtremes) -> Result<(), GuardRefusal> {
        self.check_extremes(here, extremes, self.slack(here))
            .map_err(|Passed { reached, limit }| GuardRefusal::SoftwareLimit { reached, limit })
    }

    fn check_extremes(
        &self,
        here: f64,
        extremes: &ProfileExtremes,
        slack: f64,
    ) -> Result<(), Passed> {
        let passed = |reached: f64, limit: f64| Err(Passed { reached, limit });
        // From beyond a limit the present position takes its place: the axis may return, but move no farther.
        if extremes.low < self.min.min(here) - slack {
            passed(extremes.low, self.min)
        } else if extremes.high > self.max.max(here) + slack {
            passed(extremes.high, self.max)
        } else {
            Ok(())
        }
    }

    /// The next state of a motion that keeps the software limits, without rounding errors.
    #[must_use]
    pub fn confined(&self, here: f64, next: &Kinematics) -> Kinematics {
        Kinematics {
            // Bounds in order in any case, as both include the present position: the clamp cannot panic.
            position: next.position.clamp(self.min.min(here), self.max.max(here)),
            ..*next
        }
    }

    fn slack(&self, position: f64) -> f64 {
        // Without a limit its infinity would make the slack infinite.
        let finite = |limit: f64| if limit.is_finite() { limit.abs() } else { 0.0 };
        ROUNDING * position.abs().max(finite(self.min)).max(finite(self.max))
    }

    /// True if a position is below the lower software limit.
    #[must_use]
    pub fn is_below(&self, position: f64) -> bool {
        position < self.min
    }

    /// True if a position is above the upper software limit.
    #[must_use]
    pub fn is_above(&self, position: f64) -> bool {
        position > self.max
    }

    /// The stop from a state, at the limits of the axis.
    #[must_use]
    pub fn brake(&self, from: &Kinematics) -> Profile {
        to_velocity(from, 0.0, &self.limits)
    }

    /// Checks that an axis that moves from `here` to `next` can still stop within the software limits.
    ///
    /// # Errors
    /// [`GuardFault::SoftwareLimit`].
    pub fn check_stop(&self, here: f64, next: &Kinematics) -> Result<(), GuardFault> {
        // An upper bound first: a profile costs roots, and mostly the limits are far.
        if self.is_far_from_limits(next) {
            Ok(())
        } else {
            self.check_brake(here, next)
        }
    }

    /// Checks the stop from a state of a coupling, from which the axis brakes as it is [taken
    /// over](Self::taken_over).
    ///
    /// # Errors
    /// [`GuardFault::SoftwareLimit`].
    pub fn check_coupled_stop(&self, here: f64, next: &Kinematics) -> Result<(), GuardFault> {
        if self.is_far_from_limits(next) {
            Ok(())
        } else {
            self.check_brake(here, &self.taken_over(next))
        }
    }

    fn check_brake(&self, here: f64, next: &Kinematics) -> Result<(), GuardFault> {
        self.check_extremes(here, &ProfileExtremes::of(&self.brake(next)), 0.0)
            .map_err(|Passed { reached, limit }| GuardFault::SoftwareLimit { reached, limit })
    }

    fn is_far_from_limits(&self, state: &Kinematics) -> bool {
        let way = self.farthest_stop(state);
        state.position - way >= self.min && state.position + way <= self.max
    }

    /// An upper bound of the stopping distance, cheap to calculate.
    fn farthest_stop(&self, from: &Kinematics) -> f64 {
        let (dec, jerk) = (self.limits.deceleration(), self.limits.jerk());
        let strongest = from
            .acceleration
            .abs()
            .max(dec)
            .max(self.limits.acceleration());
        let ramp = strongest / jerk;
        // The greatest speed gain of the start acceleration while it is led to zero.
        // Twice a²/2j, the speed gained while the acceleration is led to 0: an upper bound needs no more.
        let speed = from.velocity.abs() + strongest * ramp;
        // v²/a, twice the distance of the braking itself, and two ramps of the acceleration at full speed.
        speed * (2.0 * ramp + speed / dec.min(self.limits.acceleration()))
    }

    /// A coupled state as the axis's own motion takes it over: unchanged, so that neither position
    /// nor velocity nor acceleration jump.
    ///
    /// Two limits have priority over the jerk limit. An acceleration that would lead the axis
    /// beyond its highest velocity, even if it were led to zero at once, is reduced accordingly.
    /// And an axis that could stop within its software limits only without its acceleration drops
    /// it.
    #[must_use]
    pub fn taken_over(&self, coupled: &Kinematics) -> Kinematics {
        let as_it_is = self.limits.without_overspeed(coupled);
        let stops = self.is_far_from_limits(&as_it_is)
            || self.check_brake(coupled.position, &as_it_is).is_ok();
        if stops {
            as_it_is
        } else {
            self.settled(coupled)
        }
    }

    /// The state without an accelerating acceleration, and with at most the deceleration that can
    /// be led to zero before standstill.
    fn settled(&self, coupled: &Kinematics) -> Kinematics {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = *coupled;
        let slows = velocity * acceleration < 0.0;
        let most =
            // a² = 2·j·v: leading a harder deceleration to 0 would reverse the axis.
            libm::sqrt(2.0 * self.limits.jerk() * velocity.abs()).min(self.limits.deceleration());
        let kept = if slows {
            acceleration.clamp(-most, most)
        } else {
            0.0
        };
        Kinematics {
            acceleration: kept,
            ..*coupled
        }
    }

    /// Checks that the set values of a coupling are possible for an axis.
    ///
    /// # Errors
    /// [`GuardFault::OutOfRange`].
    pub fn check_values(&self, next: &Kinematics) -> Result<(), GuardFault> {
        for (quantity, received) in [
            ("set position", next.position),
            ("set velocity", next.velocity),
            ("set acceleration", next.acceleration),
        ] {
            if out_of_range(received) {
                return Err(GuardFault::OutOfRange { quantity, received });
            }
        }
        Ok(())
    }

    /// Checks that a coupled position is within the software limits.
    ///
    /// # Errors
    /// [`GuardFault::SoftwareLimit`].
    pub fn check_position(&self, here: f64, position: f64) -> Result<(), GuardFault> {
        let at_rest = ProfileExtremes {
            low: position,
            high: position,
            speed: 0.0,
            slowest: 0.0,
            fastest: 0.0,
        };
        self.check_extremes(here, &at_rest, self.slack(here))
            .map_err(|Passed { reached, limit }| GuardFault::SoftwareLimit { reached, limit })
    }
}

/// A software limit that a motion would pass.
#[derive(Clone, Copy, Debug)]
struct Passed {
    reached: f64,
    limit: f64,
}

/// Checks a number for an axis.
///
/// # Errors
/// [`GuardRefusal::Value`].
pub fn check_number(field: &'static str, received: f64) -> Result<(), GuardRefusal> {
    if out_of_range(received) {
        Err(GuardRefusal::Value {
            field,
            received,
            expected: "a number of at most 1e12",
        })
    } else {
        Ok(())
    }
}

/// Computes the limits of a command that are at most `most`, and by default equal to it.
///
/// # Errors
/// [`GuardRefusal`]: above these, or not a valid limit.
pub fn limits_within(
    most: &Limits,
    velocity: Option<f64>,
    dynamics: &Dynamics,
) -> Result<Limits, GuardRefusal> {
    limits([
        at_most("velocity", velocity, most.velocity())?,
        at_most("acceleration", dynamics.acceleration, most.acceleration())?,
        at_most("deceleration", dynamics.deceleration, most.deceleration())?,
        at_most("jerk", dynamics.jerk, most.jerk())?,
    ])
}

/// Creates limits of the velocity, the acceleration, the deceleration and the jerk.
///
/// # Errors
/// [`GuardRefusal::Value`]: one of them is not a valid limit.
pub fn limits(
    [velocity, acceleration, deceleration, jerk]: [f64; 4],
) -> Result<Limits, GuardRefusal> {
    check_limit("velocity", velocity)?;
    check_limit("acceleration", acceleration)?;
    check_limit("deceleration", deceleration)?;
    check_limit("jerk", jerk)?;
    Ok(Limits::new(velocity, acceleration, deceleration, jerk)?)
}

impl From<InvalidLimit> for GuardRefusal {
    fn from(InvalidLimit { field, received }: InvalidLimit) -> Self {
        Self::Value {
            field,
            received,
            expected: EXPECTED_LIMIT,
        }
    }
}

fn check_limit(field: &'static str, received: f64) -> Result<(), GuardRefusal> {
    if is_limit(received) {
        Ok(())
    } else {
        Err(GuardRefusal::Value {
            field,
            received,
            expected: EXPECTED_LIMIT,
        })
    }
}

fn at_most(field: &'static str, asked: Option<f64>, limit: f64) -> Result<f64, GuardRefusal> {
    let received = asked.unwrap_or(limit);
    if received > limit {
        Err(GuardRefusal::AboveLimit {
            field,
            received,
            limit,
        })
    } else {
        check_limit(field, received).map(|()| received)
    }
}
