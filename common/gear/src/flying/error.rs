//! Why a flying gear is refused.

/// Why a flying gear is not enabled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FlyingGearError {
    /// The ratio couples nothing.
    #[error("{:#06x}: ratio: received {received}, expected a finite number other than 0", self.code())]
    Ratio {
        /// What was given.
        received: f64,
    },
    /// A position that makes no gear.
    #[error("{:#06x}: {parameter}: received {received}, expected {expected}", self.code())]
    WrongParameter {
        /// Which one.
        parameter: &'static str,
        /// What was given.
        received: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// The master is already past the point where the gear begins to be engaged.
    #[error("{:#06x}: master position: received {master}, expected one not past {start}, where the gear begins to be engaged", self.code())]
    MasterPastStart {
        /// Where the master is, master u.
        master: f64,
        /// Where it must not be past, master u.
        start: f64,
    },
}

impl FlyingGearError {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::Ratio { .. } => 0x421b,
            Self::WrongParameter { .. } => 0x425b,
            Self::MasterPastStart { .. } => 0x421a,
        }
    }
}
