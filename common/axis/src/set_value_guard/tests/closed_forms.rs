//! The closed forms against stepping through the motion.

use proptest::prelude::*;

use super::super::closed_forms::{acceleration_to_gain, least_peak, speed_gained, stop_way};

/// A state, and its greatest accelerations in both directions.
#[derive(Clone, Copy, Debug)]
struct Case {
    w: f64,
    b: f64,
    upper: f64,
    lower: f64,
}

fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|exponent| libm::pow(10.0, exponent))
}

fn signed(size: impl Strategy<Value = f64>) -> impl Strategy<Value = f64> {
    (size, any::<bool>()).prop_map(|(size, up)| if up { size } else { -size })
}

/// Bounds from far below the jerk of one cycle (the acceleration is reached at once) to many cycles
/// of it.
fn case() -> impl Strategy<Value = Case> {
    let fraction = -1.0..1.0;
    (
        decades(-2.0, 2.0),
        decades(-2.0, 2.0),
        fraction,
        signed(decades(-3.0, 4.0)),
    )
        .prop_map(|(upper, lower, share, w): (f64, f64, f64, f64)| Case {
            w,
            b: if share > 0.0 {
                share * upper
            } else {
                share * lower
            },
            upper,
            lower,
        })
}

/// The acceleration is reduced to zero in one direction and the speed would reverse on the way: the
/// last braking is in the other direction, or only just not.
fn turning() -> impl Strategy<Value = Case> {
    (case(), -1.2..0.2).prop_map(|(case, share): (Case, f64)| {
        let b = -case.b.abs().min(case.lower);
        Case {
            w: share * speed_gained(b),
            b,
            ..case
        }
    })
}

/// Braking harder than the bound, which has come down.
fn beyond() -> impl Strategy<Value = Case> {
    (case(), 1.0..3.0).prop_map(|(case, over): (Case, f64)| {
        let b = -over * case.lower;
        Case {
            w: case.w.abs() + speed_gained(-b),
            b,
            ..case
        }
    })
}

/// The optimal stop, cycle by cycle.
fn stepped_way(case: &Case) -> f64 {
    let Case {
        mut w,
        mut b,
        upper,
        lower,
    } = *case;
    let (mut way, mut rounding) = (0.0, 0.0);
    // Last cycles leave a rounding of the speed, which is never exactly 0.
    let still = 1e-13 * (1.0 + w.abs());
    for _ in 0..10_000_000 {
        if w.abs() <= still && b.abs() <= 1e-13 * (1.0 + case.b.abs()) {
            return way;
        }
        b = (-acceleration_to_gain(w))
            .clamp(b - 1.0, b + 1.0)
            .clamp(-lower, upper);
        w += b;
        // Summed with compensation, because distances cancel where the motion reverses.
        let term: f64 = w - rounding;
        let sum = way + term;
        rounding = (sum - way) - term;
        way = sum;
    }
    panic!("does not stop: {case:?}");
}

/// Brakes as hard as possible until it reverses.
fn stepped_peak(case: &Case) -> f64 {
    let Case {
        mut w,
        mut b,
        lower,
        ..
    } = *case;
    let (mut x, mut peak) = (0.0, 0.0);
    loop {
        // Hardest braking without a release: the least peak of all motions.
        b = (b - 1.0).max(-lower);
        w += b;
        x += w;
        peak = f64::max(peak, x);
        if w <= 0.0 && b <= 0.0 {
            return peak;
        }
    }
}

/// Reference size for the distances of both directions.
fn size(case: &Case) -> f64 {
    let gained = case.w.abs() + speed_gained(case.b).abs() + case.b.abs();
    gained.max(gained * case.b.abs())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn the_speed_gained_and_its_inverse_agree(c in signed(decades(-6.0, 8.0))) {
        let b = acceleration_to_gain(c);
        prop_assert!((b + speed_gained(b) - c).abs() <= 1e-14 * c.abs().max(b.abs()));
        prop_assert_eq!(acceleration_to_gain(-c), -b);
        prop_assert_eq!(speed_gained(-b), -speed_gained(b));
    }

    #[test]
    fn the_way_of_a_stop_is_that_of_its_cycles(case in prop_oneof![case(), turning(), beyond()]) {
        let (received, expected) = (stop_way(case.w, case.b, case.upper, case.lower), stepped_way(&case));
        prop_assert!((received - expected).abs() <= 1e-9 * expected.abs().max(1e-3 * size(&case)),
            "{:?}: received {}, expected {}", case, received, expected);
    }

    #[test]
    fn the_least_peak_is_that_of_the_hardest_braking(case in prop_oneof![case(), turning()]) {
        let (received, expected) = (least_peak(case.w, case.b, case.lower), stepped_peak(&case));
        prop_assert!((received - expected).abs() <= 1e-9 * expected.abs().max(1e-3 * size(&case)),
            "{:?}: received {}, expected {}", case, received, expected);
    }

    #[test]
    fn a_stop_goes_farther_the_faster_it_begins(case in case(), more in decades(-6.0, 1.0)) {
        let way = |w: f64, b: f64| stop_way(w, b, case.upper, case.lower);
        let slack = 1e-9 * size(&case);
        prop_assert!(way(case.w + more, case.b) >= way(case.w, case.b) - slack);
        prop_assert!(way(case.w, (case.b + more).min(case.upper)) >= way(case.w, case.b) - slack);
    }
}
