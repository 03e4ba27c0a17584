//! Frames that an intake accepts, and its reason for refusing all others.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_wire::frame::{self, FrameHeader, MAX_AXES, body_capacity, encode_body, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{AxisSample, Channel, Intake, Message, PresentAfter, Rejection};
use proptest::prelude::*;

fn press() -> NodeName {
    NodeName::new("press").unwrap()
}

fn key() -> String {
    press().channel_key(Channel::Axes)
}

/// Follows axis 3 of `press`.
fn intake() -> Intake {
    Intake::new(&key(), &press(), &[3])
}

fn header() -> FrameHeader {
    FrameHeader {
        sender: sender_id(&press()),
        epoch: 0x0123_4567_89ab_cdef,
        index: CycleIndex(4_464),
        count: 70_000,
        cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
        present_after: None,
        send_stamp: Some(Span::from_micros(53)),
    }
}

fn axis(axis_id: u32) -> NcToPlcAxis {
    NcToPlcAxis {
        axis_id,
        set_position: 10.0 + f64::from(axis_id),
        set_velocity: 500.0,
        ..NcToPlcAxis::default()
    }
}

fn frame_of(header: &FrameHeader, axes: &[NcToPlcAxis]) -> Vec<u8> {
    let mut body = vec![0; body_capacity(axes.len())];
    let len = encode_body(header, axes, &mut body).unwrap();
    let mut payload = Vec::new();
    frame::seal(&key(), &body[..len], header.send_stamp, &mut payload);
    payload
}

/// Returns any content with the check sum that fits it.
fn with_checksum(content: &[u8]) -> Vec<u8> {
    let sum = crc32fast::hash(&[key().as_bytes(), content].concat());
    [content, &sum.to_le_bytes()].concat()
}

fn content_of(payload: &[u8]) -> &[u8] {
    &payload[..payload.len() - 4]
}

fn varint(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
    bytes
}

/// Returns a frame written by hand: no axes in it, but it may claim some.
fn by_hand(cycle_nanos: u64, axes_claimed: u64, stamp: &[u8]) -> Vec<u8> {
    let sender = varint(sender_id(&press()).into());
    let (epoch, index, count) = (varint(9), varint(7), varint(7));
    let (cycle_time, axes) = (varint(cycle_nanos), varint(axes_claimed));
    let fields = [
        &[1],
        &*sender,
        &epoch,
        &index,
        &count,
        &cycle_time,
        &axes,
        stamp,
    ];
    with_checksum(&fields.concat())
}

const NO_STAMP: &[u8] = &[0];
const MILLISECOND: u64 = 1_000_000;

fn refusal(payload: &[u8]) -> Rejection {
    accepted(payload).unwrap_err()
}

/// Returns the header, and the axis 3.
fn accepted(payload: &[u8]) -> Result<(FrameHeader, AxisSample), Rejection> {
    let mut intake = intake();
    let frame = intake.accept(payload)?;
    Ok((frame.header, frame.axes[0].unwrap()))
}

#[test]
fn the_followed_axis_is_taken_from_among_the_others() {
    let payload = frame_of(&header(), &[axis(1), axis(3), axis(2)]);
    let sample = AxisSample::from(&axis(3));
    assert_eq!(accepted(&payload), Ok((header(), sample)));
    let mut intake = intake();
    let Message::Frame(frame) = intake.message(&payload) else {
        panic!("it is good");
    };
    assert_eq!((frame.header, frame.axes), (header(), &[Some(sample)][..]));
}

#[test]
fn of_axes_with_the_same_id_the_first_counts() {
    let mut second = axis(3);
    second.set_position = -1.0;
    let payload = frame_of(&header(), &[axis(3), second]);
    assert_eq!(accepted(&payload).unwrap().1, AxisSample::from(&axis(3)));
}

#[test]
fn every_axis_of_a_full_frame_is_found() {
    let axes: Vec<_> = (0..MAX_AXES as u32).map(axis).collect();
    let payload = frame_of(&header(), &axes);
    // Requested in any order, they come in that order.
    let ids: Vec<_> = (0..MAX_AXES as u32).map(|n| n * 37 % 128).collect();
    let mut intake = Intake::new(&key(), &press(), &ids);
    let frame = intake.accept(&payload).unwrap();
    let expected = ids.iter().map(|id| Some(AxisSample::from(&axis(*id))));
    assert!(frame.axes.iter().copied().eq(expected));
}

#[test]
fn the_index_of_another_maker_may_start_anywhere() {
    let mut header = header();
    header.index = CycleIndex(1);
    let payload = frame_of(&header, &[axis(3)]);
    assert_eq!(accepted(&payload).unwrap().0, header);
}

