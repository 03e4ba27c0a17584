//! Closed forms of the distance of a motion in steps of one cycle.
//!
//! All values are in units of the jerk limit and the cycle time: accelerations in `j·T`, velocities
//! in `j·T²`, positions in `j·T³`. Then one cycle is `b += u` with `|u| ≤ 1`, `w += b`, `x += w`.

/// The speed gained while the acceleration `b` is reduced to zero at the jerk limit. Odd.
#[inline]
pub(super) fn speed_gained(b: f64) -> f64 {
    let size = b.abs();
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
    let steps = whole((libm::sqrt(1.0 + 8.0 * size) - 1.0) / 2.0);
    (size / (steps + 1.0) + steps / 2.0).copysign(c)
}

/// The distance of the fastest stop from velocity `w` and acceleration `b`, with accelerations from
/// `-lower` to `upper`.
#[inline]
pub(super) fn stop_way(w: f64, b: f64, upper: f64, lower: f64) -> f64 {
    if w + speed_gained(b) < 0.0 {
        -forward_stop_way(-w, -b, upper)
    } else {
        forward_stop_way(w, b, lower)
    }
}

/// The distance of a stop whose last braking is that of a forward motion, with at most `hardest`.
fn forward_stop_way(w: f64, b: f64, hardest: f64) -> f64 {
    let b = b.max(-hardest);
    let steps = steps_towards_braking(w, b, hardest);
    let mut way = way_in_steps(w, b, steps);
    let mut left = (w + steps * b - triangle(steps)).max(0.0);
    let mut braking = acceleration_to_gain(left);
    if braking > hardest {
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
    let falling = if b >= 1.0 { whole(b) } else { 0.0 };
    let rest = b - falling;
    let speed = w + falling * b - triangle(falling);
    let released = if rest > 0.0 {
        speed - rest
    } else {
        speed - speed_gained(-rest)
    };
    let until_release = rest + libm::sqrt((rest * rest + released).max(0.0));
    let until_hardest = rest + hardest;
    falling + whole_or_none(until_release.min(until_hardest))
}

/// The distance while a braking of `b` is released to zero, its own cycle included.
fn release_way(b: f64) -> f64 {
    let steps = whole(b);
    triangle(steps) * ((steps - 1.0) / 3.0 + (b - steps))
}

/// Least further rise of the position, from velocity `w` and acceleration `b`, when it is braked
/// with up to `hardest`.
#[inline]
pub(super) fn least_peak(w: f64, b: f64, hardest: f64) -> f64 {
    if w <= 0.0 && w + speed_gained(b) <= 0.0 {
        return 0.0;
    }
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
        let cycles = whole(left / hardest);
        way += cycles * left - hardest * triangle(cycles);
    }
    way.max(0.0)
}

/// Returns the distance in this number of cycles if the acceleration falls by one in each of them.
fn way_in_steps(w: f64, b: f64, steps: f64) -> f64 {
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
    if x < ALL_WHOLE { x as i64 as f64 } else { x }
}

/// The largest whole number not above `x`; zero for a negative `x`.
fn whole_or_none(x: f64) -> f64 {
    whole(x.max(0.0))
}
