//! Refusals and faults of the guard of an axis.

/// Refusal to begin a motion.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GuardRefusal {
    /// Value that is not a number or too large for any axis.
    #[error("{:#06x}: {field}: received {received}, expected {expected}", self.code())]
    Value {
        /// Name of the value.
        field: &'static str,
        /// Value received.
        received: f64,
        /// Value expected.
        expected: &'static str,
    },
    /// Value above a limit of the axis.
    #[error("{:#06x}: {field}: received {received}, expected at most {limit}", self.code())]
    AboveLimit {
        /// Name of the limit.
        field: &'static str,
        /// Value received, or needed.
        received: f64,
        /// Limit of the axis.
        limit: f64,
    },
    /// Motion that would leave the software limits.
    #[error("{:#06x}: the motion would reach {reached}, the software limit is {limit}", self.code())]
    SoftwareLimit {
        /// Position that would be reached, u.
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
            // Shared with `LeftBehind`: in both the axis is asked for more than its limits allow.
            Self::AboveLimit { .. } => 0x42dd,
            Self::SoftwareLimit { .. } => 0x4229,
        }
    }
}

/// Fault of set values that an axis does not follow: it stops instead.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GuardFault {
    /// Motion without an end, or coupling, that would have led beyond a software limit.
    #[error("{:#06x}: software limit: the axis would stop at {reached}, the limit is {limit}", self.code())]
    SoftwareLimit {
        /// Earliest position at which the axis could have stopped, u.
        reached: f64,
        /// The limit, u.
        limit: f64,
    },
    /// Set value of the coupling that is impossible for any axis.
    #[error("{:#06x}: {quantity} of the coupling: received {received}, expected a number of at most 1e12", self.code())]
    OutOfRange {
        /// Name of the value.
        quantity: &'static str,
        /// The value.
        received: f64,
    },
    /// Axis held by its limits away from the position of its coupling, for too long.
    #[error(
        "{:#06x}: the axis is {} away from where its coupling has it, which asks for more than the axis can do; \
         expected at most {window} for that long",
        self.code(), distance.abs()
    )]
    LeftBehind {
        /// Distance from there, u: the position of the axis less that of its coupling.
        distance: f64,
        /// Greatest distance allowed, u.
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
