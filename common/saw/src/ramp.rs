//! The symmetric ramp: a change of velocity along 3x² − 2x³ of its time.
//!
//! Its acceleration is a parabola, zero at both ends, with a peak of 1.5·|Δv|/T half way; its jerk is
//! greatest at both ends, 6·|Δv|/T².

/// Limits of a ramp, all above zero; infinity for no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RampBounds {
    /// Acceleration while the axis speeds up, u/s².
    pub(super) acceleration: f64,
    /// Deceleration while it slows down, u/s².
    pub(super) deceleration: f64,
    /// Jerk of either sign, u/s³.
    pub(super) jerk: f64,
}

/// Returns the duration of the shortest ramp between two velocities, s.
///
/// Where the velocity changes its sign, the deceleration bounds the ramp up to there and the
/// acceleration from there on.
pub(super) fn shortest_ramp(from: f64, to: f64, bounds: &RampBounds) -> f64 {
    let change = (to - from).abs();
    let by_acceleration = 1.5 * change * effort(from, to, bounds);
    let by_jerk = libm::sqrt(6.0 * change / bounds.jerk);
    // 1.5·|Δv|/T ≤ a and 6·|Δv|/T² ≤ j, solved for T. An infinite limit gives 0.
    by_acceleration.max(by_jerk)
}

/// Returns the greatest part of the peak on either side of standstill, relative to the limit there.
fn effort(from: f64, to: f64, bounds: &RampBounds) -> f64 {
    if from * to < 0.0 {
        let crossing = place_of(from.abs() / (to - from).abs());
        // The peak is half way. The side of standstill that has
        // it feels all of it, the other what it reaches there.
        let before = parabola(crossing.min(0.5)) / bounds.deceleration;
        let after = parabola(crossing.max(0.5)) / bounds.acceleration;
        before.max(after)
    } else if to.abs() > from.abs() {
        1.0 / bounds.acceleration
    } else {
        1.0 / bounds.deceleration
    }
}

/// Returns the acceleration of the ramp as a part of its peak.
fn parabola(x: f64) -> f64 {
    4.0 * x * (1.0 - x)
}

/// Returns the place from 0 to 1 at which 3x² − 2x³ is `part`.
fn place_of(part: f64) -> f64 {
    // The trigonometric solution of the cubic, the one of its three roots that lies from 0 to 1.
    0.5 - libm::sin(libm::asin(1.0 - 2.0 * part) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn jerk_and_acceleration_bound_it() {
        let bounds = RampBounds {
            acceleration: 2_500.0,
            deceleration: 2_500.0,
            jerk: 5_000.0,
        };
        // TS5055 chapter 3, example 1: 0.948683 s.
        let expected = libm::sqrt(6.0 * 750.0 / 5_000.0);
        assert!((shortest_ramp(-250.0, 500.0, &bounds) - expected).abs() < 1e-12);
        let hard = RampBounds {
            jerk: f64::INFINITY,
            ..bounds
        };
        assert!((shortest_ramp(-250.0, 500.0, &hard) - 1.5 * 750.0 / 2_500.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn each_side_of_standstill_keeps_its_own_bound(
            from in -1e3..1e3_f64, to in -1e3..1e3_f64, a in 1.0..1e3_f64, d in 1.0..1e3_f64,
        ) {
            let bounds = RampBounds { acceleration: a, deceleration: d, jerk: f64::INFINITY };
            let duration = shortest_ramp(from, to, &bounds);
            let mut reached: f64 = 0.0;
            for k in 0..=10_000 {
                let x = f64::from(k) / 10_000.0;
                let velocity = from + (to - from) * x * x * (3.0 - 2.0 * x);
                let acceleration = 6.0 * (to - from) / duration * x * (1.0 - x);
                let bound = if velocity * acceleration > 0.0 { a } else { d };
                reached = reached.max(acceleration.abs() / bound);
            }
            // Either limit is just reached, to the resolution of 10 000 samples beside the crossing.
            prop_assert!(reached < 1.001, "{reached}");
            prop_assert!(reached > 0.99, "{reached}");
        }
    }
}
