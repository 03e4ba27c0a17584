//! What a profile must keep within.

/// Limits of a motion, all finite and above zero.
///
/// `acceleration` bounds what makes the axis faster, `deceleration` what makes it slower. A change
/// of velocity that passes through standstill keeps to the smaller of the two all the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    velocity: f64,
    acceleration: f64,
    deceleration: f64,
    jerk: f64,
}

impl Limits {
    /// Limits in u/s, u/s², u/s² and u/s³.
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

    /// The same limits with another velocity, in u/s.
    ///
    /// # Errors
    /// [`InvalidLimit`] unless it is a finite number above zero.
    pub fn with_velocity(self, velocity: f64) -> Result<Self, InvalidLimit> {
        let velocity = checked("velocity", velocity)?;
        Ok(Self { velocity, ..self })
    }

    /// Highest speed, u/s.
    #[must_use]
    pub const fn velocity(&self) -> f64 {
        self.velocity
    }

    /// Highest acceleration, u/s².
    #[must_use]
    pub const fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Highest deceleration, u/s².
    #[must_use]
    pub const fn deceleration(&self) -> f64 {
        self.deceleration
    }

    /// Highest jerk, u/s³.
    #[must_use]
    pub const fn jerk(&self) -> f64 {
        self.jerk
    }
}

fn checked(field: &'static str, received: f64) -> Result<f64, InvalidLimit> {
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
    /// Which limit.
    pub field: &'static str,
    /// What was given.
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
    fn only_the_velocity_is_replaced() {
        let limits = Limits::new(1.0, 2.0, 3.0, 4.0).unwrap();
        assert_eq!(limits.with_velocity(9.0), Limits::new(9.0, 2.0, 3.0, 4.0));
        assert!(limits.with_velocity(0.0).is_err());
    }
}
