//! Synthetic arrivals with known truth.

use super::*;

const CYCLE: i64 = 1_000_000;
const FIRST: u64 = 70_000;

/// Delays of 20 µs and more, some of them much more.
fn delay(k: i64) -> i64 {
    20_000 + (k * 7_919 % 997) * 50 + if k % 100 == 3 { 2_000_000 } else { 0 }
}

fn stamp(k: i64) -> i64 {
    15_000 + k % 13 * 1_000
}

/// The receiver's clock at a moment of the sender's time since the first message's cycle.
fn local(sender_ns: i64, drift: f64) -> i64 {
    5_000_000_123 + sender_ns + (sender_ns as f64 * drift).round() as i64
}

fn raw(drift: f64, messages: i64) -> Raw {
    let message = |k: i64| ArrivalRow {
        at_ns: 0,
        cycle: 0,
        cycle_start_ns: 0,
        epoch: 1,
        count: FIRST + k as u64,
        cycle_time_ns: CYCLE,
        arrival_ns: local(k * CYCLE + stamp(k) + delay(k), drift),
        send_stamp_ns: Some(stamp(k)),
        far: 1,
    };
    let exchange = |k: i64| {
        let t1 = k * CYCLE;
        ExchangeRow {
            at_ns: 0,
            cycle: 0,
            cycle_start_ns: 0,
            epoch: 1,
            number: k as u32,
            t1_ns: local(t1, drift),
            t2_ns: FIRST as i64 * CYCLE + t1 + 30_000,
            t3_ns: FIRST as i64 * CYCLE + t1 + 400_000,
            t4_ns: local(t1 + 440_000, drift),
            far: 1,
        }
    };
    Raw {
        messages: (0..messages).map(message).collect(),
        exchanges: (0..messages / 100).map(exchange).collect(),
        other_runs: 0,
    }
}

#[test]
fn with_one_clock_delays_are_true_to_the_nanosecond() {
    let raw = raw(0.0, 2_000);
    let scale = TimeScale::of_one_clock(local(0, 0.0));
    let recording = convert(&raw, &scale);
    assert_eq!(recording.left_out, 0);
    for (k, message) in (0..).zip(&recording.messages) {
        let expected = RecordedMessage {
            count: k as i32,
            send_stamp_ns: stamp(k) as i32,
            delay_ns: delay(k) as i32,
        };
        assert_eq!(*message, expected);
    }
    for (k, exchange) in (0..).zip(&recording.exchanges) {
        let t1 = k * CYCLE;
        let expected = RecordedExchange {
            t1_ns: t1,
            t2_ns: t1 + 30_000,
            t3_ns: t1 + 400_000,
            t4_ns: t1 + 440_000,
        };
        assert_eq!(*exchange, expected);
    }
    assert_eq!(recording.exchanges.len(), 20);
}

#[test]
fn a_drift_is_fitted_and_what_deviates_from_the_line_stays() {
    for drift in [-300e-6, 2e-6, 55e-6] {
        let raw = raw(drift, 20_000);
        let scale = TimeScale::fitted(&raw);
        assert!((scale.drift - drift).abs() < 1e-9, "{}", scale.drift_ppm());
        let recording = convert(&raw, &scale);
        assert_eq!(recording.left_out, 0);
        let least = recording.messages.iter().map(|m| m.delay_ns).min();
        assert!((0..=1).contains(&least.unwrap()), "{least:?}");
        for (k, message) in (0..).zip(&recording.messages) {
            let off = i64::from(message.delay_ns) - (delay(k) - 20_000);
            assert!(off.abs() < 30, "{off} ns at {drift}");
        }
        let last = recording.exchanges.last().unwrap();
        let (there, back) = (last.t2_ns - last.t1_ns, last.t4_ns - last.t3_ns);
        // An excess in one direction is missing in the other.
        assert!((there + back - 70_000).abs() <= 30, "{there} {back}");
        // 30 µs on the way, and the least delay of 20 µs that the fit takes for 0.
        assert!((there - 50_000).abs() < 60, "{there}");
    }
}

#[test]
fn one_message_is_a_line_of_its_own() {
    let raw = raw(0.0, 1);
    let recording = convert(&raw, &TimeScale::fitted(&raw));
    assert_eq!(recording.messages.len(), 1);
    assert_eq!(recording.messages[0].delay_ns, 0);
}

#[test]
fn senders_without_stamps_are_taken_as_they_are() {
    let mut raw = raw(0.0, 100);
    for row in &mut raw.messages {
        row.send_stamp_ns = None;
    }
    let recording = convert(&raw, &TimeScale::of_one_clock(local(0, 0.0)));
    for (k, message) in (0..).zip(&recording.messages) {
        assert_eq!(message.send_stamp_ns, 0);
        assert_eq!(i64::from(message.delay_ns), delay(k) + stamp(k));
    }
}

#[test]
fn what_the_file_cannot_hold_is_left_out_and_counted() {
    let mut raw = raw(0.0, 100);
    // Both beyond an i32 of ns: 3 s late, and a count of −70 001 that arrives 70 s after its cycle.
    raw.messages[50].arrival_ns += 3_000_000_000;
    raw.messages[60].count = u64::MAX;
    let recording = convert(&raw, &TimeScale::of_one_clock(local(0, 0.0)));
    assert_eq!(recording.messages.len(), 98);
    assert_eq!(recording.left_out, 2);
}

#[test]
fn counts_begin_with_the_message_that_was_sent_first() {
    let mut raw = raw(0.0, 100);
    raw.messages.swap(0, 1);
    let recording = convert(&raw, &TimeScale::of_one_clock(local(0, 0.0)));
    let of_message = |message: &RecordedMessage| (message.count, i64::from(message.delay_ns));
    let messages: Vec<_> = recording.messages.iter().map(of_message).collect();
    let expected = [(1, delay(1)), (0, delay(0)), (2, delay(2))];
    assert_eq!(messages[..3], expected, "in the order of arrival");
}
