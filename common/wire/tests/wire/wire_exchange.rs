//! `docs/WIRE.md` against the code: its worked request and response.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use crate::document::{assert_consistent, example_dump};
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_wire::exchange::{
    ReceivedRequest, TIME_REQUEST_CAPACITY, TIME_RESPONSES_CAPACITY, TimeRequest,
    TimeResponsesHeader, encode_time_request, encode_time_responses,
};
use coaxle_wire::frame::{KeySeal, sender_id};
use coaxle_wire::keys::NodeName;

const REQUEST: &str = "## Worked time request";
const RESPONSE: &str = "## Worked time response";

fn id(name: &str) -> u32 {
    sender_id(&NodeName::new(name).unwrap())
}

fn request() -> TimeRequest {
    TimeRequest {
        requester: id("saw"),
        run: 0x0FED_CBA9_8765_4321,
        number: 300,
        requested: 12_345_061_500,
    }
}

#[test]
fn the_tables_cover_the_dumps_and_the_rules_give_their_values() {
    assert_consistent(REQUEST);
    assert_consistent(RESPONSE);
}

#[test]
fn the_crate_reads_the_documented_values() {
    let seal = KeySeal::new("coaxle/press/time-requests");
    let read = seal.open_time_request(&example_dump(REQUEST));
    assert_eq!(read, Ok(request()));

    let seal = KeySeal::new("coaxle/press/time-responses");
    let mut responses = Vec::new();
    seal.open_time_responses(
        &example_dump(RESPONSE),
        id("press"),
        id("saw"),
        |response| {
            responses.push(*response);
        },
    )
    .unwrap();
    let response = TimeResponse {
        run: request().run,
        number: 300,
        requested: Instant::from_nanos(12_345_061_500),
        epoch: 0x0123_4567_89ab_cdef,
        received: Span::from_nanos(140_001_337_250),
        responded: Span::from_nanos(140_002_071_000),
    };
    assert_eq!(responses, [response]);
}

#[test]
fn the_crate_writes_the_documented_bytes() {
    let mut payload = Vec::new();
    let mut body = [0; TIME_REQUEST_CAPACITY];
    let ideal_start = Instant::from_nanos(12_345_000_000);
    let TimeRequest {
        requester,
        run,
        number,
        ..
    } = request();
    let length = encode_time_request(requester, run, number, ideal_start, &mut body);
    let stamp = Some(Span::from_nanos(61_500));
    KeySeal::new("coaxle/press/time-requests").seal(&body[..length], stamp, &mut payload);
    assert_eq!(payload, example_dump(REQUEST));

    let header = TimeResponsesHeader {
        sender: id("press"),
        epoch: 0x0123_4567_89ab_cdef,
        count: 70_001,
        cycle_time: CycleTime::new(Span::from_millis(2)).unwrap(),
    };
    let reply = ReceivedRequest {
        request: request(),
        received: Span::from_nanos(140_001_337_250),
    };
    let mut body = [0; TIME_RESPONSES_CAPACITY];
    let length = encode_time_responses(&header, &[reply], &mut body);
    let stamp = Some(Span::from_nanos(71_000));
    KeySeal::new("coaxle/press/time-responses").seal(&body[..length], stamp, &mut payload);
    assert_eq!(payload, example_dump(RESPONSE));
}
