//! Limits of a profile.

use super::phases::Kinematics;

/// Limits of a motion, all finite and above zero.
///
/// `acceleration` limits speeding up, `deceleration` slowing down. A change of velocity through
/// standstill keeps to the smaller of the two all along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    velocity: f64,
    acceleration: f64,
    deceleration: f64,
    jerk: f64,
}

impl Limits {
    /// Limits of an axis without any: the greatest that a config takes.
    pub const NONE: Self = Self {
        velocity: 1e15,
        acceleration: 1e15,
        deceleration: 1e15,
        jerk: 1e15,
    };

    /// Makes limits in u/s, u/s², u/s² and u/s³.
    ///
    /// # Errors
    /// [`InvalidLimit`] unless each is a finite number above zero.
    pub fn new(
        velocity: f64,
        acceleration: f64,
        deceleration: f64,
        jerk: f64,
    ) -> Result<Self, InvalidLimit> {
        Ok(Self {
            velocity: checked("velocity", velocity)?,
            acceleration: checked("acceleration", acceleration)?,
            deceleration: checked("deceleration", deceleration)?,
            jerk: checked("jerk", jerk)?,
        })
    }

    /// Returns these limits with another velocity, in u/s.
    ///
    /// # Errors
    /// [`InvalidLimit`] unless it is a finite number above zero.
    pub fn with_velocity(self, velocity: f64) -> Result<Self, InvalidLimit> {
        let velocity = checked("velocity", velocity)?;
        Ok(Self { velocity, ..self })
    }

    /// Returns limits that keep these and the others: the lesser of each.
    #[must_use]
    pub const fn at_most(&self, others: &Self) -> Self {
        Self {
            velocity: self.velocity.min(others.velocity),
            acceleration: self.acceleration.min(others.acceleration),
            deceleration: self.deceleration.min(others.deceleration),
            jerk: self.jerk.min(others.jerk),
        }
    }

    /// Reduces the acceleration of a state to one that can be led to zero, within the jerk, before the
    /// axis exceeds its velocity: a motion from there keeps the velocity limit.
    #[must_use]
    pub fn without_overspeed(&self, state: &Kinematics) -> Kinematics {
        // Velocity in the direction of the push: only the limit ahead matters.
        let along = state.velocity * state.acceleration.signum();
        // A slave already too fast has no room, and the root of a negative number would be NaN.
        let room = (self.velocity - along).max(0.0);
        // From a²/2j, the velocity gained while the acceleration is led to zero.
        let most = libm::sqrt(2.0 * self.jerk * room);
        Kinematics {
            acceleration: state.acceleration.clamp(-most, most),
            ..*state
        }
    }

    /// Returns the limits that are effective for positions one cycle of `cycle_time` seconds apart.
    /// Between two velocities within their limit there is no more acceleration than 2v/T, between two
    /// accelerations no more jerk than 2a/T. A greater limit, which means "none", has no effect, and
    /// numbers calculated with it would have no digits in common with the others.
    #[must_use]
    pub fn binding_in_cycles(&self, cycle_time: f64) -> Self {
        // A little more than the bound, so that rounding does not reduce an effective limit.
        const MARGIN: f64 = 1.0 + 1e-6;
        let per_cycle = 2.0 * MARGIN / cycle_time;
        let acceleration = self.acceleration.min(self.velocity * per_cycle);
        let deceleration = self.deceleration.min(self.velocity * per_cycle);
        Self {
            velocity: self.velocity,
            acceleration,
            deceleration,
            jerk: self.jerk.min(acceleration.max(deceleration) * per_cycle),
        }
    }

    /// Returns the greatest speed, u/s.
    #[must_use]
    pub const fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Returns the greatest acceleration, u/s².
    #[must_use]
    pub const fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Returns the greatest deceleration, u/s².
    #[must_use]
    pub const fn deceleration(&self) -> f64 {
        self.deceleration
    }

    /// Returns the greatest jerk, u/s³.
    #[must_use]
    pub const fn jerk(&self) -> f64 {
        self.jerk
    }
}

fn checked(field: &'static str, received: f64) -> Result<f64, InvalidLimit> {
    // Infinity is no "none": differences of two infinite numbers would be NaN.
    if received.is_finite() && received > 0.0 {
        Ok(received)
    } else {
        Err(InvalidLimit { field, received })
    }
}

/// A limit that no motion can keep.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{field}: received {received}, expected a finite number above 0")]
pub struct InvalidLimit {
    /// Name of the limit.
    pub field: &'static str,
    /// Value received.
    pub received: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_limit_that_none_can_keep_is_named() {
        let refused = Limits::new(1.0, 2.0, -3.0, 4.0).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "deceleration: received -3, expected a finite number above 0"
        );
        for bad in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(
                Limits::new(bad, 1.0, 1.0, 1.0).unwrap_err().field,
                "velocity"
            );
            assert_eq!(Limits::new(1.0, 1.0, 1.0, bad).unwrap_err().field, "jerk");
        }
    }

    #[test]
    fn an_acceleration_that_would_lead_beyond_the_velocity_is_cut() {
        let limits = Limits::new(100.0, 500.0, 500.0, 5_000.0).unwrap();
        let cut = |velocity, acceleration| {
            let state = Kinematics {
                position: 1.0,
                velocity,
                acceleration,
            };
            limits.without_overspeed(&state).acceleration
        };
        // 100² / (2·5000) u/s more.
        assert_eq!(cut(99.0, 400.0), 100.0);
        assert_eq!(cut(-99.0, -400.0), -100.0);
        assert_eq!(cut(99.0, -400.0), -400.0);
        assert_eq!((cut(120.0, 1.0), cut(120.0, -1.0)), (0.0, -1.0));
    }

    #[test]
    fn limits_that_mean_none_are_cut_to_what_a_cycle_can_show() {
        let none = Limits::new(10.0, 1e15, 1e15, 1e15).unwrap();
        let bound = none.binding_in_cycles(0.001);
        // 2v/T = 2·10/0.001, and 2a/T of that, each with the margin of 1e-6.
        assert!((bound.acceleration() / 2e4 - 1.0).abs() < 1e-5, "{bound:?}");
        assert!((bound.jerk() / 4e7 - 1.0).abs() < 1e-5, "{bound:?}");
        let usual = Limits::new(500.0, 5e3, 5e3, 1e5).unwrap();
        assert_eq!(usual.binding_in_cycles(0.001), usual);
    }

    #[test]
    fn only_the_velocity_is_replaced() {
        let limits = Limits::new(1.0, 2.0, 3.0, 4.0).unwrap();
        assert_eq!(limits.with_velocity(9.0), Limits::new(9.0, 2.0, 3.0, 4.0));
        assert!(limits.with_velocity(0.0).is_err());
    }
}
