//! Responses that count, and times without any.

use super::*;

#[test]
fn another_run_of_the_sender_forgets_all() {
    let mut exchange = DelayExchange::new(RUN);
    let first = line(micros(1_000));
    let ways = || (micros(400), micros(400));
    let now = exchanges(&mut exchange, &first, at(0), 30, ways);
    let second = FarLine { epoch: 6, ..first };
    assert_eq!(exchange.follow(&second), None);
    assert_eq!(exchange.delay(), None);
    let number = exchange.ask(now).expect("asks at once");
    let (mut late, arrived) = response(number, now, micros(400), micros(400));
    assert_eq!(
        exchange.take(&late, arrived, &second),
        Err(Refusal::OtherEpoch)
    );
    late.epoch = 6;
    assert_eq!(exchange.take(&late, arrived, &second), Ok(()));
}

#[test]
fn responses_that_cannot_be_right_are_counted_and_not_used() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_000));
    let now = exchanges(&mut exchange, &line, at(0), 30, || {
        (micros(400), micros(400))
    });
    let before = (exchange.delay(), exchange.exchanges);
    let mut refused = 0;
    let mut refuse = |spoil: fn(&mut TimeResponse, &mut Instant<Local>), expected| {
        let requested = now + micros(200_000 * (refused + 1));
        let number = exchange.ask(requested).expect("due");
        let (mut response, mut arrived) = response(number, requested, micros(400), micros(400));
        spoil(&mut response, &mut arrived);
        assert_eq!(exchange.take(&response, arrived, &line), Err(expected));
        refused += 1;
        assert_eq!(exchange.refused, refused as u64);
        assert_eq!((exchange.delay(), exchange.exchanges), before);
    };
    refuse(|a, _| a.run += 1, Refusal::OtherRun);
    refuse(|a, _| a.epoch += 1, Refusal::OtherEpoch);
    refuse(|a, _| a.number += 1, Refusal::NotAsked);
    refuse(|a, _| a.number -= 20, Refusal::NotAsked);
    refuse(|a, _| a.number = u32::MAX, Refusal::NotAsked);
    refuse(|a, _| a.received += Span::MAX, Refusal::Implausible);
    refuse(
        |a, _| a.responded = a.received - micros(1),
        Refusal::Implausible,
    );
    refuse(
        |_, arrived| *arrived += Span::from_secs(2),
        Refusal::Implausible,
    );
    refuse(
        |_, arrived| *arrived += micros(1_200_000),
        Refusal::Implausible,
    );
    refuse(|a, _| a.requested += micros(90_000), Refusal::Implausible);
    refuse(
        |a, _| {
            a.received += micros(1_200_000);
            a.responded += micros(1_200_000);
        },
        Refusal::Implausible,
    );
    refuse(
        |a, _| a.responded += micros(900),
        Refusal::NegativeRoundTrip,
    );
}

#[test]
fn a_response_that_takes_most_of_a_second_is_used() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_000));
    let slow = || (micros(400), micros(800_000));
    let _ = exchanges(&mut exchange, &line, at(0), 1, slow);
    assert_eq!(exchange.exchanges, 1);
}

#[test]
fn an_answer_counts_once() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_000));
    assert_eq!(exchange.ask(at(0)), None, "no line yet");
    let _ = exchange.follow(&line);
    let number = exchange.ask(at(0)).expect("due");
    let (response, arrived) = response(number, at(0), micros(400), micros(400));
    assert_eq!(exchange.take(&response, arrived, &line), Ok(()));
    assert_eq!(
        exchange.take(&response, arrived, &line),
        Err(Refusal::NotAsked)
    );
}

#[test]
fn who_never_answers_is_asked_at_leisure() {
    let mut exchange = DelayExchange::new(RUN);
    let _ = exchange.follow(&line(micros(1_000)));
    let requested = |from: i64, exchange: &mut DelayExchange| {
        (from..from + 1_000)
            .filter(|k| exchange.ask(at(1_000 * k)).is_some())
            .count()
    };
    assert_eq!(requested(0, &mut exchange), 50);
    let _ = requested(1_000, &mut exchange);
    let _ = requested(2_000, &mut exchange);
    assert_eq!(requested(3_000, &mut exchange), 10);
    assert_eq!(
        delay_us(&exchange, at(4_000_000), &line(micros(1_000))).0,
        DelayState::Asking
    );
}

#[test]
fn silence_makes_a_measurement_stale_and_keeps_it() {
    let mut exchange = DelayExchange::new(RUN);
    let line = line(micros(1_000));
    let ways = || (micros(400), micros(400));
    let now = exchanges(&mut exchange, &line, at(0), 30, ways);
    let soon = now + micros(2_500_000);
    assert_eq!(delay_us(&exchange, soon, &line).0, DelayState::Measured);
    let late = now + micros(3_500_000);
    assert_eq!(delay_us(&exchange, late, &line).0, DelayState::Stale);
    assert_eq!(exchange.delay(), Some(micros(1_000)));
    let age = exchange.output(late, &line).age.expect("known");
    assert!((micros(3_490_000)..micros(3_600_000)).contains(&age));
}
