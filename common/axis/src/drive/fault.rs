//! Why a drive has tripped.

/// Why a drive has tripped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DriveFault {
    /// Its following error was too large for too long.
    #[error("following error of {following_error} for too long, the drive tripped")]
    FollowingError {
        /// The following error when it tripped, u.
        following_error: f64,
    },
    /// No drive process was attached when the drive was to have power.
    #[error("the drive is not ready: no drive process is attached, expected one")]
    NotAttached,
    /// The drive was told to have power, and did not follow in time.
    #[error("the drive is not ready: told to have power {cycles} cycles ago, it does not follow")]
    NotReady {
        /// Cycles waited.
        cycles: u32,
    },
    /// The heartbeat of the drive process stopped.
    #[error("no heartbeat of the drive process for {cycles} cycles, expected one within {most}")]
    Silent {
        /// Cycles without.
        cycles: u32,
        /// So many may pass.
        most: u32,
    },
    /// The drive reports an error of its own.
    #[error("the drive reports its error {error:#x}")]
    Reported {
        /// Its own code.
        error: u32,
    },
    /// The drive no longer follows, and nobody told it so.
    #[error("the drive no longer follows, and nobody told it so")]
    PowerLost,
    /// The drive is elsewhere than its axis, whose software limits say where it may stand.
    #[error(
        "the drive is at {received}, expected it within {window} of {expected}, where the axis may stand"
    )]
    Elsewhere {
        /// Where the drive is, u.
        received: f64,
        /// Where the axis stands, u, in the drive's positions.
        expected: f64,
        /// So far off it may be, u.
        window: f64,
    },
    /// The drive is in a state that there is none of.
    #[error(
        "the drive process says state {received}, expected 0 (off), 1 (following) or 2 (error)"
    )]
    UnknownState {
        /// What it said.
        received: u64,
    },
    /// An actual value is none that an axis can have.
    #[error("{field} of the drive: received {received}, expected a number from -1e12 to 1e12")]
    Implausible {
        /// Which one.
        field: &'static str,
        /// What it was.
        received: f64,
    },
}

impl DriveFault {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::FollowingError { .. } => 0x4550,
            Self::NotAttached
            | Self::NotReady { .. }
            | Self::Reported { .. }
            | Self::PowerLost
            | Self::Elsewhere { .. } => 0x4650,
            Self::Silent { .. } | Self::UnknownState { .. } | Self::Implausible { .. } => 0x4655,
        }
    }
}