#[test]
fn a_frame_without_the_axis_is_refused() {
    for axes in [&[][..], &[axis(1), axis(2)]] {
        let payload = frame_of(&header(), axes);
        assert_eq!(refusal(&payload), Rejection::AxisMissing);
        let ids: Vec<_> = axes.iter().map(|axis| axis.axis_id).collect();
        assert_eq!(intake().axis_ids(&payload), ids, "what is there instead");
        assert!(intake().axis_ids(&payload[1..]).is_empty());
    }
}

#[test]
fn another_node_under_the_same_key_is_refused() {
    let mut header = header();
    header.sender = sender_id(&NodeName::new("impostor").unwrap());
    let payload = frame_of(&header, &[axis(3)]);
    assert_eq!(refusal(&payload), Rejection::ForeignSender);
    let message = Message::Rejected(Rejection::ForeignSender);
    assert_eq!(intake().message(&payload), message);
}

#[test]
fn a_frame_that_strayed_from_its_key_is_refused() {
    let payload = frame_of(&header(), &[axis(3)]);
    let slaves = press().channel_key(Channel::Slaves);
    let mut intake = Intake::new(&slaves, &press(), &[3]);
    assert_eq!(intake.accept(&payload), Err(Rejection::WrongChecksum));
}

#[test]
fn another_version_is_named_even_if_nothing_else_can_be_read() {
    let mut payload = frame_of(&header(), &[axis(3)]);
    let known = [frame::FORMAT_VERSION, frame::PRESENTED_VERSION];
    for version in (0..=u8::MAX).filter(|version| !known.contains(version)) {
        payload[0] = version;
        assert_eq!(refusal(&payload), Rejection::WrongVersion);
        assert_eq!(refusal(&[version]), Rejection::WrongVersion);
    }
}

/// Frames of both versions.
fn good_frames() -> [Vec<u8>; 2] {
    let presented = FrameHeader {
        present_after: PresentAfter::new(Span::from_millis(8)),
        ..header()
    };
    [header(), presented].map(|header| frame_of(&header, &[axis(1), axis(3)]))
}

#[test]
fn a_frame_cut_anywhere_is_truncated() {
    for payload in good_frames() {
        for len in 0..payload.len() {
            let reason = refusal(&payload[..len]);
            assert_eq!(reason, Rejection::Truncated, "{len} bytes");
        }
    }
}

#[test]
fn content_that_ends_early_is_truncated_even_under_a_right_check_sum() {
    for payload in good_frames() {
        let content = content_of(&payload);
        for len in 1..content.len() {
            let cut = with_checksum(&content[..len]);
            assert_eq!(refusal(&cut), Rejection::Truncated, "{len} bytes");
        }
    }
}

#[test]
fn no_changed_byte_goes_unnoticed() {
    let payload = frame_of(&header(), &[axis(1), axis(3)]);
    for place in 0..payload.len() {
        for mask in 1..=u8::MAX {
            let mut changed = payload.clone();
            changed[place] ^= mask;
            let reason = refusal(&changed);
            if place == 0 && changed[0] != frame::PRESENTED_VERSION {
                assert_eq!(reason, Rejection::WrongVersion);
            } else {
                let damage = [Rejection::WrongChecksum, Rejection::Truncated];
                assert!(damage.contains(&reason), "{reason:?} at {place}");
            }
        }
    }
}

#[test]
fn a_wrong_check_sum_is_named() {
    let mut payload = frame_of(&header(), &[axis(3)]);
    *payload.last_mut().unwrap() ^= 0x10;
    assert_eq!(refusal(&payload), Rejection::WrongChecksum);
}

#[test]
fn bytes_behind_the_last_field_are_refused() {
    let payload = frame_of(&header(), &[axis(3)]);
    let longer = [content_of(&payload), &[0]].concat();
    assert_eq!(refusal(&with_checksum(&longer)), Rejection::TrailingBytes);
    let appended = [&payload[..], &[0]].concat();
    assert_eq!(refusal(&appended), Rejection::WrongChecksum);
}

#[test]
fn cycle_times_out_of_range_are_refused() {
    for nanos in [0, 99_999, 100_000_001, u32::MAX.into()] {
        let payload = by_hand(nanos, 0, NO_STAMP);
        assert_eq!(refusal(&payload), Rejection::CycleTimeOutOfRange, "{nanos}");
    }
    for nanos in [100_000, MILLISECOND, 100_000_000] {
        // In range: the next thing amiss is that the axis is not there.
        let payload = by_hand(nanos, 0, NO_STAMP);
        assert_eq!(refusal(&payload), Rejection::AxisMissing, "{nanos}");
    }
}

