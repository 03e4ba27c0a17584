//! What the guard of an axis says no to.

use core::fmt;

/// A motion that an axis does not begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuardRefusal {
    /// A value that is no number or too large for any axis.
    Value {
        /// Which one.
        field: &'static str,
        /// What was given.
        received: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// More than the axis can do.
    AboveLimit {
        /// Which limit.
        field: &'static str,
        /// What was given or would be needed.
        received: f64,
        /// What the axis can do.
        limit: f64,
    },
    /// The motion would leave the software limits.
    SoftwareLimit {
        /// How far it would go, u.
        reached: f64,
        /// The limit, u.
        limit: f64,
    },
}

impl GuardRefusal {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::Value { .. } => 0x4b06,
            Self::AboveLimit { .. } => 0x42dd,
            Self::SoftwareLimit { .. } => 0x4229,
        }
    }
}

impl fmt::Display for GuardRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}: ", self.code())?;
        match self {
            Self::Value {
                field,
                received,
                expected,
            } => write!(f, "{field}: received {received}, expected {expected}"),
            Self::AboveLimit {
                field,
                received,
                limit,
            } => write!(f, "{field}: received {received}, expected at most {limit}"),
            Self::SoftwareLimit { reached, limit } => write!(
                f,
                "the motion would reach {reached}, the software limit is {limit}"
            ),
        }
    }
}

impl core::error::Error for GuardRefusal {}

/// A set value that an axis does not follow: it stops instead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuardFault {
    /// A motion without an end, or a coupling, would have led beyond a software limit.
    SoftwareLimit {
        /// Where the axis could have stopped at the earliest, u.
        reached: f64,
        /// The limit, u.
        limit: f64,
    },
    /// A set value of the coupling that no axis can have.
    OutOfRange {
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
}

impl GuardFault {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::SoftwareLimit { .. } => 0x4229,
            Self::OutOfRange { .. } => 0x42d5,
            Self::BeyondLimit { .. } => 0x42dd,
        }
    }
}

impl fmt::Display for GuardFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}: ", self.code())?;
        match self {
            Self::SoftwareLimit { reached, limit } => write!(
                f,
                "software limit: the axis would stop at {reached}, the limit is {limit}"
            ),
            Self::OutOfRange { quantity, received } => write!(
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

impl core::error::Error for GuardFault {}
