//! Braking of an axis without data.

use coaxle_curve::profile::Kinematics;

/// An axis without data comes to rest within this time, s.
pub(super) const BRAKING: f64 = 0.5;
/// An axis that is brought back is accelerated as its master was at most, but never less than
/// braking it requires: the quartic begins with at most this multiple of its velocity over its
/// length.
pub(super) const BRAKED: f64 = 1.5;

/// A motion that comes to rest: the quartic whose velocity and acceleration reach zero together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Braking {
    pub(super) from: Kinematics,
    /// s, above 0.
    pub(super) length: f64,
}

impl Braking {
    /// State this number of seconds after it began.
    pub(super) fn at(&self, since: f64) -> Kinematics {
        let x = since / self.length;
        if x >= 1.0 {
            return Kinematics::at_rest(self.from.position + self.way());
        }
        let (v, a) = self.scaled();
        // Conditions at x = 1: v + 2c₂ + 3c₃ + 4c₄ = 0 and 2c₂ + 6c₃ + 12c₄ = 0, with c₂ = a/2.
        let (c2, c3, c4) = (0.5 * a, -v - 2.0 / 3.0 * a, 0.5 * v + 0.25 * a);
        let velocity = v + x * (2.0 * c2 + x * (3.0 * c3 + x * 4.0 * c4));
        let acceleration = 2.0 * c2 + x * (6.0 * c3 + x * 12.0 * c4);
        Kinematics {
            position: self.from.position + x * (v + x * (c2 + x * (c3 + x * c4))),
            velocity: velocity / self.length,
            acceleration: acceleration / (self.length * self.length),
        }
    }

    /// Distance to rest, u.
    pub(super) fn way(&self) -> f64 {
        let (v, a) = self.scaled();
        // The quartic at x = 1: v + c₂ + c₃ + c₄.
        0.5 * v + a / 12.0
    }

    /// Initial velocity and acceleration, as ways.
    fn scaled(&self) -> (f64, f64) {
        let Kinematics {
            velocity,
            acceleration,
            ..
        } = self.from;
        (
            velocity * self.length,
            acceleration * self.length * self.length,
        )
    }
}
