//! The fastest path of a slave onto the line of its gear, within its limits.

use coaxle_curve::profile::{Band, Kinematics, Limits, Profile, ProfileExtremes, to_line, towards};

use super::SyncMask;

/// Margin of every limit for rounding, relative.
// A thousand times the tolerance of the checks, so that a path at its limits passes them.
const ROUNDING: f64 = 1e-9;

/// Limits of the slave on its path to the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathLimits {
    /// The limits in force.
    pub(super) limits: Limits,
    /// Greatest velocity of a line that the slave may follow, u/s: at least that of the limits.
    pub(super) fastest_line: f64,
    /// Velocities not to exceed on the path, beside the limit.
    pub(super) mask: SyncMask,
}

/// Range of velocities.
type VelocityRange = (f64, f64);

impl PathLimits {
    /// Plans the fastest profile onto a line that passes, with `share` of acceleration, deceleration and
    /// jerk. None if no profile leads there; an error with the reason of the fastest if none passes.
    ///
    /// Limits of speeding up and slowing down become limits by direction: a slave that does not reverse
    /// speeds up one way and slows down the other. One that reverses keeps to the smaller limit all
    /// along.
    pub(super) fn fastest<E>(
        &self,
        (start, line): (&Kinematics, &Kinematics),
        share: f64,
        check: impl Fn(&Profile) -> Result<(), E>,
    ) -> Option<Result<Profile, E>> {
        let velocity_range = self.velocity_range(start.velocity, line.velocity);
        let (up, down) = (self.limits.acceleration(), self.limits.deceleration());
        // A path through standstill speeds up and slows down in one direction of push.
        let either = up.min(down);
        let turning = self.profile_onto((start, line), velocity_range, (either, either), share);
        let turning = turning.map(|profile| check(&profile).map(|()| profile));
        // No profile is faster than one that may use all that the others may.
        if up == down && matches!(turning, Some(Ok(_))) {
            return turning;
        }
        let onward = self
            // With limits by direction, or where the fastest path
            // breaks a check: a line from behind may be waited for.
            .onward((start, line), velocity_range, (up, down), share)
            .map(|profile| check(&profile).map(|()| profile));
        faster(turning, onward)
    }

    /// Plans the path of a slave that only moves in the direction of the line, or stands until the line
    /// arrives. One that moves the other way stops first.
    fn onward(
        &self,
        (start, line): (&Kinematics, &Kinematics),
        (lowest, highest): VelocityRange,
        (faster, slower): (f64, f64),
        share: f64,
    ) -> Option<Profile> {
        let (ahead, is_up) = (start.velocity * line.velocity, line.velocity >= 0.0);
        // Zero included: the slave may stand until the line arrives.
        let velocity_range = if is_up {
            (lowest.max(0.0), highest)
        } else {
            (lowest, highest.min(0.0))
        };
        let either = faster.min(slower);
        let pushes = match (ahead >= 0.0, is_up) {
            // A slave that has to turn: both limits apply to the same push.
            (false, _) => (either, either),
            (true, true) => (faster, slower),
            (true, false) => (slower, faster),
        };
        let profile = self.profile_onto((start, line), velocity_range, pushes, share)?;
        let extremes = ProfileExtremes::of(&profile);
        let slack = ROUNDING * self.limits.velocity();
        let turns = if is_up {
            extremes.slowest < -slack
        } else {
            extremes.fastest > slack
        };
        // For a path that turns all the same, limits by direction would be wrong.
        (!turns || faster == slower || ahead < 0.0).then_some(profile)
    }

    fn profile_onto(
        &self,
        (start, line): (&Kinematics, &Kinematics),
        velocity_range: VelocityRange,
        pushes: (f64, f64),
        share: f64,
    ) -> Option<Profile> {
        // The slave could reach such a line, but not stay on it.
        if line.velocity.abs() > self.fastest_line * (1.0 + ROUNDING) {
            return None;
        }
        let profile = to_line(start, line, &self.band(velocity_range, pushes, share))?;
        let end = profile.end();
        let numbers = [profile.duration().0, end.position, end.velocity];
        // A line that is hardly slower than the slave may be caught so late that numbers overflow.
        numbers.iter().all(|n| n.is_finite()).then_some(profile)
    }

