use proptest::prelude::*;

use super::*;
use crate::config::{
    ChangeMicros, FaultSeconds, Fraction, PeriodSeconds, Ppm, SineConfig, Term, WalkPpm, Wave,
    parse,
};
use crate::faults::statistics::{assert_distributed, assert_moments, normal};

enum Reference {}
impl Domain for Reference {
    const NAME: &'static str = "reference";
}

type Clock = DeviatedClock<Reference>;

fn clock(config: &str) -> Clock {
    let config = parse("test", config).unwrap();
    Clock::new(&config, 7, Instant::EPOCH).unwrap()
}

fn at(secs: f64) -> Instant<Reference> {
    Instant::EPOCH + Span::from_secs_f64(secs)
}

fn deviation_us(clock: &mut Clock, secs: f64) -> f64 {
    let local = clock.local_at(at(secs)).since_epoch();
    (local - at(secs).since_epoch()).as_micros_f64()
}

#[test]
fn constant_drift_adds_up_without_rounding_error() {
    // A day. A minute's gain is not a whole number of nanoseconds, so rounding each would show.
    for (ppm, expected) in [("0.1", 8_640.0), ("0.1234567", 10_666.658_88)] {
        let mut clock = clock(&format!("drift-ppm = {ppm}"));
        let deviation = deviation_us(&mut clock, 86_400.0);
        // 2 ns: the floats of the expected figure, and of the conversion.
        assert!((deviation - expected).abs() < 0.002, "{deviation}");
    }
}

#[test]
fn a_drift_step_begins_at_its_instant() {
    let mut clock = clock("steps = [{ at-s = 10, drift-ppm = 5 }]");
    assert_eq!(deviation_us(&mut clock, 10.0), 0.0);
    assert_eq!(clock.drift_ppm(), 5.0);
    // 5 ppm for two seconds.
    assert_eq!(deviation_us(&mut clock, 12.0), 10.0);
}

#[test]
fn a_phase_step_jumps_ahead_once() {
    let mut clock = clock("steps = [{ at-s = 2, phase-us = 300 }]");
    assert_eq!(deviation_us(&mut clock, 1.999), 0.0);
    assert_eq!(deviation_us(&mut clock, 2.0), 300.0);
    assert_eq!(deviation_us(&mut clock, 200.0), 300.0);
    // Local instants inside the jump all happen at it.
    let inside = Instant::EPOCH + Span::from_micros(2_000_100);
    assert_eq!(clock.reference_at(inside), at(2.0));
}

#[test]
fn a_phase_step_back_reads_again_what_was_read_before() {
    let mut clock = clock("steps = [{ at-s = 2, phase-us = -300 }]");
    assert_eq!(deviation_us(&mut clock, 1.9999), 0.0);
    assert_eq!(deviation_us(&mut clock, 2.0), -300.0);
    assert_eq!(deviation_us(&mut clock, 200.0), -300.0);
    let local = |micros| Instant::EPOCH + Span::from_micros(micros);
    // The clock reads these twice: the first time counts.
    assert_eq!(clock.reference_at(local(1_999_900)), at(1.9999));
    assert_eq!(clock.reference_at(local(1_999_999)), at(1.999_999));
    // 300 µs later than without the jump.
    assert_eq!(clock.reference_at(local(2_000_000)), at(2.0003));
    assert_eq!(clock.reference_at(local(2_500_000)), at(2.5003));
}

#[test]
fn the_first_time_it_reads_that_does_not_depend_on_how_far_it_went_since() {
    let config = "drift-ppm = 150\nsteps = [{ at-s = 1, phase-us = -2e6 }, { at-s = 2, phase-us = 5e5 }, \
                  { at-s = 2.5, phase-us = -1e7 }]";
    let (mut early, mut late) = (clock(config), clock(config));
    let _ = late.local_at(at(60.0));
    for k in 0..6_000 {
        let local = Instant::EPOCH + Span::from_millis(k);
        let when = early.reference_at(local);
        assert_eq!(late.reference_at(local), when, "{k}");
        let reads = early.local_at(when);
        assert!(
            (reads - local).abs() <= NANOSECOND || when == at(2.5),
            "{k}: {reads:?}"
        );
    }
}

