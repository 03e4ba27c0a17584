mod bounds;
mod cause;
mod responses;
mod with_observer;

use super::*;
use crate::instant::Remote;
use crate::observer::FarTime;
use proptest::prelude::*;

const RUN: u64 = 11;
const EPOCH: u64 = 5;
/// The sender's clock shows this at the requester's time 0.
const AHEAD: Span = Span::from_millis(7_000);

fn at(micros: i64) -> Instant<Local> {
    Instant::EPOCH + Span::from_micros(micros)
}

fn micros(micros: i64) -> Span {
    Span::from_micros(micros)
}

/// A line that is `delay` behind a sender whose clock runs like the requester's.
fn line(delay: Span) -> FarLine {
    FarLine {
        epoch: EPOCH,
        synced: true,
        relocks: 0,
        sigma: Seconds::ZERO,
        rate_sigma: 0.0,
        jumped: Seconds::ZERO,
        corrected: Seconds::ZERO,
        taken_back: Seconds::ZERO,
        drift_steps: 0,
        rebases: 0,
        count_zero: Instant::from_nanos(123),
        here: at(0),
        far: FarTime {
            instant: Instant::<Remote>::from_nanos(123) + AHEAD - delay,
            fraction_ns: 0.0,
        },
        rate: 1.0,
    }
}

/// The right response to a request that left at `requested`, and when it arrives.
fn response(
    number: u32,
    requested: Instant<Local>,
    there: Span,
    back: Span,
) -> (TimeResponse, Instant<Local>) {
    let received = requested + there;
    let responded = received + micros(700);
    let response = TimeResponse {
        run: RUN,
        number,
        requested,
        epoch: EPOCH,
        received: AHEAD + received.since_epoch(),
        responded: AHEAD + responded.since_epoch(),
    };
    (response, responded + back)
}

/// Exchanges from `start` on until `count` requests have responses; returns the instant after them.
fn exchanges(
    exchange: &mut DelayExchange,
    line: &FarLine,
    start: Instant<Local>,
    count: usize,
    mut ways: impl FnMut() -> (Span, Span),
) -> Instant<Local> {
    let mut now = start;
    let mut responded = 0;
    while responded < count {
        let _ = exchange.follow(line);
        if let Some(number) = exchange.ask(now) {
            let (there, back) = ways();
            let (response, arrived) = response(number, now, there, back);
            exchange
                .take(&response, arrived, line)
                .expect("a right response");
            responded += 1;
        }
        now += micros(1_000);
    }
    now
}

fn delay_us(
    exchange: &DelayExchange,
    now: Instant<Local>,
    line: &FarLine,
) -> (DelayState, f64, f64) {
    let output = exchange.output(now, line);
    let micros = |seconds: Option<Seconds>| seconds.map_or(f64::NAN, Seconds::as_micros);
    (
        output.state,
        micros(output.delay),
        micros(output.uncertainty),
    )
}

/// Exponential jitter from a generator of the simplest kind.
fn jitter(mean_us: f64, seed: u64) -> impl FnMut() -> Span {
    let mut state = seed.wrapping_mul(2).wrapping_add(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let uniform = ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        Span::from_micros_f64(-mean_us * libm::log(uniform))
    }
}

#[test]
fn equal_ways_give_the_delay_and_half_of_the_round_trip_as_its_uncertainty() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_200));
    assert_eq!(exchange.delay(), None);
    let now = exchanges(&mut exchange, &line, at(0), 1, || {
        (micros(900), micros(900))
    });
    let (state, delay, uncertainty) = delay_us(&exchange, now, &line);
    assert_eq!(state, DelayState::Asking, "one exchange is little");
    assert!((delay - 1_200.0).abs() < 0.01, "{delay}");
    // The rate of the line is not tested yet, and a few milliseconds have passed.
    assert!((900.0..901.0).contains(&uncertainty), "{uncertainty}");
    let now = exchanges(&mut exchange, &line, now, 20, || (micros(900), micros(900)));
    assert_eq!(delay_us(&exchange, now, &line).0, DelayState::Measured);
    assert_eq!(exchange.delay(), Some(micros(1_200)));
}

