//! Bounds by all exchanges, which the window's estimate never contradicts.

use super::*;

/// A line that runs at another rate than the sender, and whose uncertainty just covers that.
fn running(rate: f64, delay: Span) -> FarLine {
    FarLine {
        rate: 1.0 + rate,
        rate_sigma: libm::fabs(rate) / 3.0,
        ..line(delay)
    }
}

/// Sender's lead over such a line, µs.
fn ahead_us(line: &FarLine, now: Instant<Local>) -> f64 {
    let shown = AHEAD + now.since_epoch();
    line.offset_at(shown, now).as_micros()
}

#[test]
fn a_line_that_runs_away_takes_the_delay_along_no_further_than_exchanges_allow() {
    let mut exchange = DelayExchange::new(RUN);
    let ways = || (micros(100), micros(100));
    let line = running(300e-6, micros(5_000));
    let mut now = at(0);
    for _ in 0..100 {
        now = exchanges(&mut exchange, &line, now, 1, ways);
        let (_, delay, uncertainty) = delay_us(&exchange, now, &line);
        let error = ahead_us(&line, now) - delay;
        assert!(error.abs() < 250.0, "{error}");
        assert!(error.abs() <= uncertainty, "{error}, {uncertainty}");
    }
    let run_away = ahead_us(&line, now) - ahead_us(&line, at(0));
    assert!(run_away < -1_500.0, "{run_away}");
}

#[test]
fn a_line_that_begins_anew_with_another_drift_is_bound_by_the_exchanges_before_it() {
    let mut exchange = DelayExchange::new(RUN);
    let ways = || (micros(100), micros(100));
    let runs_away = running(300e-6, micros(5_000));
    let now = exchanges(&mut exchange, &runs_away, at(0), 100, ways);
    // It is unknown where the line was that the delay was measured against, and it jumps by a millisecond and a half.
    let found = FarLine {
        drift_steps: 1,
        ..line(micros(5_000))
    };
    let jump = ahead_us(&found, now) - ahead_us(&runs_away, now);
    assert!(jump > 1_500.0, "{jump}");
    let _ = exchange.follow(&found);
    let (state, delay, uncertainty) = delay_us(&exchange, now, &found);
    let error = ahead_us(&found, now) - delay;
    assert_eq!(state, DelayState::Measured);
    assert!(error.abs() < 250.0, "{error}");
    assert!(error.abs() <= uncertainty, "{error}, {uncertainty}");
}

#[test]
fn exchanges_that_contradict_newer_ones_say_nothing_any_more() {
    let mut exchange = DelayExchange::new(RUN);
    let ways = || (micros(100), micros(100));
    let now = exchanges(&mut exchange, &line(micros(1_000)), at(0), 100, ways);
    // The line leapt, unnoticed.
    let leapt = line(micros(4_000));
    let now = exchanges(&mut exchange, &leapt, now, 1, ways);
    let (_, delay, uncertainty) = delay_us(&exchange, now, &leapt);
    assert!((3_900.0..4_100.0).contains(&delay), "{delay}");
    assert!(uncertainty >= 200.0, "{uncertainty}");
}

#[test]
fn another_run_of_the_sender_is_bound_by_nothing_of_the_one_before() {
    let mut exchange = DelayExchange::new(RUN);
    let now = exchanges(&mut exchange, &line(micros(1_000)), at(0), 100, || {
        (micros(100), micros(100))
    });
    let other = FarLine {
        epoch: EPOCH + 1,
        ..line(micros(9_000))
    };
    let _ = exchange.follow(&other);
    let output = exchange.output(now, &other);
    assert_eq!((output.delay, output.uncertainty), (None, None));
}

/// Exchanges with a sender whose clock gains on the requester's as `gained` says, from seconds to seconds.
fn with_sender(
    exchange: &mut DelayExchange,
    line: &FarLine,
    count: usize,
    mut ways: impl FnMut(f64) -> (Span, Span),
    gained: impl Fn(f64) -> f64,
) -> Option<(f64, f64)> {
    let mut now = at(0);
    let mut proven = None;
    for _ in 0..count {
        let _ = exchange.follow(line);
        let Some(number) = exchange.ask(now) else {
            now += micros(1_000);
            continue;
        };
        let seconds = now.since_epoch().as_secs_f64();
        let (there, back) = ways(seconds);
        let (mut response, arrived) = response(number, now, there, back);
        let gained = Span::from_secs_f64(gained(seconds));
        response.received += gained;
        response.responded += gained;
        let _ = exchange.take(&response, arrived, line);
        proven = proven.or(exchange.proven_gain());
    }
    proven
}

#[test]
fn a_line_at_another_rate_than_the_sender_is_proven_wrong_once() {
    for gain in [-700e-6, -100e-6, 100e-6, 700e-6] {
        let mut exchange = DelayExchange::new(RUN);
        let line = line(micros(1_000));
        let (mut late, mut later) = (jitter(20.0, 3), jitter(20.0, 4));
        let ways = |_| (micros(100) + late(), micros(100) + later());
        let proven = with_sender(&mut exchange, &line, 6_000, ways, |time| gain * time);
        let (found, sigma) = proven.expect("proven");
        assert!(
            (found - gain).abs() < 6.0 * sigma,
            "{gain}: {found} ± {sigma}"
        );
        assert!(sigma < 0.05 * gain.abs(), "{gain}: ± {sigma}");
    }
}

