//! What becomes of the slave when its master runs back past the coupling position: TS5055 8.

use coaxle_clock::Seconds;

use coaxle_curve::profile::Kinematics;

use super::SyncMask;
use super::piece::Piece;
use super::ramp::{RampBounds, shortest_ramp};

/// What the slave does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RollbackReaction {
    /// It stays coupled.
    Follow,
    /// Its velocity is led to zero.
    Ramp,
    /// It stands within one cycle. Its following-error monitor may trip.
    Instant,
}

impl RollbackReaction {
    /// The eight cases of TS5055 8:
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
        if synchronous && !mask.contains(SyncMask::ROLLBACK_LOCK) {
            Self::Follow
        } else if mask.contains(SyncMask::INSTANT_STOP_ON_ROLLBACK) {
            Self::Instant
        } else {
            Self::Ramp
        }
    }
}

/// The stop from the coupling position: a symmetric ramp of the velocity to zero, over time.
///
/// The ramp starts and ends without acceleration, whatever the slave's was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollbackStop {
    ramp: Piece,
}

impl RollbackStop {
    /// The shortest stop within deceleration (u/s²) and jerk (u/s³), both above zero, of a slave
    /// that is at the coupling position.
    #[must_use]
    pub fn plan(slave: &Kinematics, deceleration: f64, jerk: f64) -> Self {
        let bounds = RampBounds {
            acceleration: deceleration,
            deceleration,
            jerk,
        };
        let duration = shortest_ramp(slave.velocity, 0.0, &bounds);
        Self {
            ramp: Piece::ramp(0.0, duration, slave.position, slave.velocity, 0.0),
        }
    }

    /// How long it takes.
    #[must_use]
    pub const fn duration(&self) -> Seconds {
        Seconds(self.ramp.length)
    }

    /// Where the slave comes to rest, u.
    #[must_use]
    pub fn end_position(&self) -> f64 {
        self.ramp.position() + self.ramp.distance()
    }

    /// The slave, a while after its master passed the coupling position.
    #[must_use]
    pub fn at(&self, since: Seconds) -> Kinematics {
        if since.0 >= self.ramp.length {
            return Kinematics::at_rest(self.end_position());
        }
        let motion = self.ramp.at(since.0.max(0.0));
        Kinematics {
            position: motion.position,
            velocity: motion.velocity,
            acceleration: motion.acceleration,
        }
    }
}
