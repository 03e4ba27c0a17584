//! Scans come back from their bytes, and other bytes are named.

use super::*;
use crate::beacon::{BeaconBefore, BeaconRequest, BeaconResponse, Stamps};
use crate::channel::Channel;
use crate::message::PlannedPiece;
use coaxle_axis::motion_plan::MotionPiece;
use coaxle_slave::CircleState;
use proptest::prelude::*;

fn scan() -> NodeScan {
    let header = FrameHeader {
        sender: 7,
        epoch: u64::MAX,
        index: CycleIndex(65_535),
        count: 1 << 40,
        cycle_time: CycleTime::new(Span::from_micros(250)).unwrap(),
        present_after: None,
        send_stamp: Some(Span::from_nanos(-3)),
    };
    let axis = AxisSample {
        set: Kinematics {
            position: 0.1 + 0.2,
            velocity: -0.0,
            acceleration: 5e-324,
        },
        state_word: StateWord::from_bits_retain(0xffff_ffff),
        error_code: 0x4b52,
    };
    let axes: &[_] = &[Some(axis), None];
    let response = TimeResponse {
        run: 1,
        number: u32::MAX,
        requested: Instant::from_nanos(-1),
        epoch: 2,
        received: Span::from_nanos(5),
        responded: Span::from_nanos(6),
    };
    let request = TimeRequest {
        requester: 1,
        run: 2,
        number: 3,
        requested: i64::MIN,
    };
    let messages = [
        Message::Frame(Frame { header, axes }),
        Message::Frame(Frame {
            header: FrameHeader {
                present_after: PresentAfter::new(Span::from_millis(8)),
                ..header
            },
            axes,
        }),
        Message::TimeResponse(response),
        Message::TimeRequest(request),
        Message::Rejected(Rejection::Implausible),
        Message::PlannedPiece(PlannedPiece {
            epoch: u64::MAX,
            count: 8,
            axis: 3,
            number: 1,
            of: 2,
            promised_until: Span::from_secs(-1),
            piece: MotionPiece {
                jerk: -0.0,
                ..MotionPiece::default()
            },
        }),
        Message::PlanRefused(PlanFault::Gap),
    ];
    let received = messages
        .iter()
        .enumerate()
        .map(|(n, message)| ReceivedMessage {
            at: Instant::from_nanos(n as i64 - 1),
            subscription: n,
            message: KeptMessage::new(message),
        });
    let order = r#"{"version":1,"slave":"saw","command":{"home":{"position":3}}}"#;
    NodeScan {
        received: received.collect(),
        circles: Vec::new(),
        orders: vec![CommandOrder::from_json(order.as_bytes()).unwrap()],
        now: Instant::from_nanos(12),
    }
}

#[test]
fn what_a_node_was_told_comes_back_to_the_last_bit() {
    let scan = scan();
    let back = NodeScan::from_bytes(&scan.to_bytes()).unwrap();
    assert_eq!(back, scan);
    let bits = |scan: &NodeScan| match scan.received[0].message.get() {
        Message::Frame(frame) => frame.axes[0].unwrap().set.velocity.to_bits(),
        other => panic!("{other:?}"),
    };
    assert_eq!(bits(&back), bits(&scan), "minus nothing, too");
    let quiet = NodeScan::default();
    assert_eq!(NodeScan::from_bytes(&quiet.to_bytes()), Ok(quiet));
}

fn of_one_message(message: &Message<'_>) -> NodeScan {
    NodeScan {
        received: vec![ReceivedMessage {
            at: Instant::EPOCH,
            subscription: 0,
            message: KeptMessage::new(message),
        }],
        ..NodeScan::default()
    }
}

