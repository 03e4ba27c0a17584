//! Why a command is refused.

use core::fmt;

use coaxle_axis::guard::GuardRefusal;
use coaxle_axis::{AxisStatus, Transition};
use coaxle_cam::CouplingError;
use coaxle_gear::{FlyingGearError, RatioZero};
use coaxle_saw::SawRefusal;

/// Why a command is refused. Nothing has changed by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// The axis takes no such command in its state.
    Status {
        /// The command, by its PLC name.
        command: &'static str,
        /// Its arrow in the state diagram.
        transition: Transition,
        /// The state of the axis.
        status: AxisStatus,
    },
    /// The axis has to be at rest first.
    NotAtRest {
        /// Its set velocity, u/s.
        velocity: f64,
    },
    /// The axis cannot, or may not, do that much.
    Guard(GuardRefusal),
    /// There is no master to couple to, or it is in error.
    NoMaster,
    /// Coupling here and now would be a jump of the velocity.
    VelocityJump {
        /// The slave's velocity, u/s.
        velocity: f64,
        /// The velocity that it would be coupled to, u/s.
        coupled: f64,
        /// The largest difference that is no jump, u/s.
        allowed: f64,
    },
    /// The ratio couples nothing.
    Gear(RatioZero),
    /// The flying gear cannot be enabled.
    FlyingGear(FlyingGearError),
    /// The coupling by cam plates, or the change to it, is not possible.
    Cam(CouplingError),
    /// The flying saw is not possible.
    Saw(SawRefusal),
    /// The slave has had no flying saw yet, and so no characteristic values.
    NoCharacteristics,
    /// The slave has no limits: it follows its gear, and nothing else.
    NoLimits {
        /// The command, by its PLC name.
        command: &'static str,
    },
}

impl Refusal {
    /// NC error code.
    #[must_use]
    pub fn code(&self) -> u32 {
        match self {
            Self::Status {
                status, transition, ..
            } => match (status, transition) {
                (AxisStatus::Disabled, _) => 0x422a,
                (AxisStatus::Stopping, _) => 0x42ef,
                (AxisStatus::ErrorStop, _) => 0x4b09,
                (_, Transition::Uncouple) => 0x424d,
                _ => 0x4b05,
            },
            Self::NotAtRest { .. } | Self::VelocityJump { .. } => 0x425a,
            Self::Guard(refusal) => refusal.code(),
            Self::NoMaster => 0x4b09,
            Self::Gear(_) => 0x421b,
            Self::FlyingGear(error) => error.code(),
            Self::Cam(error) => error.code(),
            Self::Saw(refusal) => refusal.code(),
            Self::NoCharacteristics => 0x4216,
            Self::NoLimits { .. } => 0x4b05,
        }
    }
}

impl From<GuardRefusal> for Refusal {
    fn from(refusal: GuardRefusal) -> Self {
        Self::Guard(refusal)
    }
}

impl From<RatioZero> for Refusal {
    fn from(error: RatioZero) -> Self {
        Self::Gear(error)
    }
}

impl From<FlyingGearError> for Refusal {
    fn from(error: FlyingGearError) -> Self {
        Self::FlyingGear(error)
    }
}

impl From<CouplingError> for Refusal {
    fn from(error: CouplingError) -> Self {
        Self::Cam(error)
    }
}

impl From<SawRefusal> for Refusal {
    fn from(refusal: SawRefusal) -> Self {
        Self::Saw(refusal)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Guard(refusal) => return refusal.fmt(f),
            Self::Gear(error) => return error.fmt(f),
            Self::FlyingGear(error) => return error.fmt(f),
            Self::Cam(error) => return error.fmt(f),
            Self::Saw(refusal) => return refusal.fmt(f),
            _ => write!(f, "{:#06x}: ", self.code())?,
        }
        match self {
            Self::Guard(_) | Self::Gear(_) | Self::FlyingGear(_) | Self::Cam(_) | Self::Saw(_) => {
                Ok(())
            }
            Self::NoCharacteristics => {
                f.write_str("the slave has had no flying saw, expected one before")
            }
            Self::NoLimits { command } => write!(
                f,
                "{command}: the slave has no limits, expected some: it follows its gear only"
            ),
            Self::Status {
                command,
                transition,
                status,
            } => {
                write!(f, "{command}: the axis is in {status}, expected")?;
                AxisStatus::ALL
                    .into_iter()
                    .filter(|from| from.after(*transition).is_some())
                    .enumerate()
                    .try_for_each(|(k, from)| {
                        write!(f, "{} {from}", if k == 0 { "" } else { " or" })
                    })
            }
            Self::NotAtRest { velocity } => {
                write!(f, "velocity of the axis: received {velocity}, expected 0")
            }
            Self::NoMaster => f.write_str("no master to couple to"),
            Self::VelocityJump {
                velocity,
                coupled,
                allowed,
            } => write!(
                f,
                "velocity of the axis: received {velocity}, expected {coupled} as coupled, within {allowed}"
            ),
        }
    }
}

impl core::error::Error for Refusal {}