#[test]
fn it_reads_zero_at_its_origin() {
    let config = parse("test", "drift-ppm = 100").unwrap();
    let mut clock = Clock::new(&config, 7, at(3.0)).unwrap();
    assert_eq!(clock.local_at(at(3.0)), Instant::EPOCH);
    assert_eq!(clock.reference_at(Instant::EPOCH), at(3.0));
    let after = clock.local_at(at(4.0)).since_epoch();
    assert_eq!(after, Span::from_nanos(1_000_100_000));
}

#[test]
fn a_sine_has_its_closed_form() {
    let mut clock = clock("sine = { amplitude-ppm = 10, period-s = 4 }");
    for eighth in 1..24 {
        let angle = f64::from(eighth) * core::f64::consts::FRAC_PI_4;
        let deviation = deviation_us(&mut clock, 0.5 * f64::from(eighth));
        // The integral of 10·sin(2π·t/4).
        let expected = 10.0 * 4.0 / core::f64::consts::TAU * (1.0 - angle.cos());
        assert!(
            // A thousandth of the swing of 12.7 µs.
            (deviation - expected).abs() < 0.01,
            "{eighth}: {deviation}, {expected}"
        );
        assert!(
            (clock.drift_ppm() - 10.0 * angle.sin()).abs() < 0.1,
            "{eighth}"
        );
    }
}

/// Drift after 2 s, its change until 4 s, and the deviation after 2 s, µs, of many random walks.
fn walks(ppm: f64) -> [Vec<f64>; 3] {
    let config = parse("test", &format!("random-walk-ppm = {ppm}")).unwrap();
    let mut seen = [const { Vec::new() }; 3];
    for seed in 0..2_000 {
        let mut clock = Clock::new(&config, seed, Instant::EPOCH).unwrap();
        let deviation = deviation_us(&mut clock, 2.0);
        let first = clock.drift_ppm();
        let _ = clock.local_at(at(4.0));
        let change = clock.drift_ppm() - first;
        for (seen, value) in seen.iter_mut().zip([first, change, deviation]) {
            seen.push(value);
        }
    }
    seen
}

#[test]
fn a_random_walk_has_independent_normal_steps() {
    let [first, change, deviation] = walks(0.5);
    // 0.5 ppm/√s over 2 s.
    let spread = 0.5 * 2f64.sqrt();
    for drift in [&first, &change] {
        assert_moments(drift, 0.0, spread);
        assert_distributed(drift, |x| normal(x, spread));
    }
    let products = first.iter().zip(&change).map(|(a, b)| a * b);
    let correlation = products.sum::<f64>() / (spread * spread * first.len() as f64);
    // Four standard errors of a correlation of zero.
    assert!(
        correlation.abs() < 4.0 / (first.len() as f64).sqrt(),
        "{correlation}"
    );
    // The integral of a walk spreads with the power 3/2 of time.
    let spread = 0.5 * (8f64 / 3.0).sqrt();
    assert_moments(&deviation, 0.0, spread);
    assert_distributed(&deviation, |x| normal(x, spread));
}

