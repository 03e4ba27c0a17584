//! Properties of all profiles, for any numbers.

use coaxle_clock::Seconds;
use proptest::prelude::*;
use std::vec::Vec;

use super::{Kinematics, Limits, Profile, to_position, to_velocity};

/// Slack for rounding, relative to the largest quantity of its kind in the motion.
const SLACK: f64 = 1e-9;

/// A number spread evenly over decades.
fn decades(from: i32, to: i32) -> impl Strategy<Value = f64> {
    (f64::from(from)..f64::from(to)).prop_map(|exponent| libm::pow(10.0, exponent))
}

fn limits() -> impl Strategy<Value = Limits> {
    (decades(-1, 4), decades(0, 5), decades(0, 5), decades(2, 8))
        .prop_map(|(v, a, d, j)| Limits::new(v, a, d, j).unwrap())
}

fn symmetric_limits() -> impl Strategy<Value = Limits> {
    limits().prop_map(|l| {
        Limits::new(l.velocity(), l.acceleration(), l.acceleration(), l.jerk()).unwrap()
    })
}

/// A start from which the limits can be kept.
fn start(limits: &Limits) -> impl Strategy<Value = Kinematics> + use<> {
    let (v_max, j) = (limits.velocity(), limits.jerk());
    let a_max = limits.acceleration().min(limits.deceleration());
    (-1e4..1e4, -1.0..1.0, -1.0..1.0).prop_map(move |(position, v, a): (f64, f64, f64)| {
        // Leading the acceleration to zero must not pass the velocity limit.
        let a_max = a_max.min(libm::sqrt(j * v_max));
        let acceleration = a * a_max;
        let coasting = acceleration * acceleration.abs() / (2.0 * j);
        Kinematics {
            position,
            velocity: v * (v_max - coasting.abs()),
            acceleration,
        }
    })
}

/// A start without any guarantees.
fn wild_start() -> impl Strategy<Value = Kinematics> {
    (-1e4..1e4, -1e5..1e5, -1e5..1e5).prop_map(|(position, velocity, acceleration)| Kinematics {
        position,
        velocity,
        acceleration,
    })
}

fn distance() -> impl Strategy<Value = f64> {
    (decades(-6, 5), any::<bool>()).prop_map(|(d, forward)| if forward { d } else { -d })
}

fn job() -> impl Strategy<Value = (Limits, Kinematics, f64)> {
    limits().prop_flat_map(|limits| (Just(limits), start(&limits), distance()))
}

/// A plan from a number that is none ends, although none of its comparisons holds.
#[test]
fn a_start_that_is_no_number_ends() {
    let limits = Limits::new(500.0, 5_000.0, 5_000.0, 5e4).unwrap();
    for (place, target) in [(0, 1.0), (1, 1.0), (2, 1.0), (3, f64::NAN)] {
        let mut start = [0.0; 4];
        start[place] = f64::NAN;
        let start = Kinematics {
            position: start[0],
            velocity: start[1],
            acceleration: start[2],
        };
        let _ = to_position(&start, target, &limits);
    }
}

/// Begins of the phases, and the end.
fn knots(profile: &Profile) -> Vec<f64> {
    let mut knots: Vec<f64> = profile.phase_begins().map(|t| t.0).collect();
    knots.push(profile.duration().0);
    knots
}

/// States in which a quantity can be extreme: phase ends, and places where the acceleration passes
/// through zero.
fn extremes(profile: &Profile) -> Vec<Kinematics> {
    let knots = knots(profile);
    let mut states: Vec<Kinematics> = knots.iter().map(|&t| profile.at(Seconds(t))).collect();
    for &t in &knots {
        let jerk = profile.jerk_at(Seconds(t));
        let crossing = t - profile.at(Seconds(t)).acceleration / jerk;
        if jerk != 0.0 && crossing > t && profile.jerk_at(Seconds(crossing)) == jerk {
            states.push(profile.at(Seconds(crossing)));
        }
    }
    states
}

