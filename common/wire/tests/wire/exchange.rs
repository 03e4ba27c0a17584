//! Requests and responses: round trip, the time server, and refusals.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use coaxle_clock::cycle::Tick;
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_wire::exchange::{
    MAX_TIME_RESPONSES, ReceivedRequest, TIME_REQUEST_CAPACITY, TIME_RESPONSES_CAPACITY,
    TimeRequest, TimeResponsesHeader, encode_time_request, encode_time_responses,
};
use coaxle_wire::frame::{FORMAT_VERSION, KeySeal, sender_id};
use coaxle_wire::keys::NodeName;
use coaxle_wire::{Channel, Message, Reader, Rejection, TimeServer};
use proptest::prelude::*;

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn seal_of(channel: Channel) -> KeySeal {
    KeySeal::new(&name("press").channel_key(channel))
}

fn requests() -> Reader {
    Reader::time_requests_to(&name("press"))
}

fn responses() -> Reader {
    Reader::time_responses_of(&name("press"), &name("saw"))
}

fn read(reader: &Reader, payload: &[u8]) -> Vec<Message<'static>> {
    let mut messages = Vec::new();
    let mut reader = reader.clone();
    reader.read(payload, |message| messages.push(message.split().0));
    messages
}

fn cycle_time() -> CycleTime {
    CycleTime::new(Span::from_millis(1)).unwrap()
}

fn request_frame(request: &TimeRequest, stamp: Option<Span>) -> Vec<u8> {
    let mut body = [0; TIME_REQUEST_CAPACITY];
    let left = stamp.unwrap_or(Span::ZERO).as_nanos();
    let ideal_start = Instant::from_nanos(request.requested.saturating_sub(left));
    let TimeRequest {
        requester,
        run,
        number,
        ..
    } = *request;
    let length = encode_time_request(requester, run, number, ideal_start, &mut body);
    let mut payload = Vec::new();
    seal_of(Channel::TimeRequests).seal(&body[..length], stamp, &mut payload);
    payload
}

fn responses_frame(
    header: &TimeResponsesHeader,
    replies: &[ReceivedRequest],
    stamp: Option<Span>,
) -> Vec<u8> {
    let mut body = [0; TIME_RESPONSES_CAPACITY];
    let length = encode_time_responses(header, replies, &mut body);
    let mut payload = Vec::new();
    seal_of(Channel::TimeResponses).seal(&body[..length], stamp, &mut payload);
    payload
}

fn header() -> TimeResponsesHeader {
    TimeResponsesHeader {
        sender: sender_id(&name("press")),
        epoch: 9,
        count: 50,
        cycle_time: cycle_time(),
    }
}

fn request(requester: &str, number: u32) -> TimeRequest {
    TimeRequest {
        requester: sender_id(&name(requester)),
        run: 77,
        number,
        requested: -5_000,
    }
}

fn at(micros: i64) -> Instant<Local> {
    Instant::EPOCH + Span::from_micros(micros)
}

fn with_checksum(channel: Channel, content: &[u8]) -> Vec<u8> {
    let key = name("press").channel_key(channel);
    let sum = crc32fast::hash(&[key.as_bytes(), content].concat());
    [content, &sum.to_le_bytes()].concat()
}

#[test]
fn the_capacities_hold_the_longest_frames() {
    let request = TimeRequest {
        requester: u32::MAX,
        run: u64::MAX,
        number: u32::MAX,
        requested: i64::MIN,
    };
    let received = Span::from_nanos(i64::MIN);
    let header = TimeResponsesHeader {
        sender: u32::MAX,
        epoch: u64::MAX,
        count: u64::MAX,
        cycle_time: CycleTime::new(CycleTime::MAX).unwrap(),
    };
    let mut body = [0; TIME_RESPONSES_CAPACITY];
    let replies = [ReceivedRequest { request, received }; MAX_TIME_RESPONSES];
    let length = encode_time_responses(&header, &replies, &mut body);
    // The cycle time's bound of 100 ms leaves a byte unused.
    assert_eq!(length, TIME_RESPONSES_CAPACITY - 1);
    let mut body = [0; TIME_REQUEST_CAPACITY];
    let ideal_start = Instant::from_nanos(i64::MIN);
    let length = encode_time_request(u32::MAX, u64::MAX, u32::MAX, ideal_start, &mut body);
    assert_eq!(length, TIME_REQUEST_CAPACITY);
}

#[test]
fn a_node_answers_in_its_next_cycle_what_had_come_by_then() {
    let start = at(10_000);
    let mut time_server = TimeServer::new(header().sender, 9, start, cycle_time());
    time_server.receive(at(59_700), &request("saw", 1));
    time_server.receive(at(59_900), &request("drill", 2));
    time_server.receive(at(60_500), &request("saw", 3));
    let tick = Tick {
        count: 50,
        ideal_start: at(60_000),
        elapsed: 1,
    };
    time_server.respond(&tick, at(60_040));
    let outgoing = time_server.transmit().expect("responses");
    assert_eq!(outgoing.channel, Channel::TimeResponses);
    assert_eq!(outgoing.ideal_start, tick.ideal_start);
    let mut payload = Vec::new();
    let stamp = Some(Span::from_micros(55));
    seal_of(Channel::TimeResponses).seal(outgoing.body, stamp, &mut payload);
    let expected = TimeResponse {
        run: 77,
        number: 1,
        requested: Instant::from_nanos(-5_000),
        epoch: 9,
        received: Span::from_micros(49_700),
        responded: Span::from_micros(50_055),
    };
    assert_eq!(
        read(&responses(), &payload),
        [Message::TimeResponse(expected)]
    );
    assert!(time_server.transmit().is_none(), "once");

    let tick = Tick {
        count: 51,
        ideal_start: at(61_000),
        elapsed: 1,
    };
    time_server.respond(&tick, at(61_000));
    assert!(time_server.transmit().is_some(), "the third request");
    time_server.respond(&tick, at(62_000));
    assert!(time_server.transmit().is_none(), "nothing more");
    assert_eq!(time_server.counters().answered, 3);
}