#[test]
fn terms_have_their_closed_forms_at_the_ends_of_pieces() {
    type Form = fn(f64) -> f64;
    // Accumulated drift, µs: exact at the ends of pieces, regardless of the edges within.
    let forms: [(&str, Form); 5] = [
        ("{ sine = { amplitude = 10, period-s = 4 } }", |t| {
            10.0 * 4.0 / core::f64::consts::TAU * (1.0 - (t * core::f64::consts::FRAC_PI_2).cos())
        }),
        ("{ triangle = { amplitude = 10, period-s = 4 } }", |t| {
            // Parabolas, up for half a period and down for the other.
            let passed = t.rem_euclid(4.0);
            let hump = |u: f64| {
                if u < 1.0 {
                    5.0 * u * u
                } else {
                    10.0 - 5.0 * (2.0 - u).powi(2)
                }
            };
            if passed < 2.0 {
                hump(passed)
            } else {
                hump(4.0 - passed)
            }
        }),
        (
            "{ pulse = { height = 10, period-s = 0.0073, duty = 0.5 } }",
            |t| {
                let (whole, rest) = ((t / 0.0073).floor(), t.rem_euclid(0.0073));
                10.0 * (0.00365 * whole + rest.min(0.00365))
            },
        ),
        ("{ step = { at-s = 1.234, by = 10 } }", |t| {
            10.0 * (t - 1.234).max(0.0)
        }),
        ("{ step = { at-s = 1.234, by = 10, over-s = 2 } }", |t| {
            let passed = (t - 1.234).max(0.0);
            if passed < 2.0 {
                2.5 * passed * passed
            } else {
                10.0 * (passed - 1.0)
            }
        }),
    ];
    for (term, form) in forms {
        let mut clock = clock(&format!("drift-terms-ppm = [{term}]"));
        for k in 1..200 {
            let secs = 0.05 * f64::from(k);
            let (deviation, expected) = (deviation_us(&mut clock, secs), form(secs));
            let off = (deviation - expected).abs();
            // 2 ns: the exact mean of each piece leaves rounding only.
            assert!(
                off < 0.002,
                "{term} at {secs} s: {deviation}, expected {expected}"
            );
        }
    }
}

#[test]
fn noise_of_the_drift_is_white() {
    let config = parse("test", "drift-terms-ppm = [{ normal = 30 }]").unwrap();
    let deviations = (0..2_000).map(|seed| {
        let mut clock = Clock::new(&config, seed, Instant::EPOCH).unwrap();
        deviation_us(&mut clock, 4.0)
    });
    let deviations: Vec<_> = deviations.collect();
    // 400 pieces of 10 ms, each off by 0.3 µs.
    assert_moments(&deviations, 0.0, 0.3 * 20.0);
    assert_distributed(&deviations, |x| normal(x, 6.0));
}

#[test]
fn the_largest_drift_of_all_stops_no_clock() {
    let config = "drift-ppm = -1e5\nsine = { amplitude-ppm = 1e5, period-s = 3 }\n\
                  drift-terms-ppm = [{ constant = -1e5 }, { triangle = { amplitude = 1e5, period-s = 2 } }, \
                  { exponential = -5000 }]\nrandom-walk-ppm = 1000";
    let mut clock = clock(config);
    let mut last = clock.local_at(at(0.0));
    for k in 1..20_000 {
        let reference = at(0.001 * f64::from(k));
        let local = clock.local_at(reference);
        // Half the rate, less a microsecond for rounding.
        assert!(local - last >= Span::from_micros(499), "{reference:?}");
        assert!((clock.reference_at(local) - reference).abs() <= NANOSECOND * 2);
        last = local;
    }
}

#[test]
fn wake_ups_miss_their_instants_as_configured() {
    let config = parse("test", "jitter = { normal-us = 20 }").unwrap();
    let mut jitter = CycleJitter::new(&config, 3);
    let misses: Vec<_> = (0..20_000).map(|_| jitter.next().as_micros_f64()).collect();
    assert_moments(&misses, 0.0, 20.0);
    assert_distributed(&misses, |x| normal(x, 20.0));
    let mut none = CycleJitter::new(&ClockConfig::default(), 3);
    assert!((0..100).all(|_| none.next() == Span::ZERO));
}

/// Steps of drift and phase within half a minute.
fn steps() -> impl Strategy<Value = Vec<DriftStep>> {
    let step = (
        0.001..30.0f64,
        -200.0..200.0f64,
        prop_oneof![Just(0.0), 0.0..5_000.0f64],
    );
    let step = step.prop_map(|(at, drift_ppm, phase)| DriftStep {
        at_s: FaultSeconds::new(at).unwrap(),
        drift_ppm: Ppm::new(drift_ppm).unwrap(),
        phase_us: ChangeMicros::new(phase).unwrap(),
    });
    prop::collection::vec(step, 0..5)
}