#[test]
fn two_seconds_prove_something_of_a_clock_and_less_does_not() {
    let is_proven_within = |cycles| {
        let mut exchange = DelayExchange::new(RUN);
        let ways = |_| (micros(100), micros(100));
        let line = line(micros(1_000));
        with_sender(&mut exchange, &line, cycles, ways, |time| 700e-6 * time).is_some()
    };
    // A cycle of a millisecond each, and one for each of some sixty requests.
    assert!(!is_proven_within(1_850));
    assert!(is_proven_within(2_300));
}

/// Lateness where a third of the messages are as quick as can be, and the others wait in queues.
fn queued(mut late: impl FnMut() -> Span) -> impl FnMut() -> Span {
    let mut number = 0;
    move || {
        number += 1;
        micros(350)
            + if number % 3 == 0 {
                late() / 500
            } else {
                late()
            }
    }
}

#[test]
fn ways_that_lead_through_queues_prove_it_as_well() {
    for gain in [-200e-6, 200e-6] {
        let mut exchange = DelayExchange::new(RUN);
        let line = line(micros(1_000));
        let (mut there, mut back) = (queued(jitter(20_000.0, 3)), queued(jitter(20_000.0, 4)));
        let ways = |_| (there(), back());
        let proven = with_sender(&mut exchange, &line, 9_000, ways, |time| gain * time);
        let (found, sigma) = proven.expect("proven");
        assert!(
            (found - gain).abs() < 2.0 * sigma,
            "{gain}: {found} ± {sigma}"
        );
    }
}

#[test]
fn a_line_whose_rate_nobody_has_tested_is_not_taken_for_sure() {
    let mut exchange = DelayExchange::new(RUN);
    let (mut there, mut back) = (queued(jitter(20_000.0, 5)), queued(jitter(20_000.0, 6)));
    // Its uncertainty is 2 ppm, and its error 150 ppm.
    let line = FarLine {
        rate_sigma: 2e-6,
        ..running(150e-6, micros(1_000))
    };
    let mut now = at(0);
    for _ in 0..60 {
        now = exchanges(&mut exchange, &line, now, 1, || (there(), back()));
        let (_, delay, uncertainty) = delay_us(&exchange, now, &line);
        let error = ahead_us(&line, now) - delay;
        assert!(error.abs() <= uncertainty, "{error}, {uncertainty}");
    }
}

#[test]
fn no_path_proves_anything_of_a_clock() {
    let courses: [fn(f64) -> (f64, f64); 4] = [
        |time| (100.0 + 300.0 * time, 100.0),
        |time| (3_000.0 - 300.0 * time, 100.0),
        |time| (100.0 + 200.0 * time, 2_500.0 - 200.0 * time),
        |time| (if time < 3.0 { 100.0 } else { 5_000.0 }, 100.0),
    ];
    for course in courses {
        let mut exchange = DelayExchange::new(RUN);
        let (mut late, mut later) = (jitter(20.0, 5), jitter(20.0, 6));
        let ways = |time| {
            let (there, back) = course(time);
            let (there, back) = (Span::from_micros_f64(there), Span::from_micros_f64(back));
            (there + late(), back + later())
        };
        let line = line(micros(1_000));
        let proven = with_sender(&mut exchange, &line, 6_000, ways, |_| 0.0);
        assert_eq!(proven, None);
    }
}

#[test]
fn what_a_clock_did_before_a_step_of_its_drift_proves_nothing_of_it_now() {
    let mut exchange = DelayExchange::new(RUN);
    let ways = |_| (micros(100), micros(100));
    let steep = running(200e-6, micros(1_000));
    let gained = |time: f64| 200e-6 * time;
    assert_eq!(
        with_sender(&mut exchange, &steep, 4_000, ways, gained),
        None
    );
    let level = FarLine {
        drift_steps: 1,
        ..line(micros(1_000) + Span::from_secs_f64(gained(4.0)))
    };
    let later = with_sender(&mut exchange, &level, 12_000, ways, |_| gained(4.0));
    assert_eq!(later, None);
}

proptest! {
    #[test]
    fn a_line_at_a_rate_that_is_known_as_badly_as_it_is_is_covered(
        rate in -1e-3..1e-3_f64,
        delay in -5_000..5_000_i64,
        there in 0..3_000_i64,
        back in 0..3_000_i64,
        spread in 0.0..200.0_f64,
        seed in 1..10_000_u64,
        count in 1..140_usize,
    ) {
        let mut exchange = DelayExchange::new(RUN);
        let (mut late, mut later) = (jitter(spread, seed), jitter(spread, seed + 77_777));
        let ways = || (micros(there) + late(), micros(back) + later());
        let line = running(rate, micros(delay));
        let now = exchanges(&mut exchange, &line, at(0), count, ways);
        let (_, estimate, uncertainty) = delay_us(&exchange, now, &line);
        let error = estimate - ahead_us(&line, now);
        prop_assert!(error.abs() <= uncertainty + 0.01, "{error} ± {uncertainty}");
    }
}