/// Bytes as they have been written since there are beacons: recordings have them.
#[test]
fn beacons_without_a_common_time_stay_byte_for_byte() {
    let before = |number| BeaconBefore {
        number,
        left_ns: -1,
    };
    let request = BeaconRequest {
        requester: 5,
        run: 7,
        number: 3,
        requested: 42,
        stamps: Stamps::Kernel,
        before: Some(before(2)),
        ..BeaconRequest::default()
    };
    let response = BeaconResponse {
        epoch: 9,
        request,
        received: Span::from_nanos(50),
        responded: Span::from_nanos(60),
        stamps: Stamps::Application,
        ..BeaconResponse::default()
    };
    // One message, at 0, of subscription 0; its kind; its fields; no order, at 0.
    let request_bytes = [5, 7, 3, 84, 1, 1, 2, 1];
    let of_request = [&[1, 1, 0, 0, 4][..], &request_bytes, &[0, 0]].concat();
    let of_response = [
        &[1, 1, 0, 0, 5, 9][..],
        &request_bytes,
        &[100, 120, 0, 0, 0, 0],
    ]
    .concat();
    for (message, bytes) in [
        (Message::BeaconRequest(request), of_request),
        (Message::BeaconResponse(response), of_response),
    ] {
        let scan = of_one_message(&message);
        assert_eq!(scan.to_bytes(), bytes, "{message:?}");
        assert_eq!(NodeScan::from_bytes(&bytes), Ok(scan));
    }
}

#[test]
fn readings_of_a_common_time_come_back() {
    let stamp = |at_ns| CommonStamp {
        at_ns,
        time_ns: 1_800_000_000_000_000_000,
        bound_ns: 250,
        grandmaster: u64::MAX,
    };
    for (requester, responder) in [
        (None, None),
        (Some(stamp(-4)), None),
        (Some(stamp(1)), Some(stamp(2))),
    ] {
        let request = BeaconRequest {
            takes_common_time: true,
            common: requester,
            ..BeaconRequest::default()
        };
        let response = BeaconResponse {
            request,
            common: responder,
            ..BeaconResponse::default()
        };
        for message in [
            Message::BeaconRequest(request),
            Message::BeaconResponse(response),
        ] {
            let scan = of_one_message(&message);
            assert_eq!(NodeScan::from_bytes(&scan.to_bytes()), Ok(scan));
        }
    }
}

#[test]
fn every_reason_has_a_number_in_a_scan() {
    for reason in Rejection::ALL {
        assert!(REJECTIONS.contains(&reason), "{reason:?}");
    }
}

#[test]
fn circles_come_back_and_without_them_older_tools_read_the_scan() {
    assert_eq!(scan().to_bytes()[0], 1);
    let change = |channel, state| CircleChange {
        channel,
        id: 7,
        state,
    };
    let scan = NodeScan {
        circles: vec![
            change(Channel::Slaves, CircleState::Open),
            change(Channel::FarAxes, CircleState::Closed),
            change(Channel::Slaves, CircleState::None),
        ],
        ..scan()
    };
    let bytes = scan.to_bytes();
    assert_eq!(NodeScan::from_bytes(&bytes), Ok(scan));
    // The last byte is a state.
    let wrong = [&bytes[..bytes.len() - 1], &[3]].concat();
    assert_eq!(NodeScan::from_bytes(&wrong), Err(InvalidScan::Malformed));
}

#[test]
fn other_bytes_are_named() {
    let bytes = scan().to_bytes();
    let of = |bytes: &[u8]| NodeScan::from_bytes(bytes).unwrap_err().to_string();
    assert_eq!(of(&[]), "received version None, expected 1 or 2");
    assert_eq!(of(&[3]), "received version Some(3), expected 1 or 2");
    let malformed = "received bytes that are no scan of their version";
    assert_eq!(of(&[2]), malformed);
    assert_eq!(of(&bytes[..bytes.len() - 1]), malformed);
    assert_eq!(of(&[bytes.as_slice(), &[0]].concat()), malformed);
}

proptest! {
    #[test]
    fn whatever_comes_is_read_without_a_panic(bytes: Vec<u8>, at in 0..400_usize, with: u8) {
        let _ = NodeScan::from_bytes(&bytes);
        let mut bytes = scan().to_bytes();
        let at = at % bytes.len();
        bytes[at] = with;
        let _ = NodeScan::from_bytes(&bytes);
    }
}
