//! Reaction of the slave when its master runs back past the coupling position: TS5055 8.

use coaxle_clock::Seconds;

use coaxle_curve::profile::{Kinematics, Limits, Profile, to_velocity};

use super::SyncMask;
use super::path_piece::PathPiece;
use super::ramp::{RampBounds, shortest_ramp};

/// Reaction of the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RollbackReaction {
    /// Stays coupled.
    Follow,
    /// Ramps its velocity to zero.
    Ramp,
    /// Stops within one cycle. Its following-error monitor may trip.
    Instant,
}

impl RollbackReaction {
    /// Returns the reaction by the eight cases of TS5055 8:
    ///
    /// | lock | instant | synchronous phase reached | case | reaction |
    /// |--|--|--|--|--|
    /// | 0 | 0 | yes | 1 | follow |
    /// | 0 | 0 | no | 2 | ramp |
    /// | 0 | 1 | no | 3 | instant |
    /// | 0 | 1 | yes | 4 | follow |
    /// | 1 | 0 | no | 5 | ramp |
    /// | 1 | 0 | yes | 6 | ramp |
    /// | 1 | 1 | no | 7 | instant |
    /// | 1 | 1 | yes | 8 | instant |
    #[must_use]
    pub const fn of(mask: SyncMask, synchronous: bool) -> Self {
        // Case 4 as well: without the lock a synchronous slave follows, and its stop mode has no effect.
        if synchronous && !mask.contains(SyncMask::ROLLBACK_LOCK) {
            Self::Follow
        } else if mask.contains(SyncMask::INSTANT_STOP_ON_ROLLBACK) {
            Self::Instant
        } else {
            Self::Ramp
        }
    }
}

/// The stop from the coupling position: a symmetric ramp of the velocity to zero, over time, which
/// starts and ends without acceleration. A slave that accelerates is stopped by phases of constant
/// jerk, which start with its acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollbackStop {
    course: RollbackMotion,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lives in place: nothing is allocated on the cycle path"
)]
enum RollbackMotion {
    Ramp(PathPiece),
    Phases(Profile),
}

impl RollbackStop {
    /// Plans the shortest stop by a ramp within deceleration (u/s²) and jerk (u/s³), both above zero, of
    /// a slave that is at the coupling position, and does not accelerate.
    #[must_use]
    pub fn plan(slave: &Kinematics, deceleration: f64, jerk: f64) -> Self {
        let bounds = RampBounds {
            // A ramp to standstill only slows down, so the other limit is never used.
            acceleration: deceleration,
            deceleration,
            jerk,
        };
        let duration = shortest_ramp(slave.velocity, 0.0, &bounds);
        let ramp = PathPiece::ramp(0.0, duration, slave.position, slave.velocity, 0.0);
        let course = RollbackMotion::Ramp(ramp);
        Self { course }
    }

    /// Plans the shortest stop of a slave that accelerates.
    pub(super) fn from_acceleration(slave: &Kinematics, limits: &Limits) -> Self {
        let course = RollbackMotion::Phases(stop_from(slave, limits));
        Self { course }
    }

    /// Returns the duration of the stop.
    #[must_use]
    pub const fn duration(&self) -> Seconds {
        match &self.course {
            RollbackMotion::Ramp(ramp) => Seconds(ramp.length),
            RollbackMotion::Phases(profile) => profile.duration(),
        }
    }

    /// Returns the position at which the slave comes to rest, u.
    #[must_use]
    pub fn end_position(&self) -> f64 {
        match &self.course {
            RollbackMotion::Ramp(ramp) => ramp.position() + ramp.distance(),
            RollbackMotion::Phases(profile) => profile.end().position,
        }
    }

    /// Returns the slave at a time after its master passed the coupling position.
    #[must_use]
    pub fn at(&self, since: Seconds) -> Kinematics {
        match &self.course {
            RollbackMotion::Phases(profile) => profile.at(since),
            // Beyond its end the polynomial would turn and come back.
            RollbackMotion::Ramp(ramp) if since.0 >= ramp.length => {
                Kinematics::at_rest(self.end_position())
            }
            RollbackMotion::Ramp(ramp) => {
                let motion = ramp.at(since.0.max(0.0));
                Kinematics {
                    position: motion.position,
                    velocity: motion.velocity,
                    acceleration: motion.acceleration,
                }
            }
        }
    }
}

/// Plans the stop of a slave from its present acceleration. An acceleration beyond its limits, caused by
/// a jump of the master, is dropped at once.
pub(super) fn stop_from(slave: &Kinematics, limits: &Limits) -> Profile {
    let most = limits.acceleration().max(limits.deceleration());
    let start = limits.without_overspeed(&Kinematics {
        // Led back within the jerk, it would carry the slave on in the meantime.
        acceleration: slave.acceleration.clamp(-most, most),
        ..*slave
    });
    to_velocity(&start, 0.0, limits)
}
