//! Round trip of frames, and the sizes of their buffers.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use coaxle_axis::{AxisState, CoupleState, ImageLayout, NcToPlcAxis, StateWord};
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_wire::frame::{
    EncodeError, FrameHeader, MAX_AXES, body_capacity, decode, encode_body, frame_capacity, seal,
    sender_id,
};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{PresentAfter, Rejection};
use proptest::prelude::*;

const KEY: &str = "coaxle/press/axes";

fn frame(header: &FrameHeader, axes: &[NcToPlcAxis]) -> Vec<u8> {
    let mut body = vec![0; body_capacity(axes.len())];
    let len = encode_body(header, axes, &mut body).unwrap();
    let mut payload = Vec::new();
    seal(KEY, &body[..len], header.send_stamp, &mut payload);
    payload
}

/// Returns the header and axis with the longest encoding of every number.
fn longest() -> (FrameHeader, NcToPlcAxis) {
    let header = FrameHeader {
        sender: u32::MAX,
        epoch: u64::MAX,
        index: CycleIndex(u16::MAX),
        count: u64::MAX,
        cycle_time: CycleTime::new(CycleTime::MAX).unwrap(),
        present_after: PresentAfter::new(PresentAfter::LONGEST),
        send_stamp: Some(Span::from_nanos(i64::MIN)),
    };
    let mut axis = NcToPlcAxis::from_image(ImageLayout::AxisRef, &[0xff; 128]);
    axis.modulo_actual_turns = i32::MIN;
    axis.modulo_set_turns = i32::MIN;
    (header, axis)
}

#[test]
fn the_capacities_hold_the_longest_frame() {
    let (header, axis) = longest();
    let axes = [axis; MAX_AXES];
    let payload = frame(&header, &axes);
    // Of the capacity, only the cycle time's bound of 100 ms leaves a byte unused.
    assert_eq!(payload.len(), frame_capacity(MAX_AXES) - 1);
}

#[test]
fn a_body_that_cannot_be_written_says_what_came_and_what_fits() {
    let (header, axis) = longest();
    let error = encode_body(&header, &[axis; MAX_AXES + 1], &mut [0; 64]).unwrap_err();
    assert_eq!(error.to_string(), "received 129 axes, expected at most 128");
    let len = encode_body(&header, &[axis], &mut vec![0; body_capacity(1)]).unwrap();
    for received in 0..len {
        let error = encode_body(&header, &[axis], &mut vec![0; received]).unwrap_err();
        let expected = body_capacity(1);
        assert_eq!(error, EncodeError::BufferTooSmall { received, expected });
    }
}

/// A network without presentation stays as it was, byte for byte.
#[test]
fn only_a_frame_with_a_presentation_delay_has_another_version() {
    let (presented, axis) = longest();
    let header = FrameHeader {
        present_after: None,
        ..presented
    };
    let (before, after) = (frame(&header, &[axis]), frame(&presented, &[axis]));
    assert_eq!((before[0], after[0]), (1, 2));
    // Version, sender, epoch, index, count and cycle time; then five bytes for 4 000 000 000.
    let place = 1 + 5 + 10 + 3 + 10 + 4;
    let end = before.len() - 4;
    assert_eq!(after[place..place + 5], [0x80, 0xD0, 0xAC, 0xF3, 0x0E]);
    assert_eq!(before[1..place], after[1..place]);
    assert_eq!(before[place..end], after[place + 5..after.len() - 4]);
    assert_eq!(decode(KEY, &after, |_| {}), Ok(presented));
}

