//! What the set values of an axis never leave, whatever moves it.
//!
//! Motions with an end are checked as a whole, before they begin: what they may not do is a
//! [`GuardRefusal`]. What has no end, and what a master leads, is checked cycle by cycle: it brings
//! the axis to a stop by a [`GuardFault`], early enough to stop within the software limits.

use coaxle_curve::profile::{
    InvalidLimit, Kinematics, Limits, Profile, ProfileExtremes, to_velocity,
};

use super::dynamics::Dynamics;
pub use super::guard_error::{GuardFault, GuardRefusal};

/// No set value is larger than that, in whatever unit.
const OUT_OF_RANGE: f64 = 1e12;

fn out_of_range(number: f64) -> bool {
    number.is_nan() || number.abs() > OUT_OF_RANGE
}

/// What a limit of an axis may be: within it, no square or quotient overflows.
pub const EXPECTED_LIMIT: &str = "a number from 1e-9 to 1e15";

/// Whether a number can be a limit of an axis.
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
    /// Software limits, infinite where there is none.
    min: f64,
    max: f64,
}

impl Guard {
    /// The guard of an axis that can do so much, between its software limits, u: infinite where there
    /// is none.
    #[must_use]
    pub const fn new(limits: Limits, min: f64, max: f64) -> Self {
        Self { limits, min, max }
    }

    /// What the axis can do.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The software limits that there are, lower and upper, u.
    #[must_use]
    pub fn software_limits(&self) -> (Option<f64>, Option<f64>) {
        let given = |limit: f64| Some(limit).filter(|limit| limit.is_finite());
        (given(self.min), given(self.max))
    }

    /// The limits without the one of the jerk: the full deceleration is there within one cycle, which
    /// takes so many seconds.
    #[must_use]
    pub fn without_jerk_limit(&self, cycle_time: f64) -> Limits {
        let limits = &self.limits;
        let most = limits.acceleration().max(limits.deceleration());
        Limits::new(
            limits.velocity(),
            limits.acceleration(),
            limits.deceleration(),
            limits.jerk().max(most / cycle_time),
        )
        .unwrap_or(*limits)
    }

    /// The limits of a command.
    ///
    /// # Errors
    /// [`GuardRefusal`]: more than the axis can do, or no limit.
    pub fn limits_of(
        &self,
        velocity: Option<f64>,
        dynamics: &Dynamics,
    ) -> Result<Limits, GuardRefusal> {
        limits_within(&self.limits, velocity, dynamics)
    }

    /// A position that the axis may stand at.
    ///
    /// # Errors
    /// [`GuardRefusal`]: it is no number, or beyond a software limit.
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

    /// A velocity that the axis may have, either way.
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

    /// Whether a motion keeps the highest velocity.
    #[must_use]
    pub fn keeps_velocity(&self, extremes: &ProfileExtremes) -> bool {
        extremes.speed <= self.limits.velocity() * (1.0 + ROUNDING)
    }

    /// Whether a motion from `here` keeps the software limits. From beyond one it may come back.
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
        if extremes.low < self.min.min(here) - slack {
            passed(extremes.low, self.min)
        } else if extremes.high > self.max.max(here) + slack {
            passed(extremes.high, self.max)
        } else {
            Ok(())
        }
    }

    /// The next state of a motion that keeps the software limits, without what rounding adds.
    #[must_use]
    pub fn confined(&self, here: f64, next: &Kinematics) -> Kinematics {
        Kinematics {
            position: next.position.clamp(self.min.min(here), self.max.max(here)),
            ..*next
        }
    }

    fn slack(&self, position: f64) -> f64 {
        let finite = |limit: f64| if limit.is_finite() { limit.abs() } else { 0.0 };
        ROUNDING * position.abs().max(finite(self.min)).max(finite(self.max))
    }

    /// Whether a position is below the lower software limit.
    #[must_use]
    pub fn is_below(&self, position: f64) -> bool {
        position < self.min
    }

    /// Whether a position is above the upper software limit.
    #[must_use]
    pub fn is_above(&self, position: f64) -> bool {
        position > self.max
    }

    /// The stop from a state, as fast as the axis can.
    #[must_use]
    pub fn brake(&self, from: &Kinematics) -> Profile {
        to_velocity(from, 0.0, &self.limits)
    }

    /// Whether an axis that goes from `here` to `next` can still stop within the software limits.
    ///
    /// # Errors
    /// [`GuardFault::SoftwareLimit`].
    pub fn check_stop(&self, here: f64, next: &Kinematics) -> Result<(), GuardFault> {
        if self.is_far_from_limits(next) {
            Ok(())
        } else {
            self.check_brake(here, next)
        }
    }

    /// The same for a state that a coupling asks for, of which the axis brakes as it is
    /// [taken over](Self::taken_over).
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

    /// A bound of the way that any stop takes, cheap to calculate.
    fn farthest_stop(&self, from: &Kinematics) -> f64 {
        let (dec, jerk) = (self.limits.deceleration(), self.limits.jerk());
        let strongest = from
            .acceleration
            .abs()
            .max(dec)
            .max(self.limits.acceleration());
        let ramp = strongest / jerk;
        // Whatever the start acceleration adds to the speed while it is led to zero.
        let speed = from.velocity.abs() + strongest * ramp;
        speed * (2.0 * ramp + speed / dec.min(self.limits.acceleration()))
    }

    /// A coupled state as a motion of the axis's own takes it over: as it is, so that neither position
    /// nor velocity nor acceleration jump.
    ///
    /// Two limits come before that of the jerk. An acceleration that would lead the axis beyond its
    /// highest velocity, even if it were led to zero at once, is cut to what does not. And an axis that
    /// could stop within its software limits only without its acceleration, drops it.
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

    /// The state without an acceleration that makes it faster, and with no more deceleration than can
    /// be led to zero before it stands.
    fn settled(&self, coupled: &Kinematics) -> Kinematics {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = *coupled;
        let slows = velocity * acceleration < 0.0;
        let most =
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

    /// Whether any axis can have the set values of a coupling.
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

    /// Whether a coupling has the axis within its software limits.
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

/// A number that means something to an axis.
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

/// The limits of a command that may go as far as `most`, and does where it gives none.
///
/// # Errors
/// [`GuardRefusal`]: more than that, or no limit.
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

/// Limits of the velocity, the acceleration, the deceleration and the jerk.
///
/// # Errors
/// [`GuardRefusal::Value`]: one of them is no limit.
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
