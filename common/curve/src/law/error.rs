//! Reasons why a law refuses its points.

use core::fmt;

use super::MotionLaw;
use crate::figure::{Rounded, UpTo};

/// An end of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The lower master position.
    Start,
    /// The higher master position.
    End,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::End => "end",
        })
    }
}

/// A number of a [`Knot`](super::Knot).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The master position.
    Master,
    /// The slave position.
    Position,
    /// The first derivative.
    Velocity,
    /// The second derivative.
    Acceleration,
    /// The third derivative.
    Jerk,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Master => "master position",
            Self::Position => "slave position",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        })
    }
}

impl Quantity {
    /// Returns the unit over time: a slave's u, and a master's.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Master | Self::Position => "u",
            Self::Velocity => "u/s",
            Self::Acceleration => "u/s²",
            Self::Jerk => "u/s³",
        }
    }
}

/// Refusal of two points between which a law cannot lead.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    /// A segment without length.
    #[error("master position at the end: received {end}, expected more than {start}")]
    NoLength {
        /// Master position of the start.
        start: f64,
        /// Master position of the end.
        end: f64,
    },
    /// A number that is not finite, or not finite relative to the length of the segment.
    #[error(
        "{quantity} at the {side}: received {received}, expected a finite number that \
            stays finite over the length of the segment"
    )]
    NotFinite {
        /// End of the segment.
        side: Side,
        /// Quantity.
        quantity: Quantity,
        /// Value received.
        received: f64,
    },
    /// A segment so short that a derivative is not finite.
    #[error(
        "length of the segment: received {received:e}, expected one over which velocity, acceleration and jerk are finite"
    )]
    TooShort {
        /// Length of the segment.
        received: f64,
    },
    /// A point that contradicts a condition of the law.
    #[error("{quantity} at the {side}: received {received}, expected {expected} for {}", .law.name())]
    Boundary {
        /// Motion law.
        law: MotionLaw,
        /// End of the segment.
        side: Side,
        /// Quantity.
        quantity: Quantity,
        /// Value received.
        received: f64,
        /// Value of the law.
        expected: f64,
    },
    /// A turning point of the harmonic combination outside of the segment.
    #[error("turning point: received {received}, expected a share between 0 and 1")]
    TurnShare {
        /// The share received.
        received: f64,
    },
    /// An acceleration that no turning point of the harmonic combination within the segment gives.
    #[error(
        "acceleration at the turn: received {received}, expected one that a turning point \
            within the segment gives"
    )]
    TurnAcceleration {
        /// The acceleration received.
        received: f64,
    },
    /// A velocity at which no turning point makes the jerk of the harmonic combination continuous.
    #[error(
        "velocity: received {received}, expected at most {} or at least 2 times the mean \
            velocity {mean}, or a given turning point",
        UpTo(core::f64::consts::FRAC_PI_2),
        mean = Rounded(*mean)
    )]
    TurnVelocity {
        /// The velocity received.
        received: f64,
        /// The mean velocity of the segment.
        mean: f64,
    },
    /// A spline, which is no law between two points: its pieces depend on all of its points.
    #[error("motion law: received {}, expected a law between two points", .law.name())]
    Spline {
        /// Kind of spline point.
        law: MotionLaw,
    },
}

impl LawError {
    /// Returns the NC error code: motion function table parameter incorrect.
    #[must_use]
    pub const fn code(&self) -> u32 {
        0x42DA
    }
}