#[test]
fn a_presentation_delay_is_at_most_four_seconds_and_none_may_be_said() {
    let (header, axis) = longest();
    let (whole, place) = (frame(&header, &[axis]), 33);
    let with = |delay: &[u8]| {
        let body = [&whole[..place], delay, &whole[place + 5..whole.len() - 15]].concat();
        let mut sealed = Vec::new();
        seal(KEY, &body, header.send_stamp, &mut sealed);
        decode(KEY, &sealed, |_| {}).map(|header| header.present_after)
    };
    assert_eq!(with(&[0]), Ok(None));
    assert_eq!(with(&[1]), Ok(PresentAfter::new(Span::from_nanos(1))));
    let too_long = [
        [0x81, 0xD0, 0xAC, 0xF3, 0x0E],
        [0xFF, 0xFF, 0xFF, 0xFF, 0x0F],
    ];
    for delay in too_long {
        assert_eq!(with(&delay), Err(Rejection::PresentAfterOutOfRange));
    }
    let of_33_bits = [0x80, 0x80, 0x80, 0x80, 0x10];
    assert_eq!(with(&of_33_bits), Err(Rejection::Malformed));
}

#[test]
fn sealing_replaces_what_was_in_the_buffer() {
    let (header, axis) = longest();
    let fresh = frame(&header, &[axis]);
    let stamp_and_checksum = 11 + 4;
    let body = &fresh[..fresh.len() - stamp_and_checksum];
    let mut reused = vec![0xaa; 3_000];
    seal(KEY, body, header.send_stamp, &mut reused);
    assert_eq!(reused, fresh);
}

#[test]
fn the_sender_id_is_the_check_sum_of_the_name() {
    // The check value that the catalogue of CRCs gives for CRC-32.
    let name = NodeName::new("123456789").unwrap();
    assert_eq!(sender_id(&name), 0xCBF4_3926);
}

#[test]
fn axes_come_in_the_order_they_were_given() {
    let (header, _) = longest();
    let axes: Vec<_> = (0..MAX_AXES as u32)
        .map(|axis_id| NcToPlcAxis {
            axis_id,
            ..NcToPlcAxis::default()
        })
        .collect();
    let mut seen = Vec::new();
    decode(KEY, &frame(&header, &axes), |axis| seen.push(*axis)).unwrap();
    assert_eq!(seen, axes);
}

#[test]
fn bits_and_codes_without_a_name_survive() {
    let (header, _) = longest();
    let axis = NcToPlcAxis {
        state_word: StateWord::from_bits_retain((1 << 15) | (1 << 18)),
        axis_state: AxisState::Other(77),
        couple_state: CoupleState::Other(u32::MAX),
        ..NcToPlcAxis::default()
    };
    decode(KEY, &frame(&header, &[axis]), |seen| {
        assert_eq!(*seen, axis)
    })
    .unwrap();
}

fn any_axis() -> impl Strategy<Value = NcToPlcAxis> {
    any::<[[u8; 32]; 4]>().prop_map(|quarters| {
        let image = std::array::from_fn(|i| quarters[i / 32][i % 32]);
        NcToPlcAxis::from_image(ImageLayout::AxisRef, &image)
    })
}

prop_compose! {
    fn any_header()(
        (sender, epoch, index, count) in any::<(u32, u64, u16, u64)>(),
        cycle_nanos in 100_000..=100_000_000_i64,
        stamp in any::<Option<i64>>(),
        present_after in 0..=4_000_000_000_i64,
        is_presented in any::<bool>(),
    ) -> FrameHeader {
        FrameHeader {
            sender,
            epoch,
            index: CycleIndex(index),
            count,
            cycle_time: CycleTime::new(Span::from_nanos(cycle_nanos)).unwrap(),
            present_after: PresentAfter::new(Span::from_nanos(present_after)).filter(|_| is_presented),
            send_stamp: stamp.map(Span::from_nanos),
        }
    }
}

proptest! {
    #[test]
    fn what_goes_in_comes_out(
        header in any_header(),
        axes in proptest::collection::vec(any_axis(), 0..6),
    ) {
        let mut images = Vec::new();
        let payload = frame(&header, &axes);
        let read = decode(KEY, &payload, |axis| images.push(axis.to_image(ImageLayout::AxisRef)));
        prop_assert_eq!(read, Ok(header));
        // Images, since a NaN is not equal to itself but its bits are.
        let sent: Vec<_> = axes.iter().map(|a| a.to_image(ImageLayout::AxisRef)).collect();
        prop_assert_eq!(images, sent);
    }
}
