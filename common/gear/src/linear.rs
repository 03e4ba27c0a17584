//! The linear gear: slave = ratio · master + offset.

use coaxle_curve::profile::Kinematics;

/// A slave coupled to its master by a constant ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearGear {
    ratio: f64,
    offset: f64,
}

/// Error of an invalid gear ratio or offset: NC error 0x421B.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "0x421b: gear ratio {ratio} with offset {offset}, expected a finite ratio other than 0 and a finite offset"
)]
pub struct RatioZero {
    /// The ratio received.
    pub ratio: f64,
    /// The offset received, u.
    pub offset: f64,
}

impl RatioZero {
    /// Returns the NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x421b
    }
}

impl LinearGear {
    /// Makes a gear of slave units per master unit, and the slave's position at master position 0.
    ///
    /// # Errors
    /// [`RatioZero`] unless the ratio is finite and not 0, and the offset finite.
    pub fn new(ratio: f64, offset: f64) -> Result<Self, RatioZero> {
        // NaN passes `!= 0.0`, so finiteness is a condition of its own.
        if ratio.is_finite() && ratio != 0.0 && offset.is_finite() {
            Ok(Self { ratio, offset })
        } else {
            Err(RatioZero { ratio, offset })
        }
    }

    /// Makes the gear of a ratio, unchecked, through a position of the slave and one of the master.
    // A ramp has accepted the ratio before, so there is nothing left to refuse within a cycle.
    pub(super) const fn through(ratio: f64, slave: f64, master: f64) -> Self {
        Self {
            ratio,
            offset: slave - ratio * master,
        }
    }

    /// Returns the slave units per master unit.
    #[must_use]
    pub const fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Returns the slave's position at master position 0, u.
    #[must_use]
    pub const fn offset(&self) -> f64 {
        self.offset
    }

    /// Returns the slave's set values for those of the master.
    #[must_use]
    pub fn slave_of(&self, master: &Kinematics) -> Kinematics {
        Kinematics {
            // From the master's position, not from its distance
            // per cycle: rounding does not add up over days.
            position: self.ratio * master.position + self.offset,
            velocity: self.ratio * master.velocity,
            acceleration: self.ratio * master.acceleration,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slave_follows_in_proportion() {
        let gear = LinearGear::new(-2.5, 10.0).unwrap();
        let master = Kinematics {
            position: 4.0,
            velocity: 3.0,
            acceleration: 2.0,
        };
        // Small binary fractions: −2.5·4 + 10 and the other
        // figures are exact, so they are compared by equality.
        let slave = gear.slave_of(&master);
        assert_eq!(slave.position, 0.0);
        assert_eq!(slave.velocity, -7.5);
        assert_eq!(slave.acceleration, -5.0);
    }

    #[test]
    fn a_ratio_that_couples_nothing_is_refused() {
        for (ratio, offset) in [(0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::INFINITY)] {
            assert!(LinearGear::new(ratio, offset).is_err());
        }
    }
}