#[test]
fn what_somebody_states_of_the_ways_shows_at_once_and_never_makes_it_less_sure() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_000));
    let ways = || (micros(700), micros(100));
    let now = exchanges(&mut exchange, &line, at(0), 100, ways);
    let shown = |exchange: &DelayExchange| {
        let (_, delay, uncertainty) = delay_us(exchange, now, &line);
        (delay.round(), uncertainty.round())
    };
    assert_eq!(shown(&exchange), (1_300.0, 400.0));
    let state = |exchange: &mut DelayExchange, longer, within| {
        let (longer, within) = (micros(longer), micros(within));
        exchange.state_asymmetry(Some(Asymmetry { longer, within }));
    };
    state(&mut exchange, -600, 40);
    assert_eq!(shown(&exchange), (1_000.0, 20.0));
    state(&mut exchange, -600, 5_000);
    assert_eq!(shown(&exchange), (1_000.0, 700.0));
    exchange.state_asymmetry(None);
    assert_eq!(shown(&exchange), (1_300.0, 400.0));
}

#[test]
fn a_statement_that_exchanges_deny_makes_nothing_surer() {
    let mut exchange = DelayExchange::new(RUN);
    exchange.state_asymmetry(Some(Asymmetry {
        longer: micros(5_000),
        within: micros(10),
    }));
    let line = line(micros(1_000));
    let now = exchanges(&mut exchange, &line, at(0), 100, || {
        (micros(700), micros(100))
    });
    let (_, delay, uncertainty) = delay_us(&exchange, now, &line);
    // As far as the bounds allow, and wrong by no more than they leave open.
    assert!((1_690.0..1_720.0).contains(&delay), "{delay}");
    assert!(delay - 1_000.0 <= uncertainty, "{delay} ± {uncertainty}");
}

#[test]
fn a_statement_beyond_the_round_trip_is_denied_and_one_within_it_is_not() {
    let line = line(micros(1_000));
    for (longer, within, is_denied) in [
        (7_700, 50, true),
        (-7_700, 50, true),
        (900, 50, true),
        (900, 150, false),
        (600, 50, false),
        (-600, 50, false),
    ] {
        let mut exchange = DelayExchange::new(RUN);
        exchange.state_asymmetry(Some(Asymmetry {
            longer: micros(longer),
            within: micros(within),
        }));
        let now = exchanges(&mut exchange, &line, at(0), 100, || {
            (micros(300), micros(500))
        });
        let output = exchange.output(now, &line);
        assert_eq!(output.is_statement_denied, is_denied, "{longer} ± {within}");
    }
}

#[test]
fn jitter_averages_out() {
    for seed in 1..50 {
        let mut exchange = DelayExchange::new(RUN);
        let (mut there, mut back) = (jitter(20.0, seed), jitter(20.0, seed + 1_000));
        let line = line(micros(1_000));
        let ways = || (micros(1_000) + there(), micros(1_000) + back());
        let now = exchanges(&mut exchange, &line, at(0), 200, ways);
        let (_, delay, uncertainty) = delay_us(&exchange, now, &line);
        assert!((delay - 1_000.0).abs() < 2.0, "{seed}: {delay}");
        assert!((999.9..1_006.0).contains(&uncertainty), "{uncertainty}");
        let sigma = exchange.output(now, &line).jitter.unwrap();
        assert!((0.05..1.0).contains(&sigma.as_micros()), "{sigma:?}");
    }
}

