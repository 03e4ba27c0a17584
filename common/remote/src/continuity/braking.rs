//! Braking of an axis without data.

use coaxle_curve::profile::Kinematics;

/// An axis without data comes to rest within this time, s.
pub(super) const BRAKING: f64 = 0.5;
/// An axis that is brought back is accelerated as its master was at most, but never less than
/// braking it requires: the quartic begins with at most this multiple of its velocity over its
/// length.
pub(super) const BRAKED: f64 = 1.5;

/// The greatest velocity that an acceleration `a` adds to a braking of length `t` is `a·t·x·(1 − x)²` at x = ⅓.
const GAIN: f64 = 4.0 / 27.0;

/// A motion that comes to rest: the quartic whose velocity and acceleration reach zero together.
///
/// The sum of the braking of the velocity and that of the acceleration, which may be shorter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Braking {
    from: Kinematics,
    /// Length, s, above 0.
    length: f64,
    /// Length of the braking of the acceleration, s.
    fading: f64,
}

impl Braking {
    /// A braking of `length` seconds, in which the acceleration adds at most `gained` to the velocity, u/s.
    ///
    /// The first acceleration of an encoder is the difference to the velocity before its first frame. In wide schedule 606543 that was
    /// 1.3 · 10⁶ u/s², and a way back of 60 ms led the axis of a master of 325 u/s to −3 400 u/s.
    pub(super) fn new(from: Kinematics, length: f64, gained: f64) -> Self {
        let most = gained / GAIN;
        // A product, as an acceleration of 0 has no quotient.
        let fading = match from.acceleration.abs() * length > most {
            true => most / from.acceleration.abs(),
            false => length,
        };
        Self {
            from,
            length,
            fading,
        }
    }

    /// State this number of seconds after it began.
    pub(super) fn at(&self, since: f64) -> Kinematics {
        let (velocity, acceleration) = (self.slowed(since), self.faded(since));
        Kinematics {
            position: self.from.position + (velocity.position + acceleration.position),
            velocity: velocity.velocity + acceleration.velocity,
            acceleration: velocity.acceleration + acceleration.acceleration,
        }
    }

    /// Velocity at which it began, u/s.
    pub(super) const fn own_velocity(&self) -> f64 {
        self.from.velocity.abs()
    }

    /// Distance to rest, u.
    pub(super) fn way(&self) -> f64 {
        // The two parts at their ends.
        0.5 * self.from.velocity * self.length
            + self.from.acceleration * self.fading * self.fading / 12.0
    }

    /// The part of the velocity: v·(1 − x)²·(1 + 2x).
    fn slowed(&self, since: f64) -> Kinematics {
        let (v, t) = (self.from.velocity, self.length);
        let x = (since / t).min(1.0);
        let y = 1.0 - x;
        Kinematics {
            // x − x³ + x⁴/2, whose end is ½.
            position: v * t * x * (1.0 - x * x * (1.0 - 0.5 * x)),
            velocity: v * y * y * (1.0 + 2.0 * x),
            acceleration: -6.0 * v * x * y / t,
        }
    }

    /// The part of the acceleration: a·t·x·(1 − x)².
    fn faded(&self, since: f64) -> Kinematics {
        let (a, t) = (self.from.acceleration, self.fading);
        // Also for a length of 0, which has no quotient.
        if since >= t {
            return Kinematics::at_rest(a * t * t / 12.0);
        }
        let x = since / t;
        let y = 1.0 - x;
        Kinematics {
            // x²/2 − 2x³/3 + x⁴/4, whose end is 1/12.
            position: a * t * t * x * x * (0.5 - x * (2.0 / 3.0 - 0.25 * x)),
            velocity: a * t * x * y * y,
            acceleration: a * y * (1.0 - 3.0 * x),
        }
    }
}