    /// Plans the fastest stop.
    pub(super) fn stopping(&self, start: &Kinematics) -> Profile {
        self.stopping_with(start, 1.0)
    }

    fn stopping_with(&self, start: &Kinematics, share: f64) -> Profile {
        let push = self.limits.acceleration().min(self.limits.deceleration());
        let limit = self.limits.velocity();
        let band = self.band((-limit, limit), (push, push), share);
        towards(start, 0.0, &band)
    }

    /// Returns the position at which the slave comes to rest with a share of its acceleration,
    /// deceleration and jerk, u.
    pub(super) fn stop(&self, start: &Kinematics, share: f64) -> f64 {
        self.stopping_with(start, share).end().position
    }

    /// Plans the path towards a line that cannot be caught, as fast as possible; along with it if it is
    /// too fast.
    pub(super) fn towards(&self, start: &Kinematics, line: &Kinematics) -> Profile {
        let velocity_range = self.velocity_range(start.velocity, line.velocity);
        let push = self.limits.acceleration().min(self.limits.deceleration());
        let band = self.band(velocity_range, (push, push), 1.0);
        // Along with a line that is too fast, as fast as allowed, to be near when it slows down.
        let velocity = if line.velocity.abs() > self.fastest_line {
            line.velocity.clamp(band.lowest, band.highest)
        } else if line.position > start.position {
            band.highest
        } else {
            band.lowest
        };
        towards(start, velocity, &band)
    }

    fn band(&self, (lowest, highest): VelocityRange, (up, down): (f64, f64), share: f64) -> Band {
        // Velocities have no share: with a lower one, the line might never be caught.
        let part = share * (1.0 - ROUNDING);
        Band {
            lowest,
            highest,
            up: up * part,
            down: down * part,
            jerk: self.limits.jerk() * part,
        }
    }

    /// Returns the velocities from `from` to `to` that the limit and the mask allow.
    fn velocity_range(&self, from: f64, to: f64) -> VelocityRange {
        let limit = self.limits.velocity() * (1.0 - ROUNDING);
        // The line's velocity is part of the range even above the limit, since the path ends with it.
        let reached = if to.abs() <= self.fastest_line {
            to
        } else {
            0.0
        };
        let (mut lowest, mut highest) = ((-limit).min(reached), limit.max(reached));
        let (least, most) = (from.min(to), from.max(to));
        let not_above = [
            (SyncMask::OVERSHOOT_VELO, most),
            (
                SyncMask::OVERSHOOT_VELO_ZERO,
                // A slave that starts or ends above zero passes it anyway, so the check has no effect.
                if most <= 0.0 { 0.0 } else { highest },
            ),
        ];
        let not_below = [
            (SyncMask::UNDERSHOOT_VELO, least),
            (
                SyncMask::UNDERSHOOT_VELO_ZERO,
                if least >= 0.0 { 0.0 } else { lowest },
            ),
        ];
        for (flag, bound) in not_above {
            if self.mask.contains(flag) {
                highest = highest.min(bound);
            }
        }
        for (flag, bound) in not_below {
            if self.mask.contains(flag) {
                lowest = lowest.max(bound);
            }
        }
        (lowest, highest)
    }
}

/// Returns the faster of two paths that pass; if neither does, the reason of the first.
fn faster<E>(
    first: Option<Result<Profile, E>>,
    second: Option<Result<Profile, E>>,
) -> Option<Result<Profile, E>> {
    match (first, second) {
        (Some(Ok(first)), Some(Ok(second))) if second.duration() < first.duration() => {
            Some(Ok(second))
        }
        (Some(Ok(first)), _) => Some(Ok(first)),
        (_, Some(Ok(second))) => Some(Ok(second)),
        // The first is the path with more freedom, so its reason holds for both.
        (first, second) => first.or(second),
    }
}
