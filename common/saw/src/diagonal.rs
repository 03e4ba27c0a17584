//! The diagonal saw: the slave moves at an angle to its master.

use super::command::Ratio;

/// Returns the ratio for which the slave's velocity along the master is `gear_ratio` times the master's:
/// `gear_ratio` / cos(angle), TS5055 9. The angle between the two directions of travel is in degrees.
///
/// # Errors
/// [`DiagonalAngle`] (0x4B06) for an angle that is not finite, or at which the slave does not move along
/// the master.
pub fn diagonal_ratio(angle_degrees: f64, gear_ratio: f64) -> Result<Ratio, DiagonalAngle> {
    // From the nearest right angle: there the cosine of a rounded angle would lose its digits.
    let turns = angle_degrees / 180.0;
    let from_right_angle = (turns - 0.5) - libm::round(turns - 0.5);
    let sine = libm::sin(from_right_angle * core::f64::consts::PI).abs();
    // Exactly zero: near a right angle the ratio is large, and the limit of the velocity refuses it.
    if !angle_degrees.is_finite() || sine == 0.0 {
        return Err(DiagonalAngle { angle_degrees });
    }
    let along = libm::cos(angle_degrees.to_radians());
    // |cos φ| = |sin(φ − 90°)|. Beyond 90° the slave runs
    // against its master, so the sign is that of the cosine.
    Ok(Ratio::of(gear_ratio / sine.copysign(along)))
}

/// Angle at which no saw can follow.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("0x4b06: angle {angle_degrees}°, expected a finite angle other than ±90°")]
pub struct DiagonalAngle {
    /// Angle received, degrees.
    pub angle_degrees: f64,
}

impl DiagonalAngle {
    /// Returns the NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x4b06
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_component_along_the_master_has_the_gear_ratio() {
        for angle in [-80.0, -30.0, 0.0, 45.0, 60.0, 89.9, 120.0] {
            let ratio = diagonal_ratio(angle, 1.5).unwrap().numerator;
            let along = ratio * libm::cos(f64::to_radians(angle));
            // At 89.9° the ratio is 859, and its rounding with it.
            assert!((along - 1.5).abs() < 1e-12, "{angle}: {ratio}");
        }
        assert!((diagonal_ratio(60.0, 1.0).unwrap().numerator - 2.0).abs() < 1e-15);
    }

    #[test]
    fn a_right_angle_is_refused() {
        for angle in [90.0, -90.0, 270.0, f64::NAN, f64::INFINITY] {
            assert_eq!(diagonal_ratio(angle, 1.0).unwrap_err().code(), 0x4b06);
        }
    }
}