/// Terms of every kind but files.
fn terms() -> impl Strategy<Value = Vec<Term<Ppm>>> {
    let ppm = || (-100.0..100.0f64).prop_map(|ppm| Ppm::new(ppm).unwrap());
    let secs = || (0.0..30.0f64).prop_map(|secs| FaultSeconds::new(secs).unwrap());
    let period = || (1e-3..60.0f64).prop_map(|period| PeriodSeconds::new(period).unwrap());
    let share = || (0.0..=1.0f64).prop_map(|share| Fraction::new(share).unwrap());
    let wave = || {
        (ppm(), period(), share()).prop_map(|(amplitude, period_s, phase)| Wave {
            amplitude,
            period_s,
            phase,
        })
    };
    let pulse = (ppm(), period(), share(), share());
    let term = prop_oneof![
        ppm().prop_map(Term::Constant),
        wave().prop_map(Term::Sine),
        wave().prop_map(Term::Triangle),
        pulse.prop_map(|(height, period_s, duty, phase)| Term::Pulse {
            height,
            period_s,
            duty,
            phase
        }),
        (secs(), ppm(), secs()).prop_map(|(at_s, by, over_s)| Term::Step { at_s, by, over_s }),
        (ppm(), ppm()).prop_map(|(from, to)| Term::Uniform { from, to }),
        ppm().prop_map(Term::Exponential),
        ppm().prop_map(Term::Normal),
    ];
    prop::collection::vec(term, 0..4)
}

/// Clock deviations of every kind, alone and together.
fn deviations() -> impl Strategy<Value = ClockConfig> {
    let sine = prop::option::of((0.0..300.0f64, 0.05..100.0f64));
    let walk = prop_oneof![Just(0.0), 0.0..10.0f64];
    let all = (-1000.0..1000.0f64, walk, sine, steps(), terms());
    all.prop_map(|(drift_ppm, walk, sine, steps, terms)| ClockConfig {
        drift_ppm: Ppm::new(drift_ppm).unwrap(),
        random_walk_ppm: WalkPpm::new(walk).unwrap(),
        sine: sine.map(|(amplitude_ppm, period)| SineConfig {
            amplitude_ppm: Ppm::new(amplitude_ppm).unwrap(),
            period_s: PeriodSeconds::new(period).unwrap(),
        }),
        steps,
        drift_terms_ppm: terms,
        ..ClockConfig::default()
    })
}

/// Instants in the order of evaluation: each up to 4 s before the latest.
fn instants() -> impl Strategy<Value = Vec<f64>> {
    let steps = prop::collection::vec((0.0..3.0f64, 0.0..4.0f64), 1..20);
    steps.prop_map(|steps| {
        let latest = steps.iter().scan(0.0, |latest, (on, back)| {
            *latest += on;
            Some(f64::max(0.0, *latest - back))
        });
        latest.collect()
    })
}

const NANOSECOND: Span = Span::from_nanos(1);

