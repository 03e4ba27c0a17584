//! Why a flying gear is refused.

use core::fmt;

/// Why a flying gear is not enabled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlyingGearError {
    /// The ratio couples nothing.
    Ratio {
        /// What was given.
        received: f64,
    },
    /// A position that makes no gear.
    WrongParameter {
        /// Which one.
        parameter: &'static str,
        /// What was given.
        received: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// The master is already past the point where the gear begins to be engaged.
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

impl fmt::Display for FlyingGearError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}: ", self.code())?;
        match self {
            Self::Ratio { received } => write!(
                f,
                "ratio: received {received}, expected a finite number other than 0"
            ),
            Self::WrongParameter {
                parameter,
                received,
                expected,
            } => write!(f, "{parameter}: received {received}, expected {expected}"),
            Self::MasterPastStart { master, start } => write!(
                f,
                "master position: received {master}, expected one not past {start}, where the gear begins to be engaged"
            ),
        }
    }
}

impl core::error::Error for FlyingGearError {}
