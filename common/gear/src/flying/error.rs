//! Reasons why a flying gear is refused.

use coaxle_curve::figure::{Beyond, Rounded, UpTo};
use coaxle_curve::law::Quantity;

/// Reason why a flying gear is not enabled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FlyingGearError {
    /// A ratio of zero or not finite.
    #[error("{:#06x}: ratio: received {received}, expected a finite number other than 0", self.code())]
    Ratio {
        /// Value received.
        received: f64,
    },
    /// An invalid position.
    #[error("{:#06x}: {parameter}: received {received}, expected {expected}", self.code())]
    WrongParameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value received.
        received: f64,
        /// Permitted values.
        expected: &'static str,
    },
    /// A master already past the position where engaging begins.
    #[error("{:#06x}: master position: received {master}, expected one not past {}, where the gear begins to be engaged", self.code(), Rounded(*start), master = Rounded(*master))]
    MasterPastStart {
        /// Position of the master, master u.
        master: f64,
        /// Position at which engaging begins, master u.
        start: f64,
    },
    /// A demand beyond the slave's limit at the master's speed.
    #[error(
        "{:#06x}: {quantity}: received {} {unit}, expected at most {} {unit}, with a master at {} u/s: lead it \
         at up to {} u/s, or give the slave longer ways to its sync and its stop position",
        self.code(), Beyond { value: *received, limit: *limit }, Rounded(*limit), Rounded(*speed), UpTo(*fastest),
        unit = quantity.unit()
    )]
    TooFast {
        /// Limited quantity.
        quantity: Quantity,
        /// Value needed.
        received: f64,
        /// Limit of the slave.
        limit: f64,
        /// Speed of the master, master u/s.
        speed: f64,
        /// Greatest speed of the master, master u/s.
        fastest: f64,
    },
}

impl FlyingGearError {
    /// Returns the NC error code.
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
