//! The building block of every profile: the shortest change from one velocity to another.

use super::band::Band;
use super::limits::Limits;
use super::phases::{Kinematics, Profile};

/// The shortest change from a velocity and acceleration to another velocity without acceleration: lead
/// the acceleration to a peak, hold it there, lead it back to zero.
///
/// A start acceleration beyond the limit is first led back to it, so the peak may also lie below the
/// start.
#[derive(Clone, Copy, Debug)]
pub(super) struct VelocityChange {
    ramps: [AccelerationRamp; 3],
    target: f64,
}

/// A phase of constant jerk with a known end acceleration.
#[derive(Clone, Copy, Debug, Default)]
struct AccelerationRamp {
    jerk: f64,
    duration: f64,
    acceleration: f64,
}

impl VelocityChange {
    /// Plans the change from `start` to the velocity `target`.
    #[inline]
    pub(super) fn new(start: &Kinematics, target: f64, limits: &Limits) -> Self {
        let bound = |from, to| acceleration_limit(from, to, limits);
        Self::within(start, target, limits.jerk(), bound, bound)
    }

    /// Plans the change within limits by direction.
    pub(super) fn directed(start: &Kinematics, target: f64, band: &Band) -> Self {
        Self::within(start, target, band.jerk, |_, _| band.up, |_, _| band.down)
    }

    /// Plans the change within limits `up` and `down` that depend on the velocities between which the
    /// axis is pushed; for a push down, these have the opposite sign.
    fn within(
        start: &Kinematics,
        target: f64,
        jerk: f64,
        up: impl Fn(f64, f64) -> f64,
        down: impl Fn(f64, f64) -> f64,
    ) -> Self {
        // The velocity reached by leading the acceleration to zero at once decides the direction in which
        // the axis must be pushed.
        let a0 = start.acceleration;
        // a·|a| keeps the sign: a negative acceleration loses velocity until it is zero.
        let coasting = start.velocity + a0 * a0.abs() / (2.0 * jerk);
        // Equality belongs to pushing up: the change is one ramp of a0/j then, and no case of its own.
        if target >= coasting {
            Self {
                ramps: push_up(start, coasting, target, jerk, up),
                target,
            }
        } else {
            // Common formulas for both directions, so that mirrored motions agree to the last bit.
            let mut ramps = push_up(&start.mirrored(), -coasting, -target, jerk, down);
            for ramp in &mut ramps {
                ramp.jerk = -ramp.jerk;
                ramp.acceleration = -ramp.acceleration;
            }
            Self { ramps, target }
        }
    }

    /// Returns the duration of the change, in seconds.
    pub(super) fn duration(&self) -> f64 {
        self.ramps.iter().map(|ramp| ramp.duration).sum()
    }

    /// Appends the change to a profile that ends where the change starts.
    #[inline]
    pub(super) fn append_to(&self, profile: &mut Profile) {
        for ramp in &self.ramps {
            profile.push(ramp.jerk, ramp.duration, ramp.acceleration);
        }
        // Halts and cruises compare velocities: the sum of three rounded steps would miss 0 by an ε.
        profile.settle_velocity(self.target);
    }

    /// Appends the change, relative to a frame that moves as `frame` where the change ends: the frame's
    /// acceleration is added to every ramp.
    pub(super) fn append_to_moving(&self, profile: &mut Profile, frame: &Kinematics) {
        for ramp in &self.ramps {
            profile.push(
                ramp.jerk,
                ramp.duration,
                ramp.acceleration + frame.acceleration,
            );
        }
        profile.settle_velocity(frame.velocity);
    }

    /// Appends only the first `duration` seconds of it.
    pub(super) fn append_first(&self, duration: f64, profile: &mut Profile) {
        let mut left = duration;
        for ramp in &self.ramps {
            // An interrupted change keeps the acceleration it has by then, which the next one takes up.
            if left < ramp.duration {
                let acceleration = profile.end().acceleration + ramp.jerk * left;
                return profile.push(ramp.jerk, left, acceleration);
            }
            profile.push(ramp.jerk, ramp.duration, ramp.acceleration);
            left -= ramp.duration;
        }
    }
}

