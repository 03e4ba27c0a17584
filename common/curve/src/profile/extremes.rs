//! Extremes of a profile.

use coaxle_clock::Seconds;

use super::phases::{Kinematics, Profile};

/// Extremes of position and velocity of a profile until its end.
#[derive(Clone, Copy, Debug)]
pub struct ProfileExtremes {
    /// The least position, u.
    pub low: f64,
    /// The greatest position, u.
    pub high: f64,
    /// The greatest speed, u/s.
    pub speed: f64,
    /// The least velocity, u/s.
    pub slowest: f64,
    /// The greatest velocity, u/s.
    pub fastest: f64,
}

impl ProfileExtremes {
    /// Finds the extremes of a profile. Exact: within a phase of constant jerk they lie at its ends, or
    /// where the velocity or the acceleration passes through zero.
    #[must_use]
    pub fn of(profile: &Profile) -> Self {
        let end = profile.end();
        let mut extremes = Self {
            // From the end, whose values are settled exactly, then the
            // begin of each phase: a profile without phases is right, too.
            low: end.position,
            high: end.position,
            speed: end.velocity.abs(),
            slowest: end.velocity,
            fastest: end.velocity,
        };
        for begin in profile.phase_begins() {
            let from = profile.at(begin);
            let jerk = profile.jerk_at(begin);
            extremes.take(&from);
            for turn in turning_times(&from, jerk) {
                // Beyond the phase this is a state of the next one, which is harmless.
                // NaN fails both comparisons, so a phase without such a time adds nothing.
                if turn > 0.0 && turn <= profile.duration().0 - begin.0 {
                    extremes.take(&profile.at(begin + Seconds(turn)));
                }
            }
        }
        extremes
    }

    fn take(&mut self, state: &Kinematics) {
        self.low = self.low.min(state.position);
        self.high = self.high.max(state.position);
        self.speed = self.speed.max(state.velocity.abs());
        self.slowest = self.slowest.min(state.velocity);
        self.fastest = self.fastest.max(state.velocity);
    }
}

/// Returns the times at which the velocity and the acceleration pass through zero under a constant jerk,
/// in seconds from now; NaN if they do not.
fn turning_times(from: &Kinematics, jerk: f64) -> [f64; 3] {
    let (v, a) = (from.velocity, from.acceleration);
    // v + a·t + jerk/2·t² = 0 in the form that does not cancel.
    let q = -(a + libm::sqrt(a * a - 2.0 * jerk * v).copysign(a));
    // Both roots of the parabola: their product is 2v/j, so the second one follows without a difference.
    [q / jerk, 2.0 * v / q, -a / jerk]
}
