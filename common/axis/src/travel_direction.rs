//! Which way an axis goes.

/// Where an axis goes, or went last.
///
/// Of an axis that is measured in increments this is decided by whole increments: the sign of a velocity that
/// was estimated between two of them is noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TravelDirection {
    /// To larger positions.
    Forward,
    /// To smaller ones.
    Backward,
}

impl TravelDirection {
    /// 1 or -1.
    #[must_use]
    pub const fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
        }
    }

    /// The other one.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}