proptest! {
    #[test]
    fn reading_it_and_asking_when_it_reads_that_are_inverses(
        config in deviations(),
        instants in instants(),
    ) {
        let mut clock = Clock::new(&config, 3, Instant::EPOCH).unwrap();
        for reference in instants.into_iter().map(at) {
            let local = clock.local_at(reference);
            let back = clock.reference_at(local);
            prop_assert!((back - reference).abs() <= NANOSECOND * 2, "{reference:?} {back:?}");
        }
    }

    #[test]
    fn a_local_instant_is_read_again_but_for_those_that_a_jump_left_out(
        config in deviations(),
        instants in instants(),
    ) {
        let mut clock = Clock::new(&config, 3, Instant::EPOCH).unwrap();
        for secs in instants {
            let local = Instant::EPOCH + Span::from_secs_f64(secs);
            let reference = clock.reference_at(local);
            let again = clock.local_at(reference) - local;
            let jumps = config.steps.iter().filter(|step| {
                let off = step_instant(step) - reference.since_epoch();
                off.abs() <= NANOSECOND
            });
            let left_out: Span = jumps
                .map(|step| Span::from_micros_f64(step.phase_us.get()))
                .fold(Span::ZERO, |sum, jump| sum + jump);
            prop_assert!(again >= NANOSECOND * -2, "{again}");
            prop_assert!(again <= left_out + NANOSECOND * 2, "{again}");
        }
    }

    #[test]
    fn it_never_goes_back_and_its_pieces_meet(
        config in deviations(),
        instants in instants(),
        passed in 1..30_000_000i64,
    ) {
        let mut clock = Clock::new(&config, 3, Instant::EPOCH).unwrap();
        for reference in instants.into_iter().map(at) {
            let passed = Span::from_nanos(passed);
            let local = clock.local_at(reference + passed) - clock.local_at(reference);
            let jumped: Span = config
                .steps
                .iter()
                .filter(|step| {
                    let instant = Instant::EPOCH + step_instant(step);
                    reference < instant && instant <= reference + passed
                })
                .map(|step| Span::from_micros_f64(step.phase_us.get()))
                .fold(Span::ZERO, |sum, jump| sum + jump);
            prop_assert!(local >= Span::ZERO);
            // No drift here is beyond 0.3 %.
            // 1000 of drift, 300 of the sine, four steps of 200 and three terms of 100 ppm, and room for noise.
            let off = (local - passed - jumped).abs().as_nanos() as f64;
            prop_assert!(off <= 2.0 + 3e-3 * passed.as_nanos() as f64, "{off} ns");
        }
    }

    #[test]
    fn what_it_reads_does_not_depend_on_what_was_asked_before(
        config in deviations(),
        instants in instants(),
    ) {
        let mut asked_often = Clock::new(&config, 3, Instant::EPOCH).unwrap();
        for reference in instants.into_iter().map(at) {
            let mut asked_once = Clock::new(&config, 3, Instant::EPOCH).unwrap();
            prop_assert_eq!(asked_often.local_at(reference), asked_once.local_at(reference));
        }
    }

    #[test]
    fn drift_and_steps_have_their_closed_form(
        drift in -1000.0..1000.0f64,
        steps in steps(),
        secs in 0.0..40.0f64,
    ) {
        let config = ClockConfig { drift_ppm: Ppm::new(drift).unwrap(), steps, ..ClockConfig::default() };
        let mut clock = Clock::new(&config, 3, Instant::EPOCH).unwrap();
        let passed = at(secs).since_epoch();
        let gained = |drift_ppm: f64, passed: Span| drift_ppm * passed.as_nanos() as f64 * 1e-9;
        let steps: f64 = config
            .steps
            .iter()
            .map(|step| (step, passed - step_instant(step)))
            .filter(|(_, since)| *since >= Span::ZERO)
            .map(|(step, since)| gained(step.drift_ppm.get(), since) + step.phase_us.get())
            .sum();
        let expected = gained(drift, passed) + steps;
        let deviation = deviation_us(&mut clock, secs);
        // A nanosecond for each number that is rounded.
        prop_assert!((deviation - expected).abs() <= 0.006, "{deviation}, {expected}");
    }
}

#[test]
fn the_nearest_nanosecond_is_that_of_the_standard_library() {
    // Where the quick way ends: 2⁵¹.
    let edge = 2.0_f64.powi(51);
    let mut values = vec![0.0, -0.0, f64::MAX, f64::MIN, f64::INFINITY, edge, -edge];
    for whole in [0.0, 1.0, 2.0, 3.0, 1e6, 4e15, edge - 1.0] {
        // The last is the greatest number below a half.
        for part in [0.0, 0.25, 0.5, 0.75, 0.499_999_999_999_999_94] {
            values.extend([whole + part, -(whole + part)]);
        }
    }
    for value in values {
        assert_eq!(nearest(value), value.round_ties_even(), "{value}");
    }
    assert!(nearest(f64::NAN).is_nan());
}
