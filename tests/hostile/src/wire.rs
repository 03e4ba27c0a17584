//! Input from the network, message by message, as a node's subscriptions read it.

use coaxle_axis::motion_plan::MOST_PIECES;
use coaxle_clock::{CycleTime, Instant, Seconds, Span};
use coaxle_node::frame::sender_id;
use coaxle_node::keys::NodeName;
use coaxle_node::{
    Channel, Intake, KeptMessage, Message, PlanIntake, PlannedPiece, Reader, ReportIntake,
    TimeServer,
};

use crate::Outcome;

/// The publishing node.
pub(crate) fn far() -> NodeName {
    NodeName::new("conveyor").expect("a valid name")
}

/// The subscribing node.
pub(crate) fn near() -> NodeName {
    NodeName::new("saw").expect("a valid name")
}

/// The axes that are followed.
pub(crate) const FOLLOWED: [u32; 3] = [1, 2, 7];

/// A frame of axes.
pub(crate) fn frame(data: &[u8]) -> Outcome {
    let key = far().channel_key(Channel::Axes);
    let intake = Intake::new(&key, &far(), &FOLLOWED);
    read(intake.into(), &key, data)
}

/// A message of plans.
pub(crate) fn plans(data: &[u8]) -> Outcome {
    let key = far().channel_key(Channel::Plans);
    read(PlanIntake::new(&far(), &FOLLOWED).into(), &key, data)
}

/// A message of reports of a follower.
pub(crate) fn reports(data: &[u8]) -> Outcome {
    let key = near().channel_key(Channel::Followers);
    read(ReportIntake::new(&near(), &far()).into(), &key, data)
}

/// A time request, up to the response.
pub(crate) fn time_request(data: &[u8]) -> Outcome {
    let key = near().channel_key(Channel::TimeRequests);
    read(Reader::time_requests_to(&near()), &key, data)
}

/// A frame of time responses.
pub(crate) fn time_response(data: &[u8]) -> Outcome {
    let key = far().channel_key(Channel::TimeResponses);
    read(Reader::time_responses_of(&far(), &near()), &key, data)
}

/// Reads the bytes as they are, and once more with a correct check sum, which exposes the fields behind it.
fn read(mut reader: Reader, key: &str, data: &[u8]) -> Outcome {
    let _ = read_one(&mut reader, data);
    read_one(&mut reader, &with_checksum(key, data))
}

fn read_one(reader: &mut Reader, data: &[u8]) -> Outcome {
    let mut outcome = Ok(());
    reader.read(data, |message| {
        // Messages in the simulation are kept in recycled buffers, which must not mix.
        let mut kept = KeptMessage::new(message);
        assert_eq!(kept.get(), *message);
        kept.replace(&Message::Rejected(coaxle_node::Rejection::Truncated));
        match message {
            Message::Frame(frame) => {
                let good = frame.axes.iter().flatten();
                assert!(
                    good.clone().count() > 0,
                    "a frame without an axis was taken"
                );
                assert!(good.clone().all(|axis| axis.set.position.is_finite()));
            }
            Message::TimeRequest(request) => respond(request),
            Message::PlannedPiece(planned) => assert_plausible(planned),
            Message::PlanRefused(fault) => outcome = Err(fault.name().to_owned()),
            Message::FollowerReport(report) => {
                let state = &report.state;
                assert!(state.in_sync <= state.slaves && state.in_error <= state.slaves);
                assert!(state.distance >= 0.0 && state.limits.velocity() > 0.0);
            }
            Message::TimeResponse(_) | Message::BeaconRequest(_) | Message::BeaconResponse(_) => {}
            Message::Rejected(reason) => outcome = Err(reason.to_string()),
        }
    });
    outcome
}

/// A piece that is handed out can be evaluated anywhere in it.
fn assert_plausible(planned: &PlannedPiece) {
    let PlannedPiece {
        piece, number, of, ..
    } = planned;
    assert!(
        number < of
            && usize::from(*of) <= MOST_PIECES
            && usize::from(planned.axis) < FOLLOWED.len()
    );
    assert!(piece.duration > Span::ZERO && piece.end() > piece.start);
    let end = piece.at(piece.end(), Seconds::ZERO);
    assert!(end.position.is_finite() && end.velocity.is_finite() && end.acceleration.is_finite());
}

fn respond(request: &coaxle_node::TimeRequest) {
    let cycle_time = CycleTime::new(Span::from_millis(1)).expect("a cycle time");
    let mut server = TimeServer::new(sender_id(&near()), 1, Instant::EPOCH, cycle_time);
    server.receive(Instant::EPOCH, request);
    let tick = coaxle_clock::cycle::Tick {
        count: 0,
        ideal_start: Instant::EPOCH,
        elapsed: 1,
    };
    server.respond(&tick, Instant::EPOCH);
    assert!(
        server.transmit().is_some(),
        "a request that was taken has a response"
    );
}

/// The bytes with their last four replaced by the check sum of those before, under `key`.
pub(crate) fn with_checksum(key: &str, data: &[u8]) -> Vec<u8> {
    let content = data
        .split_last_chunk::<4>()
        .map_or(data, |(content, _)| content);
    let mut hasher = crc32fast::Hasher::new();
    // The key is part of the sum, so that a frame under another key is refused.
    hasher.update(key.as_bytes());
    hasher.update(content);
    let mut bytes = content.to_vec();
    bytes.extend_from_slice(&hasher.finalize().to_le_bytes());
    bytes
}