#[test]
fn a_flood_of_requests_is_cut_off() {
    let mut time_server = TimeServer::new(1, 9, at(0), cycle_time());
    for number in 0..100 {
        time_server.receive(at(0), &request("saw", number));
    }
    let tick = Tick {
        count: 1,
        ideal_start: at(1_000),
        elapsed: 1,
    };
    time_server.respond(&tick, at(1_000));
    let counters = time_server.counters();
    let most = MAX_TIME_RESPONSES as u64;
    assert_eq!((counters.answered, counters.dropped), (most, 100 - most));
}

#[test]
fn without_a_stamp_neither_is_of_use() {
    let payload = request_frame(&request("saw", 1), None);
    let malformed = [Message::Rejected(Rejection::Malformed)];
    assert_eq!(read(&requests(), &payload), malformed);
    let payload = responses_frame(&header(), &[], None);
    assert_eq!(read(&responses(), &payload), malformed);
}

#[test]
fn what_does_not_belong_here_is_refused() {
    let stamp = Some(Span::ZERO);
    let good = responses_frame(&header(), &[], stamp);
    assert_eq!(read(&responses(), &good), []);
    let reason = |reader: &Reader, payload: &[u8]| match read(reader, payload)[..] {
        [Message::Rejected(reason)] => reason,
        ref other => panic!("{other:?}"),
    };
    let mut foreign = header();
    foreign.sender += 1;
    let foreign = responses_frame(&foreign, &[ReceivedRequest::default()], stamp);
    assert_eq!(reason(&responses(), &foreign), Rejection::ForeignSender);
    assert_eq!(reason(&requests(), &good), Rejection::WrongChecksum);
    assert_eq!(reason(&requests(), &[]), Rejection::Truncated);
    assert_eq!(reason(&requests(), &[2]), Rejection::WrongVersion);
    for (reader, whole) in [
        (requests(), request_frame(&request("saw", 1), stamp)),
        (
            responses(),
            responses_frame(&header(), &[ReceivedRequest::default()], stamp),
        ),
    ] {
        for length in 0..whole.len() {
            assert_eq!(reason(&reader, &whole[..length]), Rejection::Truncated);
        }
        for place in 1..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 0x40;
            let reason = reason(&reader, &damaged);
            let damage = [Rejection::WrongChecksum, Rejection::Truncated];
            assert!(damage.contains(&reason), "{reason:?} at {place}");
        }
    }
    let content = &good[..good.len() - 4];
    let longer = with_checksum(Channel::TimeResponses, &[content, &[0]].concat());
    assert_eq!(reason(&responses(), &longer), Rejection::TrailingBytes);
    // 17 responses claimed: the fields before are version, sender, epoch, count, cycle time.
    let place = content.len() - 3;
    let mut many = content.to_vec();
    assert_eq!(many[place], 0, "the number of responses");
    many[place] = 17;
    let many = with_checksum(Channel::TimeResponses, &many);
    assert_eq!(reason(&responses(), &many), Rejection::Malformed);
}

proptest! {
    #[test]
    fn what_goes_in_comes_out(
        requested in prop::collection::vec(any::<(bool, u64, u32, i64, i64)>(), 0..=MAX_TIME_RESPONSES),
        epoch in any::<u64>(),
        count in 0..1_000_000_000_u64,
        stamp in -1_000_000_000..1_000_000_000_i64,
    ) {
        let stamp = Span::from_nanos(stamp);
        let replies: Vec<_> = requested
            .iter()
            .map(|&(mine, run, number, requested, received)| ReceivedRequest {
                request: TimeRequest {
                    requester: sender_id(&name(if mine { "saw" } else { "drill" })),
                    run,
                    number,
                    requested,
                },
                received: Span::from_nanos(received),
            })
            .collect();
        let header = TimeResponsesHeader { epoch, count, ..header() };
        let payload = responses_frame(&header, &replies, Some(stamp));
        let expected: Vec<_> = replies
            .iter()
            .filter(|reply| reply.request.requester == sender_id(&name("saw")))
            .map(|reply| Message::TimeResponse(TimeResponse {
                run: reply.request.run,
                number: reply.request.number,
                requested: Instant::from_nanos(reply.request.requested),
                epoch,
                received: reply.received,
                responded: cycle_time().span() * count as i64 + stamp,
            }))
            .collect();
        prop_assert_eq!(read(&responses(), &payload), expected);
        for reply in &replies {
            let mut request = reply.request;
            request.requested = request.requested.clamp(i64::MIN / 2, i64::MAX / 2);
            let payload = request_frame(&request, Some(stamp));
            prop_assert_eq!(read(&requests(), &payload), [Message::TimeRequest(request)]);
        }
    }

    #[test]
    fn random_bytes_never_panic(content in prop::collection::vec(any::<u8>(), 0..300)) {
        for (reader, channel) in [
            (requests(), Channel::TimeRequests),
            (responses(), Channel::TimeResponses),
        ] {
            let refused =
                |payload: &[u8]| matches!(read(&reader, payload)[..], [Message::Rejected(_)]);
            prop_assert!(refused(&content));
            // Under a right check sum they may even mean something.
            let content = [&[FORMAT_VERSION][..], &content].concat();
            let _ = refused(&with_checksum(channel, &content));
        }
    }
}
