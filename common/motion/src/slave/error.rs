//! What brings a slave axis to an error stop.

use core::fmt;

use crate::cam::coupling::CouplingError;
use crate::saw::SawFault;

/// Why a slave axis is in error stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlaveError {
    /// The drive tripped: its following error was too large for too long.
    FollowingError {
        /// The following error when it tripped, u.
        following_error: f64,
    },
    /// The axis was coupled and its master was lost or in error.
    MasterLost,
    /// A motion without an end, or a coupling, would have led beyond a software limit.
    SoftwareLimit {
        /// Where the axis could have stopped at the earliest, u.
        reached: f64,
        /// The limit, u.
        limit: f64,
    },
    /// A set value of the coupling that no axis can have.
    AbsurdSetValue {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        received: f64,
    },
    /// A set value of the coupling that this axis cannot follow.
    BeyondLimit {
        /// Which limit.
        quantity: &'static str,
        /// What the coupling asks for.
        received: f64,
        /// What the axis can do.
        limit: f64,
    },
    /// The coupling by cam plates broke off.
    Cam(CouplingError),
    /// The coupling by a flying saw failed.
    Saw(SawFault),
}

impl SlaveError {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::FollowingError { .. } => 0x4550,
            Self::MasterLost => 0x42a0,
            Self::SoftwareLimit { .. } => 0x4229,
            Self::AbsurdSetValue { .. } => 0x42d5,
            Self::BeyondLimit { .. } => 0x42dd,
            Self::Cam(error) => error.code(),
            Self::Saw(fault) => fault.code(),
        }
    }
}

impl fmt::Display for SlaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cam(error) => return error.fmt(f),
            Self::Saw(fault) => return fault.fmt(f),
            _ => write!(f, "{:#06x}: ", self.code())?,
        }
        match self {
            Self::Cam(_) | Self::Saw(_) => Ok(()),
            Self::FollowingError { following_error } => write!(
                f,
                "following error of {following_error} for too long, the drive tripped"
            ),
            Self::MasterLost => f.write_str("the master of the coupled axis was lost or in error"),
            Self::SoftwareLimit { reached, limit } => write!(
                f,
                "software limit: the axis would stop at {reached}, the limit is {limit}"
            ),
            Self::AbsurdSetValue { quantity, received } => write!(
                f,
                "{quantity} of the coupling: received {received}, expected a number of at most 1e12"
            ),
            Self::BeyondLimit {
                quantity,
                received,
                limit,
            } => write!(
                f,
                "{quantity} of the coupling: received {received}, expected at most {limit}"
            ),
        }
    }
}

impl core::error::Error for SlaveError {}
