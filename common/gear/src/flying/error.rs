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
    /// At the master's speed the slave would have to do more than it can.
    #[error(
        "{:#06x}: {quantity}: received {received}, expected at most {limit}, with a master at {speed} u/s: lead it \
         at up to {fastest} u/s, or give the slave longer ways to its sync and its stop position",
        self.code()
    )]
    TooFast {
        /// Which limit.
        quantity: &'static str,
        /// What would be needed.
        received: f64,
        /// What the slave can do.
        limit: f64,
        /// How fast the master is, master u/s.
        speed: f64,
        /// How fast it may be, master u/s.
        fastest: f64,
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
            Self::TooFast { .. } => 0x42dd,
        }
    }
}