/// Reference magnitudes of rounding errors.
struct ProfileScale {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

fn scale(profile: &Profile) -> ProfileScale {
    let states = extremes(profile);
    let largest = |quantity: fn(&Kinematics) -> f64| {
        states
            .iter()
            .map(|s| quantity(s).abs())
            // Never zero: the rounding of an axis at rest has to fit in.
            .fold(1e-12, f64::max)
    };
    let velocity = largest(|s| s.velocity);
    ProfileScale {
        position: largest(|s| s.position).max(velocity * profile.duration().0),
        velocity,
        acceleration: largest(|s| s.acceleration),
    }
}

/// Checks that there is no jump from the last moment of a phase to the first of the next. That moment is
/// as early as the resolution of the time allows, which is coarse for a long motion with a high jerk.
fn assert_continuous(profile: &Profile, limits: &Limits) {
    let scale = scale(profile);
    for t in knots(profile) {
        let moment = 4.0 * (t - t.next_down());
        let before = profile.at(Seconds(t.next_down()));
        let after = profile.at(Seconds(t));
        let jump = |quantity: fn(&Kinematics) -> f64, scale: f64, rate: f64| {
            (quantity(&before) - quantity(&after)).abs() > SLACK * scale + moment * rate
        };
        assert!(
            !jump(|s| s.position, scale.position, scale.velocity)
                && !jump(|s| s.velocity, scale.velocity, scale.acceleration)
                && !jump(|s| s.acceleration, scale.acceleration, limits.jerk()),
            "at {t}: {before:?} {after:?}"
        );
    }
}

fn assert_within(limits: &Limits, profile: &Profile) {
    for state in extremes(profile) {
        let speed = state.velocity.abs();
        assert!(speed <= limits.velocity() * (1.0 + SLACK), "{state:?}");
        // Next to standstill, rounding decides which of the two limits applies.
        let standing = speed <= SLACK * scale(profile).velocity;
        let limit = if standing {
            limits.acceleration().max(limits.deceleration())
        } else if state.velocity * state.acceleration > 0.0 {
            limits.acceleration()
        } else {
            limits.deceleration()
        };
        assert!(
            state.acceleration.abs() <= limit * (1.0 + SLACK),
            "{state:?}"
        );
    }
    for t in profile.phase_begins() {
        assert!(profile.jerk_at(t).abs() <= limits.jerk());
    }
}

/// Returns the duration by the textbook: rest to rest with equal acceleration and deceleration in seven
/// phases.
fn rest_to_rest(distance: f64, limits: &Limits) -> f64 {
    let (v, a, j) = (limits.velocity(), limits.acceleration(), limits.jerk());
    let ramp = |v: f64| {
        if v * j >= a * a {
            v / a + a / j
        } else {
            2.0 * libm::sqrt(v / j)
        }
    };
    // Both ramps cover v/2 each on average, so together v · ramp.
    if distance >= v * ramp(v) {
        return distance / v + ramp(v);
    }
    // Twice the distance of a ramp that just reaches a: v = a²/j in 2a/j.
    if distance >= 2.0 * a * a * a / (j * j) {
        // The peak velocity of p²/a + p·a/j = distance.
        let p = (a / j) * a;
        let peak = (libm::sqrt(p * p + 4.0 * a * distance) - p) / 2.0;
        return 2.0 * (peak / a + a / j);
    }
    // Four phases of T: the distance is 2·j·T³.
    4.0 * libm::cbrt(distance / (2.0 * j))
}

fn assert_close(received: f64, expected: f64) {
    let slack = SLACK * expected.abs();
    assert!(
        (received - expected).abs() <= slack,
        "received {received}, expected {expected}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn a_way_keeps_its_limits_and_ends_at_rest_at_its_target((limits, start, distance) in job()) {
        let target = start.position + distance;
        let profile = to_position(&start, target, &limits);
        assert_eq!(profile.at(Seconds::ZERO), if profile.duration().0 > 0.0 { start } else { profile.end() });
        assert_eq!(profile.end(), Kinematics::at_rest(target));
        assert_within(&limits, &profile);
        assert_continuous(&profile, &limits);
    }

    #[test]
    fn a_change_keeps_its_limits_and_goes_on_at_its_target(
        (limits, start, _) in job(),
        share in -1.0..1.0,
    ) {
        let target = share * limits.velocity();
        let profile = to_velocity(&start, target, &limits);
        let end = profile.end();
        assert_eq!((end.velocity, end.acceleration), (target, 0.0));
        assert_within(&limits, &profile);
        assert_continuous(&profile, &limits);
        let later = profile.at(profile.duration() + Seconds(2.0));
        assert_eq!((later.velocity, later.acceleration), (target, 0.0));
        let scale = scale(&profile).position + 2.0 * target.abs();
        assert!((later.position - end.position - 2.0 * target).abs() <= SLACK * scale);
    }

    #[test]
    fn any_start_is_led_to_the_target(
        limits in limits(),
        start in wild_start(),
        distance in distance(),
    ) {
        let target = start.position + distance;
        let profile = to_position(&start, target, &limits);
        assert_eq!(profile.end(), Kinematics::at_rest(target));
        assert_continuous(&profile, &limits);
        for t in profile.phase_begins() {
            assert!(profile.jerk_at(t).abs() <= limits.jerk());
        }
    }

    #[test]
    fn both_directions_are_alike((limits, start, distance) in job()) {
        let here = Kinematics { position: 0.0, ..start };
        let there = to_position(&here, distance, &limits);
        let mirrored = to_position(&here.mirrored(), -distance, &limits);
        assert_eq!(there.duration(), mirrored.duration());
        // Equal bits: the plan for the other direction is the mirrored one, not one of its own.
        for share in [0.1, 0.35, 0.5, 0.8] {
            let t = Seconds(there.duration().0 * share);
            assert_eq!(there.at(t), mirrored.at(t).mirrored());
        }
    }

    #[test]
    fn rest_to_rest_is_as_fast_as_the_textbook(
        limits in symmetric_limits(),
        distance in decades(-6, 5),
    ) {
        let profile = to_position(&Kinematics::at_rest(0.0), distance, &limits);
        assert_close(profile.duration().0, rest_to_rest(distance, &limits));
    }

    /// Limits that a config admits, in every combination.
    #[test]
    fn rest_to_rest_is_that_in_all_decades(
        (v, a, j) in (decades(-9, 15), decades(-9, 15), decades(-9, 15)),
        distance in decades(-6, 6),
    ) {
        let limits = Limits::new(v, a, a, j).unwrap();
        let profile = to_position(&Kinematics::at_rest(0.0), distance, &limits);
        assert_close(profile.duration().0, rest_to_rest(distance, &limits));
        assert_eq!(profile.end(), Kinematics::at_rest(distance));
        let states = extremes(&profile);
        assert!(states.iter().all(|s| s.velocity >= -1e-9 * v && s.velocity <= v * (1.0 + 1e-9)), "{states:?}");
        assert!(states.iter().all(|s| s.acceleration.abs() <= a * (1.0 + 1e-9)), "{states:?}");
        assert!(states.iter().all(|s| (-1e-9 * distance..=distance * (1.0 + 1e-9)).contains(&s.position)), "{states:?}");
    }

    #[test]
    fn planned_again_on_the_way_it_takes_as_long(
        limits in limits(),
        distance in decades(-3, 4),
        share in 0.02..0.98,
    ) {
        let whole = to_position(&Kinematics::at_rest(0.0), distance, &limits);
        let t = whole.duration().0 * share;
        let rest = to_position(&whole.at(Seconds(t)), distance, &limits);
        // Near a stop, the time left depends on the cube root of the distance left.
        let slack = 1e-4 * whole.duration().0;
        assert!((rest.duration().0 + t - whole.duration().0).abs() <= slack,
            "{} + {t}, {}", rest.duration().0, whole.duration().0);
    }

    #[test]
    fn a_longer_way_takes_longer(limits in limits(), distance in decades(-6, 5)) {
        let rest = Kinematics::at_rest(0.0);
        let short = to_position(&rest, distance, &limits).duration();
        // A percent farther is 0.3 % longer even where the time grows by the cube root.
        let long = to_position(&rest, distance * 1.01, &limits).duration();
        assert!(short < long);
    }
}

#[test]
fn an_axis_that_cannot_stop_in_time_comes_back() {
    let limits = Limits::new(100.0, 200.0, 200.0, 2_000.0).unwrap();
    let start = Kinematics {
        position: 0.0,
        velocity: 80.0,
        acceleration: 0.0,
    };
    // A stop from 80 u/s takes 80/200 + 200/2000 = 0.5 s and 20 u, so 1 u is passed.
    let profile = to_position(&start, 1.0, &limits);
    let farthest = extremes(&profile)
        .iter()
        .map(|state| state.position)
        .fold(0.0, f64::max);
    assert!(farthest > 1.0);
    assert!(extremes(&profile).iter().any(|s| s.velocity < 0.0));
    assert_eq!(profile.end(), Kinematics::at_rest(1.0));
    assert_within(&limits, &profile);
}

#[test]
fn a_start_above_the_velocity_limit_is_slowed_to_it() {
    let limits = Limits::new(10.0, 200.0, 200.0, 2_000.0).unwrap();
    let start = Kinematics {
        position: 0.0,
        velocity: 80.0,
        acceleration: 0.0,
    };
    let profile = to_position(&start, 1_000.0, &limits);
    assert_eq!(profile.at(Seconds(2.0)).velocity, 10.0);
    assert!(extremes(&profile).iter().all(|s| s.velocity <= 80.0));
    // Little farther than a stop: slowed down, but neither faster than at the start nor reversed.
    let stop = to_velocity(&start, 0.0, &limits).end().position;
    let short = to_position(&start, stop + 0.05, &limits);
    assert!(
        extremes(&short)
            .iter()
            .all(|s| (-1e-9..=80.0).contains(&s.velocity))
    );
}

#[test]
fn being_there_already_takes_no_time() {
    let limits = Limits::new(1.0, 1.0, 1.0, 1.0).unwrap();
    let profile = to_position(&Kinematics::at_rest(7.0), 7.0, &limits);
    assert_eq!(profile.duration(), Seconds::ZERO);
    assert_eq!(profile.at(Seconds(3.0)), Kinematics::at_rest(7.0));
}
