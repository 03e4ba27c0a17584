//! The path of a frame, from the cycle thread to the sample, allocates no memory.

use assert_no_alloc::assert_no_alloc;
use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, CycleTime, Span};
use coaxle_wire::frame::{
    FrameHeader, KeySeal, MAX_AXES, body_capacity, encode_body, frame_capacity, sender_id,
};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{Channel, Intake, Rejection};

#[test]
fn encoding_sealing_and_accepting_do_not_allocate() {
    let name = NodeName::new("press").unwrap();
    let key = name.channel_key(Channel::Axes);
    let ids: Vec<u32> = (0..MAX_AXES as u32).collect();
    let (seal, mut intake) = (KeySeal::new(&key), Intake::new(&key, &name, &ids));
    let axes: Vec<_> = (0..MAX_AXES as u32)
        .map(|axis_id| NcToPlcAxis {
            axis_id,
            ..NcToPlcAxis::default()
        })
        .collect();
    let header = FrameHeader {
        sender: sender_id(&name),
        epoch: u64::MAX,
        index: CycleIndex(1),
        count: 1,
        cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
        present_after: None,
        send_stamp: Some(Span::from_nanos(i64::MIN)),
    };
    let mut body = vec![0; body_capacity(MAX_AXES)];
    let mut payload = Vec::with_capacity(frame_capacity(MAX_AXES));

    let (accepted, refused) = assert_no_alloc(|| {
        let len = encode_body(&header, &axes, &mut body).unwrap();
        seal.seal(&body[..len], header.send_stamp, &mut payload);
        let refused = intake.accept(&payload[..payload.len() - 1]).err();
        let frame = intake.accept(&payload);
        let accepted = frame.map(|frame| frame.axes.iter().flatten().count());
        (accepted, refused)
    });

    assert_eq!(accepted, Ok(MAX_AXES));
    assert_eq!(refused, Some(Rejection::Truncated));
}