#[test]
fn numbers_and_tags_that_do_not_exist_are_malformed() {
    let cycle_time_of_33_bits = by_hand(1 << 32, 0, NO_STAMP);
    assert_eq!(refusal(&cycle_time_of_33_bits), Rejection::Malformed);
    let neither_some_nor_none = by_hand(MILLISECOND, 0, &[2]);
    assert_eq!(refusal(&neither_some_nor_none), Rejection::Malformed);
    let stamp_of_eleven_bytes = [&[1][..], &[0xff; 10], &[0]].concat();
    let payload = by_hand(MILLISECOND, 0, &stamp_of_eleven_bytes);
    assert_eq!(refusal(&payload), Rejection::Malformed);
}

#[test]
fn more_axes_than_a_frame_holds_are_malformed() {
    assert_eq!(
        refusal(&by_hand(MILLISECOND, 128, NO_STAMP)),
        Rejection::Truncated
    );
    for claimed in [129, u32::MAX.into()] {
        let payload = by_hand(MILLISECOND, claimed, NO_STAMP);
        assert_eq!(refusal(&payload), Rejection::Malformed, "{claimed}");
    }
}

#[test]
fn every_kinematic_value_must_be_plausible() {
    type Field = fn(&mut NcToPlcAxis) -> &mut f64;
    let fields: [Field; 9] = [
        |a| &mut a.actual_position,
        |a| &mut a.modulo_actual_position,
        |a| &mut a.actual_velocity,
        |a| &mut a.following_error,
        |a| &mut a.set_position,
        |a| &mut a.set_velocity,
        |a| &mut a.set_acceleration,
        |a| &mut a.target_position,
        |a| &mut a.modulo_set_position,
    ];
    for (place, field) in fields.into_iter().enumerate() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -2e15] {
            let mut bad = axis(3);
            *field(&mut bad) = value;
            let payload = frame_of(&header(), &[bad]);
            assert_eq!(
                refusal(&payload),
                Rejection::Implausible,
                "{place}: {value}"
            );
        }
    }
}

#[test]
fn another_axis_may_be_broken() {
    let mut broken = axis(1);
    broken.set_position = f64::NAN;
    let payload = frame_of(&header(), &[broken, axis(3)]);
    assert_eq!(accepted(&payload).unwrap().1, AxisSample::from(&axis(3)));
}

#[test]
fn of_several_axes_those_that_are_good_are_taken() {
    let mut broken = axis(1);
    broken.actual_velocity = f64::INFINITY;
    // The second one of that id does not stand in for the first.
    let payload = frame_of(&header(), &[broken, axis(3), axis(1)]);
    let mut intake = Intake::new(&key(), &press(), &[1, 2, 3]);
    let frame = intake.accept(&payload).unwrap();
    assert_eq!(frame.axes, [None, None, Some(AxisSample::from(&axis(3)))]);
    // Nothing of it is left in the next one.
    let payload = frame_of(&header(), &[axis(2)]);
    let frame = intake.accept(&payload).unwrap();
    assert_eq!(frame.axes, [None, Some(AxisSample::from(&axis(2))), None]);
    let payload = frame_of(&header(), &[broken]);
    assert_eq!(intake.accept(&payload), Err(Rejection::Implausible));
}

proptest! {
    #[test]
    fn random_bytes_are_refused(mut payload in proptest::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(intake().accept(&payload).is_err());
        if let Some(first) = payload.first_mut() {
            *first = frame::FORMAT_VERSION;
            prop_assert!(intake().accept(&payload).is_err());
        }
        if let Some(first) = payload.first_mut() {
            *first = frame::PRESENTED_VERSION;
            prop_assert!(intake().accept(&payload).is_err());
        }
    }

    #[test]
    fn random_content_under_a_right_check_sum_never_panics(
        content in proptest::collection::vec(any::<u8>(), 0..400),
    ) {
        for version in [frame::FORMAT_VERSION, frame::PRESENTED_VERSION] {
            let content = [&[version][..], &content].concat();
            prop_assert!(intake().accept(&with_checksum(&content)).is_err());
        }
    }

    #[test]
    fn damage_under_a_right_check_sum_never_panics(
        place in any::<prop::sample::Index>(),
        byte in any::<u8>(),
    ) {
        let payload = frame_of(&header(), &[axis(1), axis(3)]);
        let mut content = content_of(&payload).to_vec();
        let place = place.index(content.len());
        content[place] = byte;
        if let Ok((header, axis)) = accepted(&with_checksum(&content)) {
            prop_assert!(axis.set.position.abs() <= 1e15);
            prop_assert_eq!(header.sender, sender_id(&press()));
        }
    }
}
