//! Largest motion of a master, which bounds that of an axis that is brought back to it.

use coaxle_curve::profile::Kinematics;

use super::braking::{BRAKED, BRAKING};
use crate::prediction::LASTING;

/// While it is brought back it is faster or slower than its master by at most this part of its greatest velocity up to
/// then, however long that takes: a follower of the axis needs one and a half times the velocity of the master, and no more.
/// A clock that flipped for 40 s left it 24 m behind, and a return within 30 s took four times the velocity of its master.
pub(super) const FASTER: f64 = 0.5;

/// Largest motion that a master has shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Greatest velocity up to now, u/s.
    pub velocity: f64,
    /// Greatest acceleration up to now, u/s².
    pub acceleration: f64,
}

impl Reach {
    /// Set values with a velocity and an acceleration that the axis can have. A position that jumped says nothing of either: an axis
    /// that took the jump for its velocity went on at 100 m/s.
    pub(super) fn possible(&self, set: &Kinematics) -> Kinematics {
        let (fastest, hardest) = (self.fastest(), self.hardest());
        Kinematics {
            velocity: set.velocity.clamp(-fastest, fastest),
            acceleration: set.acceleration.clamp(-hardest, hardest),
            ..*set
        }
    }

    /// The reach of an axis that moves by itself at this velocity, u/s, where its master has shown none: a way back to a master that has never
    /// moved is covered within a time. In swarm schedule 41102 such an axis was stopped within a cycle when its clock was found. Where a master
    /// has moved, its own motion is the bound: with the larger of both, 50262 and 50440 had axes that were beyond it.
    pub(super) fn or_own(self, velocity: f64) -> Self {
        match self.velocity > 0.0 {
            true => self,
            false => Self {
                velocity: velocity / (1.0 + FASTER),
                ..self
            },
        }
    }

    /// Returns true for a velocity that set values moved on in time may have, u/s: that of the axis, and its acceleration for as long as
    /// a prediction lets it last. A master that begins to move is soon faster than it was up to now, and what is planned again in each cycle
    /// does not arrive.
    pub(super) fn admits(&self, velocity: f64) -> bool {
        velocity.abs() <= self.fastest() + self.acceleration * LASTING
    }

    /// The greatest velocity of an axis that is brought back, u/s: half as fast again as its master.
    fn fastest(&self) -> f64 {
        (1.0 + FASTER) * self.velocity
    }

    /// The velocity that an axis that is braked or brought back gains at most by the acceleration at which that begins, u/s. A
    /// master at up to v with an acceleration a takes v/a to gain as much; a braking over 0.5 s needs all of its time if a·0.5 s is
    /// at most 6.75 · v.
    pub(super) const fn gained(&self) -> f64 {
        self.velocity
    }

    /// The greatest acceleration of an axis that is braked or brought back, u/s².
    fn hardest(&self) -> f64 {
        // Velocity of a braking from v over t: v·(1 - 3x² + 2x³), whose slope is largest at x = ½, 1.5·v/t.
        let by_braking = BRAKED * (1.0 + FASTER) * self.velocity / BRAKING;
        self.acceleration.max(by_braking)
    }
}