#[test]
fn a_shorter_way_counts_once_many_took_it_and_a_longer_one_once_the_shorter_is_old() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_000));
    let equal = || (micros(500), micros(500));
    let shorter = || (micros(500), micros(300));
    let now = exchanges(&mut exchange, &line, at(0), 100, equal);
    let now = exchanges(&mut exchange, &line, now, 2, shorter);
    assert_eq!(
        delay_us(&exchange, now, &line).1.round(),
        1_000.0,
        "by chance"
    );
    let now = exchanges(&mut exchange, &line, now, 28, shorter);
    assert_eq!(delay_us(&exchange, now, &line).1.round(), 1_100.0);
    let now = exchanges(&mut exchange, &line, now, 50, equal);
    assert_eq!(delay_us(&exchange, now, &line).1.round(), 1_100.0);
    let now = exchanges(&mut exchange, &line, now, 60, equal);
    assert_eq!(
        delay_us(&exchange, now, &line).1.round(),
        1_000.0,
        "after 10 s"
    );
}

#[test]
fn a_jump_of_the_line_is_the_paths_doing_until_exchanges_say_otherwise() {
    let mut exchange = DelayExchange::new(RUN);
    let now = exchanges(&mut exchange, &line(micros(500)), at(0), 100, || {
        (micros(500), micros(500))
    });
    // The path grew by 300 µs, both ways: the line falls by as much.
    let jump = Seconds::from(micros(300));
    let fallen = FarLine {
        jumped: jump,
        ..line(micros(800))
    };
    assert_eq!(exchange.follow(&fallen), Some(jump));
    assert_eq!(exchange.follow(&fallen), None, "told once");
    let (state, delay, uncertainty) = delay_us(&exchange, now, &fallen);
    assert_eq!((state, delay.round()), (DelayState::Measured, 800.0));
    assert_eq!(
        uncertainty.round(),
        800.0,
        "as sure as before, plus the jump"
    );
    let later = exchanges(&mut exchange, &fallen, now, 16, || {
        (micros(800), micros(800))
    });
    assert!(later - now < micros(450_000), "in haste");
    assert_eq!(exchange.delay(), Some(micros(800)));

    // It was the sender's clock that jumped: the path is what it was.
    let jumped = FarLine {
        jumped: jump + jump,
        ..line(micros(800))
    };
    assert_eq!(exchange.follow(&jumped), Some(jump));
    assert_eq!(exchange.delay(), Some(micros(1_100)));
    let _ = exchanges(&mut exchange, &jumped, later, 16, || {
        (micros(800), micros(800))
    });
    assert_eq!(exchange.delay(), Some(micros(800)));
}

#[test]
fn a_jump_of_the_line_makes_nothing_surer() {
    let mut exchange = DelayExchange::new(RUN);
    let before = line(micros(500));
    let now = exchanges(&mut exchange, &before, at(0), 30, || {
        (micros(500), micros(500))
    });
    // As long as a line was tested for a short time only, its rate is doubted, and the longer ago the more.
    let later = now + micros(4_000_000);
    let (_, delay, uncertainty) = delay_us(&exchange, later, &before);
    let fallen = FarLine {
        jumped: Seconds::from(micros(10)),
        ..line(micros(510))
    };
    let _ = exchange.follow(&fallen);
    let (_, jumped, after) = delay_us(&exchange, later, &fallen);
    assert!(
        uncertainty > 1_200.0 && after >= uncertainty,
        "{uncertainty} {after}"
    );
    assert_eq!((jumped - delay).round(), 10.0);
}

#[test]
fn what_was_measured_against_an_unsure_line_is_measured_again_as_the_line_gets_better() {
    let mut exchange = DelayExchange::new(RUN);
    let unsure = |delay| FarLine {
        synced: false,
        ..line(micros(delay))
    };
    let ways = || (micros(1_000), micros(1_000));
    let now = exchanges(&mut exchange, &unsure(1_090), at(0), 20, ways);
    assert_eq!(exchange.delay(), Some(micros(1_090)));
    let _ = exchanges(&mut exchange, &unsure(1_030), now, 1, ways);
    assert_eq!(exchange.delay(), Some(micros(1_030)), "with the next one");
    let _ = exchange.follow(&line(micros(1_000)));
    assert_eq!(exchange.delay(), Some(micros(1_000)), "at once: it is sure");
    let _ = exchange.follow(&line(micros(1_050)));
    assert_eq!(exchange.delay(), Some(micros(1_000)), "never again");
}

