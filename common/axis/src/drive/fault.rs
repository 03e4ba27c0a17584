//! Faults of drives.

/// Reason why a drive has tripped.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DriveFault {
    /// Following error too large for too long.
    #[error("following error of {following_error} for too long, the drive tripped")]
    FollowingError {
        /// The following error when it tripped, u.
        following_error: f64,
    },
    /// No drive process attached at power on.
    #[error("the drive is not ready: no drive process is attached, expected one")]
    NotAttached,
    /// Drive that did not follow in time after power on.
    #[error("the drive is not ready: told to have power {cycles} cycles ago, it does not follow")]
    NotReady {
        /// Cycles waited.
        cycles: u32,
    },
    /// Stopped heartbeat of the drive process.
    #[error("no heartbeat of the drive process for {cycles} cycles, expected one within {most}")]
    Silent {
        /// Cycles without a heartbeat.
        cycles: u32,
        /// Greatest number allowed.
        most: u32,
    },
    /// Error reported by the drive.
    #[error("the drive reports its error {error:#x}")]
    Reported {
        /// Error code of the drive.
        error: u32,
    },
    /// Drive that stopped following without a command.
    #[error("the drive no longer follows, and nobody told it so")]
    PowerLost,
    /// Position of the drive differs from its axis's, which has to stand within the software limits.
    #[error(
        "the drive is at {received}, expected it within {window} of {expected}, where the axis may stand"
    )]
    PositionMismatch {
        /// Position of the drive, u.
        received: f64,
        /// Standstill position of the axis, u, in the drive's positions.
        expected: f64,
        /// Greatest distance allowed, u.
        window: f64,
    },
    /// Unknown state of the drive.
    #[error(
        "the drive process says state {received}, expected 0 (off), 1 (following) or 2 (error)"
    )]
    UnknownState {
        /// State reported.
        received: u64,
    },
    /// Actual value out of range for an axis.
    #[error("{field} of the drive: received {received}, expected a number from -1e12 to 1e12")]
    Implausible {
        /// Name of the value.
        field: &'static str,
        /// The value.
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
            | Self::PositionMismatch { .. } => 0x4650,
            // Invalid values, against 0x4650 for a drive that is not ready.
            Self::Silent { .. } | Self::UnknownState { .. } | Self::Implausible { .. } => 0x4655,
        }
    }
}
