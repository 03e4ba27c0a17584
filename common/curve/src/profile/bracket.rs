//! Search for a change of sign of a function of one number.

/// Greatest number of steps: even by bisection, an interval has then shrunk to 1e-60 of its size.
const MOST_STEPS: usize = 200;

/// Two numbers, adjacent as far as their precision allows, between which a function passes from below
/// zero to above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// Number at which the function is at most zero.
    pub below: f64,
    /// Number at which it is at least zero.
    pub above: f64,
}

/// Shrinks an interval at whose first end `f` is at most zero and at whose second end it is at least
/// zero, given the values there. A jump is found like a zero.
///
/// Chandrupatla's method: inverse quadratic interpolation where that is safe, bisection elsewhere. A
/// smooth function takes about ten steps.
pub fn bracket(below: (f64, f64), above: (f64, f64), mut f: impl FnMut(f64) -> f64) -> Bracket {
    // A zero at the end is the result; in between, zero counts as below.
    if above.1 == 0.0 {
        return Bracket {
            below: above.0,
            above: above.0,
        };
    }
    // `new` and `old` always have opposite signs, `oldest` is the end that was replaced last.
    let (mut new, mut old) = (above, below);
    let mut oldest;
    // Three points are needed to interpolate, so the first step is a bisection.
    let mut step = 0.5;
    for _ in 0..MOST_STEPS {
        let x = new.0 + step * (old.0 - new.0);
        let at = (x, f(x));
        // NaN counts as below: an end that cannot be evaluated is never taken for the upper one.
        if (at.1 > 0.0) == (new.1 > 0.0) {
            oldest = new;
        } else {
            oldest = old;
            old = new;
        }
        new = at;
        let width = (old.0 - new.0).abs();
        let finest = 2.0 * f64::EPSILON * new.0.abs().max(old.0.abs());
        if at.1 == 0.0 || width <= finest {
            break;
        }
        // At least to the next number: a zero beside an end would otherwise be evaluated there again.
        let least = (finest / width).min(0.5);
        step = interpolated(new, old, oldest).clamp(least, 1.0 - least);
    }
    let (below, above) = if new.1 == 0.0 {
        (new.0, new.0)
    } else if new.1 > 0.0 {
        (old.0, new.0)
    } else {
        (new.0, old.0)
    };
    Bracket { below, above }
}

/// Returns the expected place of the zero, as a part of the distance from `new` to `old`.
fn interpolated(new: (f64, f64), old: (f64, f64), oldest: (f64, f64)) -> f64 {
    let place = (new.0 - old.0) / (oldest.0 - old.0);
    let height = (new.1 - old.1) / (oldest.1 - old.1);
    // Chandrupatla's condition (Advances in Engineering Software 28, 1997): inside,
    // the inverse parabola through the three points is monotone between them.
    let is_safe = height * height < place && (1.0 - height) * (1.0 - height) < 1.0 - place;
    if !is_safe {
        return 0.5;
    }
    new.1 / (old.1 - new.1) * oldest.1 / (old.1 - oldest.1)
        + (oldest.0 - new.0) / (old.0 - new.0) * new.1 / (oldest.1 - new.1) * old.1
            / (oldest.1 - old.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_smooth_function_takes_few_steps_and_a_jump_is_found() {
        let mut steps = 0;
        let cube = |x: f64| x * x * x - 2.0;
        let found = bracket((0.0, -2.0), (2.0, 6.0), |x| {
            steps += 1;
            cube(x)
        });
        assert!((found.below - libm::cbrt(2.0)).abs() < 1e-15, "{found:?}");
        // Bisection alone would take some 50 steps.
        assert!(steps < 15, "{steps}");
        let at_end = bracket((0.0, -1.0), (1.0, 0.0), |x| x - 1.0);
        assert_eq!((at_end.below, at_end.above), (1.0, 1.0));
        let at_start = bracket((0.0, 0.0), (1.0, 1.0), |x| x);
        assert!(at_start.below == 0.0 && at_start.above < 1e-15);
        let jump = bracket(
            (0.0, -1.0),
            (1.0, 1.0),
            |x| if x < 0.3 { -1.0 } else { 1.0 },
        );
        assert!(jump.below < 0.3 && jump.above >= 0.3 && jump.above - jump.below < 1e-15);
    }

    proptest! {
        #[test]
        fn the_bracket_keeps_its_signs(root in 0.0..1.0_f64, power in 1..6_i32, scale in 1e-9..1e9_f64) {
            // Odd powers, so that the sum is monotone and has this one root.
            let f = |x: f64| scale * ((x - root) + (x - root).powi(2 * power - 1));
            let (low, high) = (f(-1.0), f(2.0));
            let found = bracket((-1.0, low), (2.0, high), f);
            prop_assert!(f(found.below) <= 0.0 && f(found.above) >= 0.0);
            prop_assert!((found.above - found.below).abs() < 1e-14, "{found:?}");
        }
    }
}
