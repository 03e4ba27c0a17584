//! What the guard of an axis says no to.

/// A motion that an axis does not begin.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GuardRefusal {
    /// A value that is no number or too large for any axis.
    #[error("{:#06x}: {field}: received {received}, expected {expected}", self.code())]
    Value {
        /// Which one.
        field: &'static str,
        /// What was given.
        received: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// More than the axis can do.
    #[error("{:#06x}: {field}: received {received}, expected at most {limit}", self.code())]
    AboveLimit {
        /// Which limit.
        field: &'static str,
        /// What was given or would be needed.
        received: f64,
        /// What the axis can do.
        limit: f64,
    },
    /// The motion would leave the software limits.
    #[error("{:#06x}: the motion would reach {reached}, the software limit is {limit}", self.code())]
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

/// A set value that an axis does not follow: it stops instead.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GuardFault {
    /// A motion without an end, or a coupling, would have led beyond a software limit.
    #[error("{:#06x}: software limit: the axis would stop at {reached}, the limit is {limit}", self.code())]
    SoftwareLimit {
        /// Where the axis could have stopped at the earliest, u.
        reached: f64,
        /// The limit, u.
        limit: f64,
    },
    /// A set value of the coupling that no axis can have.
    #[error("{:#06x}: {quantity} of the coupling: received {received}, expected a number of at most 1e12", self.code())]
    OutOfRange {
        /// Which one.
        quantity: &'static str,
        /// Its value.
        received: f64,
    },
    /// The limits of the axis have left it away from where its coupling has it, for too long.
    #[error(
        "{:#06x}: the axis is {} away from where its coupling has it, which asks for more than the axis can do; \
         expected at most {window} for that long",
        self.code(), distance.abs()
    )]
    LeftBehind {
        /// How far from there, u: the position of the axis less that of its coupling.
        distance: f64,
        /// What it may be, u.
        window: f64,
    },
}

impl GuardFault {
    /// NC error code.
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::SoftwareLimit { .. } => 0x4229,
            Self::OutOfRange { .. } => 0x42d5,
            Self::LeftBehind { .. } => 0x42dd,
        }
    }
}
