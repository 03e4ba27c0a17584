use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, CycleTime};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{Channel, Intake, Rejection};

use super::*;
use crate::config::parse;

const KEY: &str = "coaxle/belt/axes";

fn belt() -> NodeName {
    NodeName::new("belt").unwrap()
}

/// The frame of cycle `count`: one axis, a millimetre per cycle.
fn frame(count: u64) -> Vec<u8> {
    let axis = NcToPlcAxis {
        axis_id: 1,
        set_position: count as f64,
        set_velocity: 1_000.0,
        ..NcToPlcAxis::default()
    };
    let header = FrameHeader {
        sender: coaxle_wire::frame::sender_id(&belt()),
        epoch: 7,
        index: CycleIndex::of_count(count),
        count,
        cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
        present_after: None,
        send_stamp: None,
    };
    let mut body = vec![0; body_capacity(1)];
    let length = encode_body(&header, &[axis], &mut body).unwrap();
    let mut sealed = Vec::new();
    KeySeal::new(KEY).seal(&body[..length], None, &mut sealed);
    sealed
}

/// Arrivals as read by a receiver of axis 1: epoch, count, cycle time, position and error.
type Read = Result<(u64, u64, i64, f64, u32), Rejection>;

fn read(bytes: &[u8]) -> Read {
    assert_eq!(belt().channel_key(Channel::Axes), KEY);
    let mut intake = Intake::new(KEY, &belt(), &[1]);
    let frame = intake.accept(bytes)?;
    let axis = frame.axes[0].expect("axis 1");
    let FrameHeader {
        epoch,
        count,
        cycle_time,
        ..
    } = frame.header;
    let nanos = cycle_time.span().as_nanos();
    Ok((epoch, count, nanos, axis.set.position, axis.error_code))
}

/// Arrivals from ten frames, a millisecond apart.
fn arrivals(config: &str) -> Vec<Read> {
    let config = parse("test", config).unwrap();
    let mut tampering = Tampering::new(&config, 5, KEY).expect("something is done");
    let mut arrived = Vec::new();
    for count in 0..10 {
        let since_start = Span::from_millis(count as i64);
        tampering.pass(since_start, &frame(count), |bytes| {
            arrived.push(read(bytes))
        });
    }
    arrived
}

const fn genuine(count: u64) -> Read {
    Ok((7, count, 1_000_000, count as f64, 0))
}

#[test]
fn a_link_that_does_nothing_is_none() {
    let config = parse("test", "loss = 0.5\nlatency-us = 200").unwrap();
    assert!(Tampering::new(&config, 5, KEY).is_none());
}

#[test]
fn one_message_is_forged_after_the_genuine_one() {
    let forged = |what: &str| {
        let arrived = arrivals(&format!("forgeries = [{{ at-s = 0.0035, what = {what} }}]"));
        // Ten genuine ones, and the forged one.
        assert_eq!(arrived.len(), 11, "{what}");
        for (place, count) in (0..5).zip(0..).chain((6..11).zip(5..)) {
            assert_eq!(arrived[place], genuine(count), "{what}");
        }
        arrived[5]
    };
    assert!(forged("'noise'").is_err());
    assert_eq!(forged("'first-again'"), genuine(0));
    let other_run = forged("'other-run'").unwrap();
    assert!(other_run.0 != 7 && other_run.1 == 4, "{other_run:?}");
    assert_eq!(forged("'other-node'"), Err(Rejection::ForeignSender));
    assert_eq!(forged("'other-key'"), Err(Rejection::WrongChecksum));
    assert_eq!(forged("'other-version'"), Err(Rejection::WrongVersion));
    assert_eq!(forged("'other-axes'"), Err(Rejection::AxisMissing));
    assert_eq!(forged("'not-finite'"), Err(Rejection::Implausible));
    let cycle_time = forged("{ cycle-time-us = 2000 }");
    assert_eq!(cycle_time, Ok((7, 4, 2_000_000, 4.0, 0)));
    let ahead = forged("{ count-ahead = 1e12 }");
    assert_eq!(ahead, Ok((7, 1_000_000_000_004, 1_000_000, 4.0, 0)));
    let behind = forged("{ count-ahead = -2 }");
    assert_eq!(behind, Ok((7, 2, 1_000_000, 4.0, 0)));
    let position = forged("{ position-ahead = 500.0 }");
    assert_eq!(position, Ok((7, 5, 1_000_000, 504.0, 0)));
    let error = forged("{ axis-error = 0x4655 }");
    assert_eq!(error, Ok((7, 4, 1_000_000, 4.0, 0x4655)));
}

#[test]
fn forgeries_last_and_repeat_and_replace() {
    let arrived =
        arrivals("forgeries = [{ at-s = 0.002, for-s = 0.003, what = 'other-axes', times = 4 }]");
    // The frames of 2, 3 and 4 ms.
    assert_eq!(arrived.len(), 10 + 3 * 4);
    let arrived = arrivals(
        "forgeries = [{ at-s = 0.002, for-s = 0.003, what = 'other-axes', instead = true }]",
    );
    let refused = |read: &&Read| **read == Err(Rejection::AxisMissing);
    assert_eq!(arrived.len(), 10);
    assert_eq!(arrived.iter().filter(refused).count(), 3);
}

#[test]
fn what_is_damaged_is_refused_and_the_rest_is_as_it_was() {
    let config = parse("test", "corruption = 0.3\nfaults-until-s = 5").unwrap();
    let mut tampering = Tampering::new(&config, 5, KEY).expect("something is done");
    let (mut refused, mut late) = (0, 0);
    for count in 0..10_000 {
        let since_start = Span::from_millis(count as i64);
        tampering.pass(since_start, &frame(count), |bytes| match read(bytes) {
            Ok(read) => assert_eq!(Ok(read), genuine(count)),
            Err(_) if count >= 5_000 => late += 1,
            Err(_) => refused += 1,
        });
    }
    // 0.3 · 5000 = 1500, with a deviation of 32.
    assert!((1_400..1_600).contains(&refused), "{refused}");
    assert_eq!(late, 0);
}

#[test]
fn of_other_messages_only_noise_and_repetitions_are_forged() {
    let config = parse(
        "test",
        "forgeries = [{ at-s = 0, what = 'noise' }, { at-s = 0, what = 'other-run' }]",
    );
    let mut tampering = Tampering::new(&config.unwrap(), 5, KEY).expect("something is done");
    let mut arrived = Vec::new();
    tampering.pass(Span::ZERO, b"no frame", |bytes| {
        arrived.push(bytes.to_vec())
    });
    assert_eq!(arrived.len(), 2);
    assert_eq!(arrived[0], b"no frame");
    // As many bytes as the message.
    assert_eq!(arrived[1].len(), 8);
}
