//! Reasons of a refused synchronisation.

use coaxle_curve::figure::{Beyond, Rounded, UpTo};

use super::SyncMask;

/// A refused synchronisation. A refusal never moves the slave.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SawRefusal {
    /// A gear ratio of zero: 0x421B.
    #[error("{:#06x}: ratio numerator {numerator}, expected a finite number other than 0", self.code())]
    RatioZero {
        /// The numerator received.
        numerator: f64,
    },
    /// A gear ratio with denominator zero: 0x4B06.
    #[error("{:#06x}: ratio denominator 0, expected 1 to 65535", self.code())]
    DenominatorZero,
    /// An input that is not a finite number: 0x4B06.
    #[error("{:#06x}: {field}: received {received}, expected a finite number", self.code())]
    NotFinite {
        /// Name of the input.
        field: &'static str,
        /// Value received.
        received: f64,
    },
    /// A limit that no motion can keep: 0x42DD.
    #[error("{:#06x}: {field}: received {received}, expected a finite number above 0", self.code())]
    Limit {
        /// Name of the limit.
        field: &'static str,
        /// Value received; expected is a finite number above 0.
        received: f64,
    },
    /// A synchronous velocity beyond the axis's own greatest velocity, or, with a strategy, beyond that
    /// of the command: 0x42DD.
    #[error("{:#06x}: synchronous velocity {} u/s, the highest allowed is {} u/s", self.code(), Beyond { value: *velocity, limit: *limit }, Rounded(*limit))]
    SyncVelocity {
        /// The synchronous velocity, u/s.
        velocity: f64,
        /// The greatest permitted velocity, u/s.
        limit: f64,
    },
    /// A time-based profile to a position: 0x4B04, as in the manual.
    #[error("{:#06x}: time-based mode, expected position-based to synchronise to a position", self.code())]
    TimeBasedPosition,
    /// A synchronisation position of the master that is not ahead of it: 0x42DE.
    #[error("{:#06x}: master synchronisation position {sync_position} u is not ahead of the master at {} u, {} u/s", self.code(), Rounded(*position), Rounded(*velocity))]
    MasterNotAhead {
        /// Position of the master, u.
        position: f64,
        /// Velocity of the master, u/s.
        velocity: f64,
        /// Synchronisation position of the master, u.
        sync_position: f64,
    },
    /// A synchronisation position of the slave that is not ahead of it in the gear's direction: 0x42DE.
    #[error("{:#06x}: slave synchronisation position {sync_position} u, expected it {} the slave at {} u", self.code(), side(.direction), Rounded(*position))]
    SlaveNotAhead {
        /// Position of the slave, u.
        position: f64,
        /// Synchronisation position of the slave, u.
        sync_position: f64,
        /// Direction in which the gear moves it: 1 or −1.
        direction: f64,
    },
    /// A master at rest while the slave moves: 0x426E.
    #[error("{:#06x}: the master stands while the slave moves at {} u/s, {} u/s²", self.code(), Rounded(*slave_velocity), Rounded(*slave_acceleration))]
    MasterAtRest {
        /// The slave's velocity, u/s.
        slave_velocity: f64,
        /// The slave's acceleration, u/s².
        slave_acceleration: f64,
    },
    /// A master at rest with a strategy that needs a moving one: 0x426E.
    #[error("{:#06x}: the master stands, expected it to move towards its synchronisation position; \"early\" needs no master that moves", self.code())]
    MasterStands,
    /// A slave that cannot arrive in time within its limits, with a strategy: 0x42DF.
    #[error("{:#06x}: the slave needs {} s within its limits, its master is there in {} s", self.code(), Beyond { value: *needed, limit: *available }, Rounded(*available))]
    TooShort {
        /// Least time needed by the slave, s.
        needed: f64,
        /// Time available until the master arrives, s.
        available: f64,
    },
    /// A gear as fast as the slave's limit, or checks that permit no other velocity: 0x42DD.
    #[error("{:#06x}: synchronous velocity {} u/s where {} u/s is allowed: nothing is left to make up the distance", self.code(), Rounded(*velocity), UpTo(*limit))]
    NothingLeft {
        /// The synchronous velocity, u/s.
        velocity: f64,
        /// The greatest permitted velocity, u/s.
        limit: f64,
    },
    /// An invalid start distance of the master: 0x4B06.
    #[error("{:#06x}: master-start-distance: received {received}, expected a finite number above 0", self.code())]
    StartDistance {
        /// Value received; expected is a finite number above 0.
        received: f64,
    },
    /// A slave's acceleration from which no change of velocity keeps the limits: 0x42DF.
    #[error("{:#06x}: no ramp from the slave's acceleration of {} u/s² keeps the limits", self.code(), Rounded(*slave_acceleration))]
    NoRamp {
        /// The slave's acceleration, u/s².
        slave_acceleration: f64,
    },
    /// A table needed for the profile that is in use: 0x4063.
    #[error("{:#06x}: table {table} is in use", self.code())]
    TableInUse {
        /// Id of the table.
        table: u32,
    },
    /// An axis id without a table, since it is not from 1 to 255: 0x4A00.
    #[error("{:#06x}: axis id {axis_id}, expected 1 to 255", self.code())]
    NoTable {
        /// The axis id.
        axis_id: u32,
    },
    /// A violated check of the profile.
    #[error("{:#06x}: {}", self.code(), .0)]
    Violation(Violation),
}

