//! The motion between two known states of an axis.

use crate::law::Motion;
use crate::law::polynom::quintic;
use crate::profile::Kinematics;

/// Use of the accelerations of two states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// A quintic through position, velocity and acceleration.
    WithAccelerations,
    /// A cubic through position and velocity: the accelerations are noise.
    WithoutAccelerations,
}

/// Returns the state at a share of the time between two states, `gap` seconds apart.
///
/// Exact while the jerk does not change between them, C2 where two gaps meet, and each end is met to rounding.
#[must_use]
#[inline]
pub fn between(
    before: &Kinematics,
    after: &Kinematics,
    gap: f64,
    share: f64,
    ends: Ends,
) -> Kinematics {
    let [before, after] = [before, after].map(|set| Motion {
        position: set.position,
        // Derivatives by the share of the gap.
        velocity: set.velocity * gap,
        acceleration: set.acceleration * gap * gap,
        ..Motion::default()
    });
    let (start, end) = match ends {
        Ends::WithAccelerations => (before, after),
        Ends::WithoutAccelerations => with_cubic_accelerations(&before, &after),
    };
    let [position, velocity, acceleration, _] = quintic(&start, &end).derivatives(share);
    Kinematics {
        position,
        velocity: velocity / gap,
        acceleration: acceleration / (gap * gap),
    }
}

/// The ends with the accelerations of the cubic through their positions and velocities, with which the quintic is that
/// cubic.
fn with_cubic_accelerations(before: &Motion, after: &Motion) -> (Motion, Motion) {
    let rise = after.position - before.position;
    let (from, to) = (before.velocity, after.velocity);
    let start = 6.0 * rise - 4.0 * from - 2.0 * to;
    let end = -6.0 * rise + 2.0 * from + 4.0 * to;
    let with = |motion: &Motion, acceleration| Motion {
        acceleration,
        ..*motion
    };
    (with(before, start), with(after, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_jerk_is_met_at_every_share() {
        let before = Kinematics {
            position: 3.0,
            velocity: -2.0,
            acceleration: 40.0,
        };
        let (gap, jerk) = (0.02, 900.0);
        let after = before.after(gap, jerk);
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let found = between(&before, &after, gap, share, Ends::WithAccelerations);
            let truth = before.after(gap * share, jerk);
            assert!((found.position - truth.position).abs() < 1e-14, "{share}");
            assert!((found.velocity - truth.velocity).abs() < 1e-11, "{share}");
            assert!(
                (found.acceleration - truth.acceleration).abs() < 1e-8,
                "{share}"
            );
        }
    }

    #[test]
    fn without_accelerations_they_do_not_matter() {
        let state = |position, acceleration| Kinematics {
            position,
            velocity: 5.0,
            acceleration,
        };
        let of = |a, b| {
            between(
                &state(0.0, a),
                &state(0.1, b),
                0.02,
                0.3,
                Ends::WithoutAccelerations,
            )
        };
        assert_eq!(of(0.0, 0.0), of(7.0, -1e9));
        assert!((of(0.0, 0.0).position - 0.03).abs() < 1e-15);
    }
}
