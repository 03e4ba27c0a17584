//! Dynamics of a motion.

/// The dynamics of a command; each at most the limit of the axis, which is the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(
    feature = "serde",
    serde(default, rename_all = "kebab-case", deny_unknown_fields)
)]
pub struct Dynamics {
    /// Highest acceleration, u/s².
    pub acceleration: Option<f64>,
    /// Highest deceleration, u/s².
    pub deceleration: Option<f64>,
    /// Highest jerk, u/s³.
    pub jerk: Option<f64>,
}
