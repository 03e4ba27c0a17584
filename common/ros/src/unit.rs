//! Units: ROS has metres and radians (REP 103), an axis the unit of its config.

use std::f64::consts::{PI, TAU};

/// Number of metres or radians in a unit of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitScale(f64);

/// The units that are known.
pub const KNOWN: &str = "m, dm, cm, mm, µm, um, nm, in, inch, rad, mrad, °, deg, rev";

impl UnitScale {
    /// Scale of values that are passed on unchanged.
    pub const NONE: Self = Self(1.0);

    /// Returns the scale of the unit with this text; none if that is not a known length or angle.
    #[must_use]
    pub fn of(unit: &str) -> Option<Self> {
        let scale = match unit {
            "m" | "rad" => 1.0,
            "dm" => 0.1,
            "cm" => 0.01,
            "mm" | "mrad" => 1e-3,
            // The micro sign and the Greek letter have the same shape.
            "µm" | "μm" | "um" => 1e-6,
            "nm" => 1e-9,
            "in" | "inch" => 0.0254,
            "°" | "deg" => PI / 180.0,
            "rev" => TAU,
            // `u` and other texts are no error: values pass unchanged, and the log names the unit once.
            _ => return None,
        };
        Some(Self(scale))
    }

    /// Converts from units of the axis, or those per second.
    #[must_use]
    pub fn to_ros(self, value: f64) -> f64 {
        value * self.0
    }

    /// Converts to units of the axis.
    #[must_use]
    pub fn from_ros(self, value: f64) -> f64 {
        value / self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lengths_are_metres_and_angles_radians() {
        let ros = |unit: &str, value| UnitScale::of(unit).unwrap().to_ros(value);
        assert_eq!(ros("mm", 1500.0), 1.5);
        assert_eq!(ros("m", 2.0), 2.0);
        assert!((ros("°", 180.0) - PI).abs() < 1e-15);
        assert!((ros("rev", 0.5) - PI).abs() < 1e-15);
        for unknown in ["u", "", "pcs", "MM", "m/s", "%"] {
            assert_eq!(UnitScale::of(unknown), None, "{unknown}");
        }
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_same(known in 0..14_usize, value in -1e9..1e9) {
            let unit = KNOWN.split(", ").nth(known).unwrap();
            let scale = UnitScale::of(unit).unwrap();
            let back = scale.from_ros(scale.to_ros(value));
            // A product and a quotient are each rounded once, to 1e-16.
            prop_assert!((back - value).abs() <= 1e-12 * value.abs());
        }
    }
}
