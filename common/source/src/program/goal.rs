//! Goal of a motion, and the rest of a program that is interrupted.

use coaxle_clock::Span;
use coaxle_curve::profile::{Kinematics, Limits, Profile, to_position, to_velocity};

/// End of a motion.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// A standstill, anywhere.
    Rest,
    /// A position, within limits of its own.
    Position { target: f64, limits: Limits },
    /// A velocity.
    Velocity { value: f64 },
}

/// Rest of a program whose motion was interrupted.
#[derive(Clone, Copy, Debug)]
pub(super) struct RestOfProgram {
    pub(super) goal: Goal,
    /// Time from the end of its motion to the next instruction.
    pub(super) pause: Span,
}

impl Goal {
    /// Plans the motion there within further limits.
    pub(super) fn profile(&self, from: &Kinematics, limits: &Limits) -> Profile {
        match self {
            Self::Rest => to_velocity(from, 0.0, limits),
            Self::Position {
                target,
                limits: own,
            } => to_position(from, *target, &own.at_most(limits)),
            Self::Velocity { value } => {
                let most = limits.velocity();
                to_velocity(from, value.clamp(-most, most), limits)
            }
        }
    }
}
