use super::*;

const CYCLE: i64 = 1_000_000;

fn at(nanos: i64) -> Instant<Local> {
    Instant::from_nanos(nanos)
}

fn clock(delay: DelaySource) -> FarClock {
    let cycle_time = CycleTime::new(Span::from_nanos(CYCLE)).unwrap();
    FarClock::new(cycle_time, ObserverParameters::default(), delay, 5).unwrap()
}

/// The sender's clock is 300 ns behind per second of the own one, and a message takes 200 µs.
fn arrival(count: i64) -> Instant<Local> {
    at(count * CYCLE + count * CYCLE / 1_000_000 * 300 / 1_000 + 200_000)
}

fn run(clock: &mut FarClock, counts: core::ops::Range<i64>) -> FarClockOutput {
    let mut newest = None;
    for count in counts {
        clock.message(9, count as u64, arrival(count), None);
        let now = at(count * CYCLE + 500_000);
        newest = Some(*clock.cycle(now, |_, _| {}));
        if let Some(number) = clock.request(now) {
            // 100 µs there, 200 µs back; the far clock is read to the nearest.
            let response = TimeResponse {
                run: 5,
                number,
                requested: now,
                epoch: 9,
                received: Span::from_nanos(count * CYCLE + 600_000),
                responded: Span::from_nanos(count * CYCLE + 650_000),
            };
            clock.response(now + Span::from_micros(350), &response);
        }
    }
    newest.expect("a cycle")
}

#[test]
fn nothing_is_known_before_the_first_message() {
    let mut clock = clock(DelaySource::Measured);
    let output = clock.cycle(at(0), |_, _| {});
    assert!(!output.is_sure);
    assert_eq!(clock.far_time_at(at(0)), None);
    assert_eq!(clock.correction(0), None);
    assert_eq!(clock.request(at(0)), None);
}

#[test]
fn it_is_sure_within_seconds_stays_so_in_a_gap_and_ends_when_lost() {
    let mut clock = clock(DelaySource::Off);
    assert!(run(&mut clock, 0..3_000).is_sure);
    let correction = clock.correction(2_999).unwrap();
    assert!((correction.0 - 300e-6).abs() < 2e-6, "{correction:?}");
    let mut now = at(3_000 * CYCLE);
    let gap = clock.cycle(now + Span::from_millis(100), |_, _| {});
    assert_eq!(gap.observer.state, ObserverState::Holdover);
    assert!(gap.is_sure && clock.correction(2_999).is_some());
    now += Span::from_secs(3_600);
    let lost = clock.cycle(now, |_, _| {});
    assert!(!lost.is_sure);
    assert_eq!(clock.correction(2_999), None);
}

#[test]
fn the_delay_is_measured_or_configured_and_can_be_changed() {
    let mut clock = clock(DelaySource::Measured);
    let output = run(&mut clock, 0..5_000);
    assert_eq!(output.delay.state, DelayState::Measured);
    let delay = output.delay.delay.unwrap().as_micros();
    assert!(
        (delay - 150.0).abs() < 5.0,
        "half of the round trip: {delay}"
    );
    let measured = clock.far_time_at(at(5_000 * CYCLE)).unwrap();
    assert!(measured.uncertainty.0 >= 140e-6, "{measured:?}");

    clock.set_delay(DelaySource::Fixed(Span::from_micros(200)));
    let output = run(&mut clock, 5_000..8_000);
    assert_eq!(output.delay.state, DelayState::Fixed);
    let now = at(8_000 * CYCLE);
    let reading = clock.far_time_at(now).unwrap();
    let error = reading.time.since(Instant::from_nanos(8_000 * CYCLE)).0;
    assert!(error.abs() < 5e-6, "{error}");
    // The unknown part of the delay is not in it any more.
    assert!(
        reading.uncertainty.0 < 0.5 * measured.uncertainty.0,
        "{reading:?}"
    );
    assert_eq!(clock.request(now), None, "nobody is asked any more");
}

#[test]
fn later_instants_are_less_certain() {
    let mut clock = clock(DelaySource::Off);
    let _ = run(&mut clock, 0..3_000);
    let reading = |at| clock.far_time_at(at).unwrap();
    let (soon, late) = (reading(at(3_000 * CYCLE)), reading(at(60_000 * CYCLE)));
    assert!(late.uncertainty.0 > soon.uncertainty.0);
    let passed = late.time.since(soon.time.instant).0;
    assert!((passed - 57.0).abs() < 1e-3, "{passed}");
}

#[test]
fn responses_that_find_no_room_are_counted() {
    let mut clock = clock(DelaySource::Measured);
    let _ = run(&mut clock, 0..100);
    let response = TimeResponse {
        run: 5,
        number: 0,
        requested: at(0),
        epoch: 9,
        received: Span::ZERO,
        responded: Span::ZERO,
    };
    let before = clock.delay_output(at(0)).refused;
    for _ in 0..RESPONSES + 3 {
        clock.response(at(i64::MAX), &response);
    }
    assert_eq!(clock.delay_output(at(0)).refused, before + 3);
}