/// Plans the ramps of a change towards larger velocities, where `target` is at least `coasting`.
fn push_up(
    start: &Kinematics,
    coasting: f64,
    target: f64,
    jerk: f64,
    bound: impl Fn(f64, f64) -> f64,
) -> [AccelerationRamp; 3] {
    let a0 = start.acceleration;
    // Start of the push: a negative acceleration is led to zero before it.
    let pushed_from = if a0 < 0.0 { coasting } else { start.velocity };
    // Speeds on the way decide: below zero a push upwards slows down, above zero it speeds up.
    let limit = bound(pushed_from, target);

    // A triangle of acceleration from a0 over its peak to zero spans (2·peak² − a0²)/2j.
    let span = target - start.velocity;
    // Rounding must not put it below an acceleration that only has to be led to zero.
    let highest = libm::sqrt((jerk * span + a0 * a0 / 2.0).max(0.0)).max(a0);
    let peak = highest.min(limit);
    let lead = AccelerationRamp {
        // A start beyond the limit is led down to it.
        jerk: if peak < a0 { -jerk } else { jerk },
        duration: (peak - a0).abs() / jerk,
        acceleration: peak,
    };
    let back = AccelerationRamp {
        jerk: -jerk,
        duration: peak / jerk,
        acceleration: 0.0,
    };
    let hold = AccelerationRamp {
        jerk: 0.0,
        duration: if peak < highest {
            hold_time(span, &lead, &back, a0, peak)
        } else {
            0.0
        },
        acceleration: peak,
    };
    [lead, hold, back]
}

/// Returns the time at the peak for which the three ramps together span the change.
fn hold_time(
    span: f64,
    lead: &AccelerationRamp,
    back: &AccelerationRamp,
    a0: f64,
    peak: f64,
) -> f64 {
    let ramped = (a0 + peak) / 2.0 * lead.duration + peak / 2.0 * back.duration;
    // Rounding of a change that just reaches its peak must not give a negative time.
    ((span - ramped) / peak).max(0.0)
}

/// Returns the limit of a push towards larger velocities.
fn acceleration_limit(from: f64, target: f64, limits: &Limits) -> f64 {
    // Up to zero every push upwards slows down; through zero the smaller limit holds on both sides.
    if target <= 0.0 {
        limits.deceleration()
    } else if from >= 0.0 {
        limits.acceleration()
    } else {
        limits.acceleration().min(limits.deceleration())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits::new(100.0, 20.0, 40.0, 200.0).unwrap()
    }

    fn duration(velocity: f64, acceleration: f64, target: f64) -> f64 {
        let start = Kinematics {
            position: 0.0,
            velocity,
            acceleration,
        };
        VelocityChange::new(&start, target, &limits()).duration()
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
    }

    #[test]
    fn a_long_change_takes_dv_over_a_plus_a_over_j() {
        // Δv/a + a/j, by acceleration 20 or deceleration 40 according to the sign of the velocity.
        assert!(close(duration(0.0, 0.0, 50.0), 50.0 / 20.0 + 20.0 / 200.0));
        assert!(close(duration(50.0, 0.0, 0.0), 50.0 / 40.0 + 40.0 / 200.0));
        assert!(close(duration(-50.0, 0.0, 0.0), 50.0 / 40.0 + 40.0 / 200.0));
        assert!(close(duration(0.0, 0.0, -50.0), 50.0 / 20.0 + 20.0 / 200.0));
    }

    #[test]
    fn a_short_change_never_reaches_the_limit() {
        assert!(close(
            // Below a²/j = 2 u/s the acceleration is a triangle: 2·√(Δv/j).
            duration(0.0, 0.0, 1.0),
            2.0 * libm::sqrt(1.0 / 200.0)
        ));
        assert!(close(
            duration(3.0, 0.0, 1.0),
            2.0 * libm::sqrt(2.0 / 200.0)
        ));
    }

    #[test]
    fn passing_through_standstill_keeps_to_the_smaller_limit() {
        assert!(close(
            duration(30.0, 0.0, -30.0),
            60.0 / 20.0 + 20.0 / 200.0
        ));
    }

    #[test]
    fn a_start_acceleration_is_used_not_thrown_away() {
        // From half way up the lead-in, the rest of the change remains.
        let whole = duration(0.0, 0.0, 50.0);
        let t = 0.05;
        let rest = duration(200.0 * t * t / 2.0, 200.0 * t, 50.0);
        assert!(close(rest, whole - t), "{rest} {whole}");
    }

    #[test]
    fn an_acceleration_beyond_the_limit_is_led_back_to_it() {
        // 30 → 20 u/s² takes 0.05 s and 1.25 u/s, the way back 0.1 s and 1 u/s.
        assert!(close(
            duration(0.0, 30.0, 50.0),
            0.05 + (50.0 - 1.25 - 1.0) / 20.0 + 0.1
        ));
    }

    #[test]
    fn only_leading_the_acceleration_to_zero_is_one_ramp() {
        assert!(close(
            // Exactly a²/2j: the change that leading the acceleration to zero makes by itself.
            duration(0.0, 10.0, 10.0 * 10.0 / 400.0),
            10.0 / 200.0
        ));
    }
}
