//! Directions of travel.

/// Current or last direction of travel of an axis.
///
/// For an axis measured in increments, whole increments decide: the sign of a velocity estimated
/// between two of them is noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum TravelDirection {
    /// To larger positions.
    #[default]
    Forward,
    /// To smaller positions.
    Backward,
}

impl TravelDirection {
    /// Sign, 1 or -1.
    #[must_use]
    pub const fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }

    /// The opposite direction.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}
