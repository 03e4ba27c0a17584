//! Closed forms of the distance of a motion in steps of one cycle.
//!
//! All values are in units of the jerk limit and the cycle time: accelerations in `j·T`, velocities
//! in `j·T²`, positions in `j·T³`. Then one cycle is `b += u` with `|u| ≤ 1`, `w += b`, `x += w`.

/// The speed gained while the acceleration `b` is reduced to zero at the jerk limit. Odd.
#[inline]
pub(super) fn speed_gained(b: f64) -> f64 {
    let size = b.abs();
    // (b - 1) + (b - 2) + … down to the last one not below 0.
    let steps = whole(size);
    (steps * size - triangle(steps)).copysign(b)
}

/// The acceleration that gains the speed `c`, its own cycle included: the inverse of
/// `b + speed_gained(b)`. Odd.
///
/// `-acceleration_to_gain(w)` is the next acceleration of the fastest stop from the velocity `w`,
/// within the limits of jerk and acceleration.
#[inline]
pub(super) fn acceleration_to_gain(c: f64) -> f64 {
    let size = c.abs();
    // With n steps b + S(b) = (n + 1)·b - n(n + 1)/2, and n is the last for which n(n + 1)/2 is not above c.
    let steps = whole((libm::sqrt(1.0 + 8.0 * size) - 1.0) / 2.0);
    (size / (steps + 1.0) + steps / 2.0).copysign(c)
}

/// The distance of the fastest stop from velocity `w` and acceleration `b`, with accelerations from
/// `-lower` to `upper`.
#[inline]
pub(super) fn stop_way(w: f64, b: f64, upper: f64, lower: f64) -> f64 {
    // The sign of the speed left once the acceleration is 0 decides on the direction of the last braking.
    if w + speed_gained(b) < 0.0 {
        -forward_stop_way(-w, -b, upper)
    } else {
        forward_stop_way(w, b, lower)
    }
}

/// The distance of a stop whose last braking is that of a forward motion, with at most `hardest`.
fn forward_stop_way(w: f64, b: f64, hardest: f64) -> f64 {
    // A bound that has come down may be below the present braking, which counts as at the bound then.
    let b = b.max(-hardest);
    let steps = steps_towards_braking(w, b, hardest);
    let mut way = way_in_steps(w, b, steps);
    // Rounding may leave a speed just below 0, which would be braked in the other direction.
    let mut left = (w + steps * b - triangle(steps)).max(0.0);
    let mut braking = acceleration_to_gain(left);
    if braking > hardest {
        // Held at the hardest until the speed left is what the release of that braking takes.
        let cycles = whole((left - speed_gained(hardest)) / hardest);
        way += cycles * left - hardest * triangle(cycles);
        left -= cycles * hardest;
        braking = acceleration_to_gain(left);
    }
    way + release_way(braking)
}

/// Number of cycles in which the acceleration falls by one, before the braking is at its hardest or
/// is released again.
fn steps_towards_braking(w: f64, b: f64, hardest: f64) -> f64 {
    // Whole cycles with an acceleration above 0 speed up only, so they cannot be part of the release.
    let falling = if b >= 1.0 { whole(b) } else { 0.0 };
    let rest = b - falling;
    let speed = w + falling * b - triangle(falling);
    let released = if rest > 0.0 {
        speed - rest
    } else {
        speed - speed_gained(-rest)
    };
    // M cycles reach a braking of M - rest, whose release takes as long: (M - rest)² = rest² + released.
    let until_release = rest + libm::sqrt((rest * rest + released).max(0.0));
    let until_hardest = rest + hardest;
    falling + whole_or_none(until_release.min(until_hardest))
}

/// The distance while a braking of `b` is released to zero, its own cycle included.
fn release_way(b: f64) -> f64 {
    let steps = whole(b);
    // n(n + 1)(2n + 1)/12 + (f - 1/2)·n(n + 1)/2 with n whole steps and the fraction f, in one product.
    triangle(steps) * ((steps - 1.0) / 3.0 + (b - steps))
}

/// Least further rise of the position, from velocity `w` and acceleration `b`, when it is braked
/// with up to `hardest`.
#[inline]
pub(super) fn least_peak(w: f64, b: f64, hardest: f64) -> f64 {
    if w <= 0.0 && w + speed_gained(b) <= 0.0 {
        return 0.0;
    }
    // Turn after m cycles, where w + m·b - m(m + 1)/2 = 0: m = h + √(h² + 2w) with h = b - 1/2.
    let h = b - 0.5;
    let radicand = h * h + 2.0 * w;
    let until_turn = if radicand > 0.0 {
        h + libm::sqrt(radicand)
    } else {
        0.0
    };
    let (until_turn, until_hardest) = (whole_or_none(until_turn), whole_or_none(b + hardest));
    let steps = until_turn.min(until_hardest);
    let mut way = way_in_steps(w, b, steps);
    let left = w + steps * b - triangle(steps);
    if until_hardest <= until_turn && left > 0.0 {
        // No release: the axis turns at full braking, which gives the least peak and not a stop.
        let cycles = whole(left / hardest);
        way += cycles * left - hardest * triangle(cycles);
    }
    way.max(0.0)
}

/// Returns the distance in this number of cycles if the acceleration falls by one in each of them.
fn way_in_steps(w: f64, b: f64, steps: f64) -> f64 {
    // Sum of w + k·b - k(k + 1)/2 over k = 1 … n: n·w + b·n(n + 1)/2 - n(n + 1)(n + 2)/6.
    steps * w + triangle(steps) * (b - (steps + 2.0) / 3.0)
}

/// 1 + 2 + … + n.
fn triangle(n: f64) -> f64 {
    n * (n + 1.0) / 2.0
}

/// The largest whole number not above `x`, which is at least zero.
#[inline]
fn whole(x: f64) -> f64 {
    // From here on every f64 is whole.
    const ALL_WHOLE: f64 = 4_503_599_627_370_496.0;
    // A cast cuts towards 0, the floor of all numbers from 0 on, without a call as `floor` is on many targets.
    if x < ALL_WHOLE { x as i64 as f64 } else { x }
}

/// The largest whole number not above `x`; zero for a negative `x`.
fn whole_or_none(x: f64) -> f64 {
    whole(x.max(0.0))
}
