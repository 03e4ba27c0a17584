use proptest::prelude::*;

use super::*;
use crate::true_time::True;

/// True duration of a sender's cycle: its clock is 100 ppm slow.
const CYCLE_NS: i64 = 1_000_100;

fn empty() -> Oracle<True> {
    let cycle_time = CycleTime::new(Span::from_millis(1)).unwrap();
    Oracle::new(cycle_time, Span::from_secs(1))
}

/// Pace of its own time.
const PACE: f64 = 1e6 / CYCLE_NS as f64;

/// A master that moves as a polynomial of its own time, sampled at its cycles.
fn sample(epoch: u64, count: u64, motion: &[f64]) -> TruthSample<True> {
    let [position, velocity, acceleration] = derivatives(motion, count as f64 * 1e-3);
    TruthSample {
        at: Instant::from_nanos(count as i64 * CYCLE_NS),
        epoch,
        count,
        axis: Kinematics {
            position,
            velocity,
            acceleration,
        },
        present_after: Span::ZERO,
    }
}

/// A polynomial's value and its first two derivatives.
fn derivatives(coefficients: &[f64], t: f64) -> [f64; 3] {
    let terms = coefficients.iter().zip(0_i32..);
    terms.fold([0.0; 3], |[p, v, a], (c, n)| {
        let n_f = f64::from(n);
        [
            p + c * t.powi(n),
            v + c * n_f * t.powi((n - 1).max(0)),
            a + c * n_f * (n_f - 1.0) * t.powi((n - 2).max(0)),
        ]
    })
}

const ACCELERATING: [f64; 3] = [0.0, 0.0, 100.0];

fn oracle(cycles: std::ops::Range<u64>) -> Oracle<True> {
    let mut oracle = empty();
    cycles.for_each(|count| oracle.push(sample(1, count, &ACCELERATING)));
    oracle
}

proptest! {
    /// Six coefficients fit the states at both ends: any motion of degree five is exact in between.
    #[test]
    fn motion_between_cycles_is_exact(
        motion in prop::collection::vec(-100.0..100.0f64, 1..=6),
        nanos in 0..99 * CYCLE_NS,
    ) {
        let mut oracle = empty();
        (0..100).for_each(|count| oracle.push(sample(1, count, &motion)));
        let at = Instant::from_nanos(nanos);
        let [position, own_velocity, _] = derivatives(&motion, PACE * at.since_epoch().as_secs_f64());
        let velocity = PACE * own_velocity;
        let truth = oracle.at(at).unwrap();
        let newest = oracle.known_until() == Some(at);
        prop_assert!(newest || (truth.pace - PACE).abs() < 1e-15, "{truth:?}");
        // Positions stay below 112 within 0.1 s, with a rounding of 1e-14 per operation.
        prop_assert!((truth.position - position).abs() < 1e-11, "{truth:?} {position}");
        prop_assert!((truth.velocity - velocity).abs() < 1e-8, "{truth:?} {velocity}");
    }

    /// A cycle lasts a millisecond of the sender's clock, independent of its true duration.
    #[test]
    fn the_senders_own_time_runs_at_its_own_pace(
        from in 0..99 * CYCLE_NS,
        to in 0..99 * CYCLE_NS,
        off in -5_000_000..5_000_000i64,
    ) {
        let oracle = oracle(0..100);
        let own_ns = |nanos: i64| nanos as f64 * 1e6 / CYCLE_NS as f64;
        let truth = |nanos| oracle.at(Instant::from_nanos(nanos)).unwrap();
        let shown = Instant::from_nanos(own_ns(to).round() as i64 + off);
        let rounded = own_ns(to).round() - own_ns(to);
        let error_ns = truth(to).error_of(shown).0 * 1e9;
        // A thousandth of a nanosecond: whole nanoseconds as integers, fractions as floats.
        prop_assert!((error_ns - (off as f64 + rounded)).abs() < 1e-3, "{error_ns} {off}");
        let passed_ns = truth(to).seconds_since(&truth(from)).0 * 1e9;
        let expected = own_ns(to) - own_ns(from);
        prop_assert!((passed_ns - expected).abs() < 1e-3, "{passed_ns} {expected}");
    }
}