#[test]
fn a_lost_line_takes_its_measurements_with_it() {
    let mut exchange = DelayExchange::new(RUN);
    let ways = || (micros(1_000), micros(1_000));
    let now = exchanges(&mut exchange, &line(micros(1_000)), at(0), 40, ways);
    let found_again = FarLine {
        relocks: 1,
        ..line(micros(1_100))
    };
    let _ = exchange.follow(&found_again);
    assert_eq!(delay_us(&exchange, now, &found_again).0, DelayState::Stale);
    let now = exchanges(&mut exchange, &found_again, now, 15, ways);
    assert_eq!(
        exchange.delay(),
        Some(micros(1_000)),
        "held until enough came"
    );
    let _ = exchanges(&mut exchange, &found_again, now, 1, ways);
    assert_eq!(exchange.delay(), Some(micros(1_100)));
}

#[test]
fn a_line_found_again_that_is_not_sure_yet_does_not_throw_the_delay_away() {
    let mut exchange = DelayExchange::new(RUN);
    let ways = || (micros(1_000), micros(1_000));
    let mut now = exchanges(&mut exchange, &line(micros(1_000)), at(0), 40, ways);
    let found_again = |synced, delay| FarLine {
        relocks: 1,
        synced,
        ..line(micros(delay))
    };
    // Moving, as an unsure line does, and then sure with few exchanges.
    for k in 0..10 {
        let unsure = found_again(false, 1_300 - 20 * k);
        now = exchanges(&mut exchange, &unsure, now, 1, ways);
        assert_eq!(exchange.delay(), Some(micros(1_000)), "held, exchange {k}");
    }
    let sure = found_again(true, 1_100);
    let now = exchanges(&mut exchange, &sure, now, 5, ways);
    assert_eq!(exchange.delay(), Some(micros(1_000)), "held until enough");
    let _ = exchanges(&mut exchange, &sure, now, 1, ways);
    assert_eq!(exchange.delay(), Some(micros(1_100)));
}

#[test]
fn correlated_delays_move_the_delay_little_by_little() {
    for seed in 1..20 {
        let mut exchange = DelayExchange::new(RUN);
        let line = line(micros(1_000));
        let (mut there, mut back) = (jitter(20.0, seed), jitter(20.0, seed + 1_000));
        let (mut level, mut levels) = (Span::ZERO, jitter(15.0, seed + 2_000));
        let (mut now, mut before) = (at(0), None);
        for n in 0..300 {
            // Each second the way there has another least one.
            if n % 10 == 0 {
                level = levels();
            }
            let ways = || (micros(1_000) + level + there(), micros(1_000) + back());
            now = exchanges(&mut exchange, &line, now, 1, ways);
            let delay = exchange.delay().unwrap();
            if n > 60 {
                let step = delay - before.unwrap();
                assert!(step.abs() < micros(3), "{seed}: {step:?} at {n}");
            }
            before = Some(delay);
        }
    }
}

#[test]
fn a_line_that_locks_is_wrong_by_its_rate() {
    for (rate, is_used) in [(1.0 - 0.8e-3, true), (1.0 - 1.2e-3, false)] {
        let mut exchange = DelayExchange::new(RUN);
        let line = FarLine {
            rate,
            ..line(micros(1_000))
        };
        let _ = exchange.follow(&line);
        let number = exchange.ask(at(0)).expect("due");
        // Half a second by ways without any length, after which the line is wrong by far more than they are.
        let (mut response, arrived) = response(number, at(0), micros(0), micros(0));
        let held = micros(500_000);
        response.responded += held;
        let taken = exchange.take(&response, arrived + held, &line);
        let expected = is_used.then_some(()).ok_or(Refusal::NegativeRoundTrip);
        assert_eq!(taken, expected, "{rate}");
    }
}

