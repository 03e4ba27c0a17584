//! `MC_MotionFunctionPoint`: a pair of master and slave positions, and the law to the next one.

use coaxle_curve::law::MotionLaw;

/// `MC_MotionFunctionPoint`, TF5050 chapter 8.7: one row of a motion function.
///
/// Master positions are in master units (x), slave positions in slave units (u); derivatives are
/// with respect to the master, so `velocity` is in u/x, `acceleration` in u/x², `jerk` in u/x³.
#[doc(alias = "MC_MotionFunctionPoint")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(transform = with_aliases)
)]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct MotionPoint {
    /// Number of the point: from 1, each one more than the row before.
    #[doc(alias = "PointIndex")]
    #[doc(alias = "MC_MotionFunctionPoint_ID")]
    pub index: u32,
    /// The law from this point to the next one. For the last point it is only used if it ends a spline.
    #[doc(alias = "FunctionType")]
    #[cfg_attr(feature = "serde", serde(alias = "law"))]
    pub function: MotionLaw,
    /// Type of the point.
    #[doc(alias = "PointType")]
    #[cfg_attr(feature = "serde", serde(alias = "type"))]
    pub point_type: PointType,
    /// Number of rows to the next point; 1 unless points are skipped. That of the last point is not used.
    #[doc(alias = "RelIndexNextPoint")]
    #[cfg_attr(feature = "serde", serde(default = "one_row_further"))]
    pub relative_next: i32,
    /// Position of the master, x.
    #[doc(alias = "MasterPos")]
    pub master: f64,
    /// Position of the slave, u.
    #[doc(alias = "SlavePos")]
    pub slave: f64,
    /// Velocity of the slave, u/x.
    #[doc(alias = "SlaveVelo")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub velocity: f64,
    /// Acceleration of the slave, u/x².
    #[doc(alias = "SlaveAcc")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub acceleration: f64,
    /// Jerk of the slave, u/x³.
    #[doc(alias = "SlaveJerk")]
    #[cfg_attr(feature = "serde", serde(default))]
    pub jerk: f64,
}

/// Adds the names `law` and `type`, as points have them in a cam file.
#[cfg(feature = "schema")]
fn with_aliases(schema: &mut schemars::Schema) {
    for (field, alias) in [("function", "law"), ("point-type", "type")] {
        // A schema knows no serde aliases, so an editor would mark `law` and `type` as unknown fields.
        if let Some(properties) = schema.get_mut("properties").and_then(|p| p.as_object_mut())
            && let Some(described) = properties.get(field).cloned()
        {
            properties.insert(alias.into(), described);
        }
        // Either name is enough, which `required` cannot express for one of two.
        if let Some(required) = schema.get_mut("required").and_then(|r| r.as_array_mut()) {
            required.retain(|name| name != field);
        }
    }
}

impl MotionPoint {
    /// Makes a point at which the slave rests, and which it leaves by a quintic.
    #[must_use]
    pub const fn rest(index: u32, master: f64, slave: f64) -> Self {
        Self {
            index,
            function: MotionLaw::Polynom5,
            point_type: PointType::Rest,
            relative_next: 1,
            master,
            slave,
            velocity: 0.0,
            acceleration: 0.0,
            jerk: 0.0,
        }
    }
}

#[cfg(feature = "serde")]
const fn one_row_further() -> i32 {
    1
}

/// `MC_MotionPointType`, TF5050 chapter 8.10.
#[doc(alias = "MC_MotionPointType")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u16)]
pub enum PointType {
    /// Not part of the course: a reserved row. Never the first or the last row.
    #[doc(alias = "MOTIONPOINTTYPE_IGNORE")]
    Ignore = 0,
    /// Rest of the slave: velocity and acceleration are 0.
    #[doc(alias = "MOTIONPOINTTYPE_REST")]
    #[default]
    Rest = 0x0001,
    /// Point passed at a velocity: the acceleration is 0.
    #[doc(alias = "MOTIONPOINTTYPE_VELOCITY")]
    Velocity = 0x0002,
    /// Reversal of the slave: the velocity is 0.
    #[doc(alias = "MOTIONPOINTTYPE_TURN")]
    Turn = 0x0004,
    /// Point passed at a velocity and an acceleration.
    #[doc(alias = "MOTIONPOINTTYPE_MOTION")]
    Motion = 0x0008,
    /// Adds segments. The manual gives the name without a course, so such a point is refused: plates are
    /// superposed by coupling more than one.
    #[doc(alias = "MOTIONPOINTTYPE_ADD")]
    Add = 0x0F00,
    /// A marked point. In the manual it has no effect on the course: it is passed like a motion point.
    #[doc(alias = "MOTIONPOINTTYPE_ACTIVATION")]
    Activation = 0x2000,
}

impl PointType {
    /// Types by their codes.
    pub const ALL: [Self; 7] = [
        Self::Ignore,
        Self::Rest,
        Self::Velocity,
        Self::Turn,
        Self::Motion,
        Self::Add,
        Self::Activation,
    ];

    /// Returns the PLC's number of the type.
    #[must_use]
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// Returns the type with that number, if there is one.
    #[must_use]
    pub fn from_code(code: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }

    /// Returns the name of the type in cam files and orders.
    #[must_use]
    pub const fn file_name(self) -> &'static str {
        match self {
            Self::Ignore => "ignore",
            Self::Rest => "rest",
            Self::Velocity => "velocity",
            Self::Turn => "turn",
            Self::Motion => "motion",
            Self::Add => "add",
            Self::Activation => "activation",
        }
    }

    /// True if the slave stands still for a moment in a point of this type.
    #[must_use]
    pub const fn stands_still(self) -> bool {
        matches!(self, Self::Rest | Self::Turn)
    }

    /// True if the slave's velocity is constant for a moment in a point of this type.
    #[must_use]
    pub const fn keeps_its_velocity(self) -> bool {
        matches!(self, Self::Rest | Self::Velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_and_its_code_are_one_to_one() {
        for kind in PointType::ALL {
            assert_eq!(PointType::from_code(kind.code()), Some(kind));
            assert_eq!(std::format!("{kind:?}").to_lowercase(), kind.file_name());
        }
        assert_eq!(PointType::from_code(0x0010), None);
    }
}