/// A violated check of a profile.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{}: {} {unit} where {} {unit} is allowed, at master position {} u",
    self.check.text(), Beyond { value: *measured, limit: *limit }, Rounded(*limit), Rounded(*master_position),
    unit = check.quantity_and_unit().1
)]
pub struct Violation {
    /// Violated check.
    pub check: Check,
    /// Value of the profile: u, u/s, u/s² or u/s³ by the check.
    pub measured: f64,
    /// Greatest permitted value (least, for lower bounds).
    pub limit: f64,
    /// Master position of the violation, u.
    pub master_position: f64,
    /// True if detailed error codes were requested.
    pub detailed: bool,
}

macro_rules! checks {
    ($($(#[$meta:meta])* $variant:ident = $code:literal, $text:literal;)*) => {
        /// The checks of TF5055 8.1, by detailed error code.
        ///
        /// Forwards and backwards is the direction of the master for velocities, and the direction to the
        /// synchronisation position for positions.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Check {
            $($(#[$meta])* #[doc = $text] $variant = $code,)*
        }

        impl Check {
            /// Complete list.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            const fn text(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }
        }
    };
}

checks! {
    MinPos = 0x4372, "position below the axis's lower limit";
    MaxPos = 0x4373, "position above the axis's upper limit";
    OptionalMinPos = 0x4374, "position below the command's lower limit";
    OptionalMaxPos = 0x4375, "position above the command's upper limit";
    UndershootPosBackward = 0x4376, "position below the synchronisation position, which lies below the start";
    UndershootPosForward = 0x4377, "position below the start position";
    OvershootPosBackward = 0x4378, "position above the start position, the synchronisation position lies below it";
    OvershootPosForward = 0x4379, "position above the synchronisation position";
    MaxVelo = 0x437a, "velocity above the limit";
    MinVelo = 0x437b, "velocity below the limit, in the negative direction";
    OvershootVeloForwardFromBelow = 0x437c, "velocity above the synchronous velocity, master forwards";
    OvershootVeloForwardFromAbove = 0x437d, "velocity above the start velocity, master forwards";
    OvershootVeloBackwardFromBelow = 0x437e, "velocity above the synchronous velocity, master backwards";
    OvershootVeloBackwardFromAbove = 0x437f, "velocity above the start velocity, master backwards";
    UndershootVeloForwardFromAbove = 0x4380, "velocity below the synchronous velocity, master forwards";
    UndershootVeloForwardFromBelow = 0x4381, "velocity below the start velocity, master forwards";
    UndershootVeloBackwardFromAbove = 0x4382, "velocity below the synchronous velocity, master backwards";
    UndershootVeloBackwardFromBelow = 0x4383, "velocity below the start velocity, master backwards";
    OvershootVeloZeroForward = 0x4384, "velocity above zero, master forwards";
    OvershootVeloZeroBackward = 0x4385, "velocity above zero, master backwards";
    UndershootVeloZeroForward = 0x4386, "velocity below zero, master forwards";
    UndershootVeloZeroBackward = 0x4387, "velocity below zero, master backwards";
    MaxAcc = 0x4388, "acceleration above the limit";
    MaxDec = 0x4389, "deceleration above the limit";
    MaxJerk = 0x438a, "jerk above the limit";
    MinJerk = 0x438b, "jerk below the limit, in the negative direction";
}

impl Check {
    /// Returns the detailed error code.
    #[must_use]
    pub const fn code(self) -> u32 {
        self as u32
    }
}

impl Check {
    /// Returns the flag of the sync mode that enables the check.
    #[must_use]
    pub const fn flag(self) -> SyncMask {
        match self {
            Self::MinPos => SyncMask::MIN_POS,
            Self::MaxPos => SyncMask::MAX_POS,
            Self::OptionalMinPos => SyncMask::OPTIONAL_MIN_POS,
            Self::OptionalMaxPos => SyncMask::OPTIONAL_MAX_POS,
            Self::UndershootPosBackward | Self::UndershootPosForward => SyncMask::UNDERSHOOT_POS,
            Self::OvershootPosBackward | Self::OvershootPosForward => SyncMask::OVERSHOOT_POS,
            Self::MaxVelo | Self::MinVelo => SyncMask::MAX_VELO,
            Self::OvershootVeloForwardFromBelow
            | Self::OvershootVeloForwardFromAbove
            | Self::OvershootVeloBackwardFromBelow
            | Self::OvershootVeloBackwardFromAbove => SyncMask::OVERSHOOT_VELO,
            Self::UndershootVeloForwardFromAbove
            | Self::UndershootVeloForwardFromBelow
            | Self::UndershootVeloBackwardFromAbove
            | Self::UndershootVeloBackwardFromBelow => SyncMask::UNDERSHOOT_VELO,
            Self::OvershootVeloZeroForward | Self::OvershootVeloZeroBackward => {
                SyncMask::OVERSHOOT_VELO_ZERO
            }
            Self::UndershootVeloZeroForward | Self::UndershootVeloZeroBackward => {
                SyncMask::UNDERSHOOT_VELO_ZERO
            }
            Self::MaxAcc => SyncMask::MAX_ACC,
            Self::MaxDec => SyncMask::MAX_DEC,
            Self::MaxJerk | Self::MinJerk => SyncMask::MAX_JERK,
        }
    }

    /// Returns the quantity of the check: `position`, `velocity`, `acceleration` or `jerk`.
    #[must_use]
    pub const fn quantity(self) -> &'static str {
        self.quantity_and_unit().0
    }

    const fn quantity_and_unit(self) -> (&'static str, &'static str) {
        match self {
            Self::MaxAcc | Self::MaxDec => ("acceleration", "u/s²"),
            Self::MaxJerk | Self::MinJerk => ("jerk", "u/s³"),
            // By its flag, so that a further check of a position needs no line here.
            _ if SyncMask::POSITIONS.contains(self.flag()) => ("position", "u"),
            _ => ("velocity", "u/s"),
        }
    }
}

impl Violation {
    /// Returns the error code: the check's own, or the common one if details were not requested.
    #[must_use]
    pub const fn code(&self) -> u32 {
        if self.detailed {
            self.check.code()
        } else {
            0x42df
        }
    }

    /// Excess over the limit, in the unit of the quantity.
    #[must_use]
    pub fn excess(&self) -> f64 {
        // A magnitude: lower bounds are violated downwards.
        (self.measured - self.limit).abs()
    }
}

impl SawRefusal {
    /// Returns the NC error code.
    #[doc(alias = "ErrorID")]
    #[must_use]
    pub const fn code(&self) -> u32 {
        match self {
            Self::RatioZero { .. } => 0x421b,
            Self::DenominatorZero | Self::NotFinite { .. } | Self::StartDistance { .. } => 0x4b06,
            Self::Limit { .. } | Self::SyncVelocity { .. } | Self::NothingLeft { .. } => 0x42dd,
            Self::TimeBasedPosition => 0x4b04,
            Self::MasterNotAhead { .. } | Self::SlaveNotAhead { .. } => 0x42de,
            Self::MasterAtRest { .. } | Self::MasterStands => 0x426e,
            // Dynamics that do not suffice: the code of a violated check, without one of its own.
            Self::NoRamp { .. } | Self::TooShort { .. } => 0x42df,
            Self::TableInUse { .. } => 0x4063,
            Self::NoTable { .. } => 0x4a00,
            Self::Violation(violation) => violation.code(),
        }
    }

    /// Returns the violated check, if that is the reason.
    #[must_use]
    pub const fn violation(&self) -> Option<&Violation> {
        match self {
            Self::Violation(violation) => Some(violation),
            _ => None,
        }
    }
}

impl From<Violation> for SawRefusal {
    fn from(violation: Violation) -> Self {
        Self::Violation(violation)
    }
}

/// Returns the side from which a slave has to approach a position in this direction.
const fn side(direction: &f64) -> &'static str {
    if *direction > 0.0 { "above" } else { "below" }
}