proptest! {
    #[test]
    fn the_uncertainty_covers_any_two_ways(
        delay in -500..5_000_i64,
        there in 0..3_000_i64,
        back in 0..3_000_i64,
        spread in 0.0..200.0_f64,
        seed in 1..10_000_u64,
        count in 1..140_usize,
    ) {
        let mut exchange = DelayExchange::new(RUN);
        let (mut late, mut later) = (jitter(spread, seed), jitter(spread, seed + 77_777));
        let ways = || (micros(there) + late(), micros(back) + later());
        let now = exchanges(&mut exchange, &line(micros(delay)), at(0), count, ways);
        let (_, estimate, uncertainty) = delay_us(&exchange, now, &line(micros(delay)));
        let error = estimate - delay as f64;
        prop_assert!(error.abs() <= uncertainty + 0.01, "{error} ± {uncertainty}");
        let asymmetry = 0.5 * (there - back) as f64;
        prop_assert!((error - asymmetry).abs() <= 8.0 * spread + 0.01);
    }

    #[test]
    fn who_states_how_unequal_the_ways_are_is_as_sure_as_that(
        there in 0..3_000_i64,
        back in 0..3_000_i64,
        wrong in -50..=50_i64,
        spread in 0.0..50.0_f64,
        seed in 1..10_000_u64,
    ) {
        let mut exchange = DelayExchange::new(RUN);
        exchange.state_asymmetry(Some(Asymmetry {
            longer: micros(back - there + wrong),
            within: micros(50),
        }));
        let (mut late, mut later) = (jitter(spread, seed), jitter(spread, seed + 77_777));
        let ways = || (micros(there) + late(), micros(back) + later());
        let line = line(micros(1_000));
        let now = exchanges(&mut exchange, &line, at(0), 100, ways);
        let (_, estimate, uncertainty) = delay_us(&exchange, now, &line);
        let error = estimate - 1_000.0;
        let sigma = exchange.output(now, &line).sigma.expect("known").as_micros();
        prop_assert!(error.abs() <= uncertainty + sigma + 0.01, "{error} ± {uncertainty}");
        prop_assert!(uncertainty <= 25.0 + 4.0 * spread + 0.01, "{uncertainty}");
        let shown = exchange.delay().expect("known").as_micros_f64();
        prop_assert!((shown - estimate).abs() < 0.002, "{shown}: a span has whole nanoseconds");
    }

    #[test]
    fn no_answer_whatever_it_says_does_harm(
        responses in prop::collection::vec(any::<(bool, u8, i64, bool, i64, i64, i64)>(), 1..60),
    ) {
        let mut exchange = DelayExchange::new(RUN);
        let line = line(micros(1_000));
        for (k, (run, number, requested, epoch, received, responded, arrived)) in (0..).zip(responses) {
            let _ = exchange.follow(&line);
            let _ = exchange.ask(at(20_000 * k));
            let response = TimeResponse {
                run: if run { RUN } else { requested as u64 },
                number: u32::from(number),
                requested: Instant::from_nanos(requested),
                epoch: if epoch { EPOCH } else { received as u64 },
                received: Span::from_nanos(received),
                responded: Span::from_nanos(responded),
            };
            let _ = exchange.take(&response, Instant::from_nanos(arrived), &line);
            let output = exchange.output(Instant::from_nanos(arrived), &line);
            let delay = output.delay.map_or(0.0, |delay| delay.0);
            prop_assert!(delay.abs() <= 1.0);
            prop_assert!(output.uncertainty.is_none_or(|u| (0.0..=1.0).contains(&u.0)));
        }
    }
}