#[test]
fn at_a_cycle_it_is_what_was_pushed() {
    let mut oracle = empty();
    assert_eq!(oracle.known_until(), None);
    for count in 5..8 {
        let TruthSample { at, axis, .. } = sample(3, count, &ACCELERATING);
        oracle.push(sample(3, count, &ACCELERATING));
        assert_eq!(oracle.known_until(), Some(at));
        let truth = oracle.at(at).unwrap();
        assert_eq!((truth.epoch, truth.position), (3, axis.position));
        // The first cycle alone does not say how long it takes by reference time.
        let pace = if count == 5 { 1.0 } else { PACE };
        assert!((truth.pace - pace).abs() < 1e-15);
        assert_eq!(truth.velocity, axis.velocity * truth.pace);
        let own = Instant::from_nanos(count as i64 * 1_000_000);
        assert_eq!(truth.error_of(own), Seconds(0.0));
    }
}

#[test]
fn nothing_is_known_before_it_began_or_after_what_is_known() {
    let oracle = oracle(5..8);
    let known = |nanos| oracle.at(Instant::from_nanos(nanos)).is_some();
    assert!(!known(5 * CYCLE_NS - 1) && known(5 * CYCLE_NS));
    assert!(known(7 * CYCLE_NS) && !known(7 * CYCLE_NS + 1));
    assert!(empty().at(Instant::EPOCH).is_none());
}

#[test]
fn motion_over_a_long_gap_is_not_made_up() {
    for (gap, known) in [(LARGEST_GAP, true), (LARGEST_GAP + 1, false)] {
        let mut oracle = oracle(0..10);
        for count in 9 + gap..20 + gap {
            oracle.push(sample(1, count, &ACCELERATING));
        }
        let at = |cycle| oracle.at(Instant::from_nanos(cycle * CYCLE_NS + 1));
        assert_eq!(at(12).is_some(), known, "{gap}");
        assert!(at(8).is_some() && at(9 + gap as i64).is_some(), "{gap}");
    }
}

#[test]
fn from_one_run_to_the_next_there_is_no_motion() {
    let mut oracle = oracle(0..10);
    (10..20).for_each(|count| oracle.push(sample(2, count, &ACCELERATING)));
    let epoch = |cycle: i64, beyond| {
        let truth = oracle.at(Instant::from_nanos(cycle * CYCLE_NS + beyond));
        truth.map(|truth| truth.epoch)
    };
    assert_eq!(epoch(9, 0), Some(1));
    assert_eq!(epoch(9, 1), None);
    assert_eq!(epoch(10, -1), None);
    assert_eq!(epoch(10, 0), Some(2));
}

#[test]
fn it_remembers_as_long_as_it_says_and_no_longer() {
    let oracle = oracle(0..50_000);
    // A second of cycles of a millisecond, and some spare.
    assert!(oracle.samples.len() < 1_010);
    let newest = oracle.known_until().unwrap();
    assert!(oracle.at(newest - Span::from_millis(999)).is_some());
    assert!(oracle.at(newest - Span::from_millis(1_001)).is_none());
}

#[test]
fn what_is_shown_later_has_the_delay_of_its_own_frame() {
    let mut oracle = empty();
    let delay = |count: u64| match count {
        0..100 => Span::from_millis(20),
        // Slewed, by a microsecond in a cycle, and a step.
        100..300 => Span::from_millis(20) + Span::from_micros(count as i64 - 100),
        _ => Span::from_millis(50),
    };
    for count in 0..500 {
        oracle.push(TruthSample {
            present_after: delay(count),
            ..sample(3, count, &ACCELERATING)
        });
    }
    // Generated in a cycle, and half a cycle later.
    for (half_cycles, expected) in [
        (100, 20_000.0),
        (200, 20_000.0),
        (400, 20_100.0),
        (401, 20_100.5),
        (598, 20_199.0),
        (700, 50_000.0),
    ] {
        let generated = Instant::from_nanos(half_cycles * CYCLE_NS / 2);
        let delay = Span::from_micros_f64(expected);
        for left in [0, 3] {
            let left = Span::from_millis(left);
            let at = generated + delay - left;
            assert_eq!(oracle.shown_after(at, left), Some(delay), "{half_cycles}");
        }
    }
    assert_eq!(oracle.shown_after(Instant::from_nanos(0), Span::ZERO), None);
}
