//! Beacons of the timing channel: round trip, responder, and refusals.

#![expect(
    clippy::unwrap_used,
    reason = "a test may end where its own data are wrong"
)]

use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_wire::beacon::{
    BEACON_CAPACITY, BeaconBefore, BeaconLabel, BeaconResponseHeader, BeaconSeal, BeaconSecret,
    CommonStamp, Departure, PairKeys, SECRET_LEN, TimingSecret, encode_beacon_request,
    encode_beacon_response,
};
use coaxle_wire::beacon_server::MAX_BEACONS;
use coaxle_wire::frame::sender_id;
use coaxle_wire::keys::NodeName;
use coaxle_wire::{
    BeaconIntake, BeaconRequest, BeaconResponse, BeaconServer, Channel, Message, Reader, Rejection,
    Stamps,
};
use proptest::prelude::*;

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn seal_of(channel: Channel) -> BeaconSeal {
    BeaconSeal::new(&name("press").channel_key(channel))
}

fn requests() -> Reader {
    BeaconIntake::requests_to(&name("press")).into()
}

fn responses() -> Reader {
    BeaconIntake::responses_of(&name("press"), &name("saw")).into()
}

fn read(reader: &Reader, payload: &[u8]) -> Vec<Message<'static>> {
    let mut messages = Vec::new();
    let mut reader = reader.clone();
    reader.read(payload, |message| messages.push(message.split().0));
    messages
}

fn departure(left: i64, before: Option<BeaconBefore>, common: Option<CommonStamp>) -> Departure {
    Departure {
        left: Span::from_nanos(left),
        stamps: Stamps::Kernel,
        before: before.map(|before| (before.number, Span::from_nanos(before.left_ns))),
        common,
    }
}

fn label_of(requester: u32) -> BeaconLabel {
    BeaconLabel {
        requester,
        run: 7,
        number: 1,
    }
}

/// Makes a request sealed for a cycle that ideally began at 0.
fn request_frame(request: &BeaconRequest) -> Vec<u8> {
    let BeaconRequest {
        requester,
        run,
        number,
        requested,
        before,
        takes_common_time,
        common,
        ..
    } = *request;
    let mut body = [0; BEACON_CAPACITY];
    let label = BeaconLabel {
        requester,
        run,
        number,
    };
    let length = encode_beacon_request(&label, takes_common_time, Instant::EPOCH, &mut body);
    let mut payload = Vec::new();
    let departure = departure(requested, before, common);
    seal_of(Channel::BeaconRequests).seal(&body[..length], &departure, &mut payload);
    payload
}

/// Makes a response sealed for cycle 0.
fn response_frame(sender: &str, response: &BeaconResponse) -> Vec<u8> {
    let header = BeaconResponseHeader {
        sender: sender_id(&name(sender)),
        epoch: response.epoch,
        count: 0,
        cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
    };
    let mut body = [0; BEACON_CAPACITY];
    let received = response.received;
    let length = encode_beacon_response(&header, &response.request, received, &mut body);
    let mut payload = Vec::new();
    let departure = departure(
        response.responded.as_nanos(),
        response.before,
        response.common,
    );
    seal_of(Channel::BeaconResponses).seal(&body[..length], &departure, &mut payload);
    payload
}

fn request(number: u32) -> BeaconRequest {
    BeaconRequest {
        requester: sender_id(&name("saw")),
        run: 7,
        number,
        requested: 1_000_000,
        stamps: Stamps::Kernel,
        before: None,
        takes_common_time: false,
        common: None,
    }
}

#[test]
fn each_beacon_is_answered_by_one_of_its_own() {
    let cycle_time = CycleTime::new(Span::from_millis(2)).unwrap();
    let start: Instant<Local> = Instant::from_nanos(5_000);
    let mut server = BeaconServer::new(sender_id(&name("press")), 9, start, cycle_time);
    let at = |micros: i64| start + Span::from_micros(micros);
    let other = BeaconRequest {
        requester: 1,
        ..request(3)
    };
    server.receive(at(100), &request(1));
    server.receive(at(200), &other);
    // The newer one of the same node counts.
    server.receive(at(300), &request(2));
    server.receive(
        at(9_000),
        &BeaconRequest {
            requester: 2,
            ..request(4)
        },
    );
    let tick = Tick {
        count: 2,
        ideal_start: at(4_000),
        elapsed: 1,
    };
    server.respond(&tick, at(4_010));
    let mut answered = Vec::new();
    while let Some(outgoing) = server.transmit() {
        assert_eq!(outgoing.channel, Channel::BeaconResponses);
        assert_eq!(outgoing.ideal_start, at(4_000));
        answered.push((
            BeaconLabel::of(outgoing.channel, outgoing.body).unwrap(),
            outgoing.body.to_vec(),
        ));
    }
    let numbers: Vec<_> = answered.iter().map(|(label, _)| label.number).collect();
    assert_eq!(numbers, [2, 3], "what has not arrived yet waits");
    let mut payload = Vec::new();
    let seal = seal_of(Channel::BeaconResponses);
    seal.seal(&answered[0].1, &departure(12_000, None, None), &mut payload);
    let expected = BeaconResponse {
        epoch: 9,
        request: request(2),
        received: Span::from_micros(300),
        responded: Span::from_micros(4_012),
        stamps: Stamps::Kernel,
        before: None,
        common: None,
    };
    assert_eq!(
        read(&responses(), &payload),
        [Message::BeaconResponse(expected)]
    );
    seal.seal(&answered[1].1, &departure(0, None, None), &mut payload);
    assert_eq!(read(&responses(), &payload), [], "for another node");
    let counters = server.counters();
    assert_eq!((counters.answered, counters.dropped), (2, 1));
    for requester in 0..2 * MAX_BEACONS as u32 {
        server.receive(
            at(0),
            &BeaconRequest {
                requester,
                ..request(1)
            },
        );
    }
    assert!(server.counters().dropped > MAX_BEACONS as u64);
}

#[test]
fn what_is_no_beacon_is_refused_with_a_reason() {
    let good = request_frame(&request(1));
    let refused = |payload: &[u8]| match read(&requests(), payload)[..] {
        [Message::Rejected(reason)] => reason,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(refused(&[]), Rejection::Truncated);
    assert_eq!(refused(&[3, 0, 0, 0, 0]), Rejection::WrongVersion);
    assert_eq!(refused(&good[..good.len() - 6]), Rejection::Truncated);
    let mut flipped = good.clone();
    flipped[3] ^= 4;
    assert_eq!(refused(&flipped), Rejection::WrongChecksum);
    // Responses do not pass for requests, nor those of another node for its own.
    let answer = BeaconResponse {
        epoch: 1,
        request: request(1),
        stamps: Stamps::Kernel,
        ..BeaconResponse::default()
    };
    assert_eq!(
        refused(&response_frame("press", &answer)),
        Rejection::WrongChecksum
    );
    let foreign = response_frame("other", &answer);
    assert_eq!(
        read(&responses(), &foreign),
        [Message::Rejected(Rejection::ForeignSender)]
    );
    assert_eq!(BeaconLabel::of(Channel::Axes, &good), None);
    assert_eq!(BeaconLabel::of(Channel::BeaconRequests, &[1, 2]), None);
}

fn authenticated(digit: char) -> (BeaconSeal, Reader) {
    let text: String = [digit; 2 * SECRET_LEN].iter().collect();
    let secret = BeaconSecret::from_hex(&text).unwrap();
    let reader = BeaconIntake::requests_to(&name("press")).authenticated(&secret);
    let seal = seal_of(Channel::BeaconRequests).authenticated(&secret);
    (seal, reader.into())
}

#[test]
fn only_who_knows_the_secret_is_heard() {
    let (seal, reader) = authenticated('a');
    let (other_seal, other_reader) = authenticated('b');
    let mut body = [0; BEACON_CAPACITY];
    let length = encode_beacon_request(&label_of(5), false, Instant::EPOCH, &mut body);
    let departure = departure(0, None, None);
    let mut sealed = Vec::new();
    seal.seal(&body[..length], &departure, &mut sealed);
    assert!(matches!(
        read(&reader, &sealed)[..],
        [Message::BeaconRequest(_)]
    ));
    let wrong = [Message::Rejected(Rejection::WrongChecksum)];
    assert_eq!(read(&other_reader, &sealed), wrong);
    assert_ne!(read(&requests(), &sealed), read(&reader, &sealed));
    let mut other = Vec::new();
    other_seal.seal(&body[..length], &departure, &mut other);
    assert_eq!(read(&reader, &other), wrong);
    // Not authenticated at all.
    let plain = request_frame(&request(1));
    assert_eq!(read(&reader, &plain), wrong);
    // Every byte is covered, and all of the tag.
    for place in 1..sealed.len() {
        let mut changed = sealed.clone();
        changed[place] ^= 1;
        assert_eq!(read(&reader, &changed), wrong, "{place}");
    }
    for length in 0..sealed.len() {
        assert!(matches!(
            read(&reader, &sealed[..length])[..],
            [Message::Rejected(_)]
        ));
    }
    // A beacon under one key is none under another.
    let secret = BeaconSecret::from_hex(&"a".repeat(2 * SECRET_LEN)).unwrap();
    let elsewhere = BeaconIntake::requests_to(&name("saw")).authenticated(&secret);
    assert_eq!(read(&elsewhere.into(), &sealed), wrong);
}

/// The keys of a node with these others, from the secret of the network.
fn pair_keys(own: &str, others: &[&str]) -> PairKeys {
    let others: Vec<_> = others.iter().map(|other| name(other)).collect();
    PairKeys::derived(&TimingSecret::new([5; SECRET_LEN]), &name(own), &others)
}

/// A request of one node to `press`, sealed with the key of a pair.
fn request_by(requester: &str, keys: &PairKeys, pair: &str) -> Vec<u8> {
    let mut body = [0; BEACON_CAPACITY];
    let id = sender_id(&name(requester));
    let length = encode_beacon_request(&label_of(id), false, Instant::EPOCH, &mut body);
    let seal = seal_of(Channel::BeaconRequests);
    let seal = seal.authenticated(keys.of(&name(pair)).expect("a key"));
    let mut sealed = Vec::new();
    assert!(seal.seal(&body[..length], &departure(0, None, None), &mut sealed));
    sealed
}

#[test]
fn a_member_cannot_forge_the_beacons_of_another_pair() {
    let (press, saw, drill) = (
        pair_keys("press", &["saw", "drill"]),
        pair_keys("saw", &["press", "drill"]),
        pair_keys("drill", &["press", "saw"]),
    );
    let reader: Reader = BeaconIntake::requests_to(&name("press"))
        .authenticated_by(&press)
        .into();
    let refused = [Message::Rejected(Rejection::WrongChecksum)];
    let good = request_by("saw", &saw, "press");
    assert!(matches!(
        read(&reader, &good)[..],
        [Message::BeaconRequest(_)]
    ));
    // The drill has keys of its own pairs, and neither is that of the saw and the press.
    assert_eq!(read(&reader, &request_by("saw", &drill, "press")), refused);
    assert_eq!(read(&reader, &request_by("saw", &drill, "saw")), refused);
    // A recorded beacon is none for another node, and a stranger has no pair.
    let elsewhere: Reader = BeaconIntake::requests_to(&name("drill"))
        .authenticated_by(&drill)
        .into();
    assert_eq!(read(&elsewhere, &good), refused);
    assert_eq!(read(&reader, &request_by("mill", &drill, "press")), refused);

    // Responses: sealed for their requester, with the key of its pair.
    let response = |to: &str| {
        let request = BeaconRequest {
            requester: sender_id(&name(to)),
            ..request(1)
        };
        let header = BeaconResponseHeader {
            sender: sender_id(&name("press")),
            epoch: 1,
            count: 0,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
        };
        let mut body = [0; BEACON_CAPACITY];
        let length = encode_beacon_response(&header, &request, Span::ZERO, &mut body);
        let seal = seal_of(Channel::BeaconResponses).authenticated_by(&press);
        let mut sealed = Vec::new();
        let is_sealed = seal.seal(&body[..length], &departure(0, None, None), &mut sealed);
        (is_sealed, sealed)
    };
    let responses = |own: &str, keys: &PairKeys| -> Reader {
        let intake = BeaconIntake::responses_of(&name("press"), &name(own));
        let key = keys.of(&name("press")).expect("a key");
        intake.authenticated(key).into()
    };
    let (_, to_saw) = response("saw");
    assert!(matches!(
        read(&responses("saw", &saw), &to_saw)[..],
        [Message::BeaconResponse(_)]
    ));
    assert_eq!(read(&responses("drill", &drill), &to_saw), refused);
    assert_eq!(response("mill"), (false, Vec::new()));

    // Revoked: the key is withdrawn, except one that was made after that.
    press.withdraw("saw", 0);
    assert!(matches!(
        read(&reader, &good)[..],
        [Message::BeaconRequest(_)]
    ));
    press.withdraw("saw", 1);
    assert_eq!(read(&reader, &good), refused);
    assert_eq!(response("saw"), (false, Vec::new()));
    assert!(matches!(
        read(&reader, &request_by("drill", &drill, "press"))[..],
        [Message::BeaconRequest(_)]
    ));
}

#[test]
fn what_is_no_secret_is_refused_without_showing_it() {
    for text in [
        "",
        "abc",
        &"g".repeat(64),
        &"a".repeat(66),
        &"+a".repeat(32),
        &"ä".repeat(32),
    ] {
        let error = BeaconSecret::from_hex(text).unwrap_err();
        assert_eq!(error.received, text.chars().count());
        assert!(
            text.is_empty() || !error.to_string().contains(text),
            "{error}"
        );
    }
    let secret = BeaconSecret::from_hex(&format!("{}\n", "0f".repeat(32)));
    assert_eq!(format!("{:?}", secret.unwrap()), "BeaconSecret");
}

fn before() -> impl Strategy<Value = Option<BeaconBefore>> {
    let before = |(number, left_ns)| BeaconBefore { number, left_ns };
    proptest::option::of((any::<u32>(), any::<i64>()).prop_map(before))
}

/// Whether there is to be a common time, and a reading of it.
fn common() -> impl Strategy<Value = (bool, Option<CommonStamp>)> {
    let stamp = |(at_ns, time_ns, bound_ns, grandmaster)| CommonStamp {
        at_ns,
        time_ns,
        bound_ns,
        grandmaster,
    };
    let stamp = any::<(i64, i64, u32, u64)>().prop_map(stamp);
    let taken = proptest::option::of(stamp).prop_map(|common| (true, common));
    prop_oneof![Just((false, None)), taken]
}

fn any_request() -> impl Strategy<Value = BeaconRequest> {
    let parts = (
        any::<u32>(),
        any::<u64>(),
        any::<u32>(),
        any::<i64>(),
        before(),
        common(),
    );
    parts.prop_map(
        |(requester, run, number, requested, before, (takes_common_time, common))| BeaconRequest {
            requester,
            run,
            number,
            requested,
            stamps: Stamps::Kernel,
            before,
            takes_common_time,
            common,
        },
    )
}

proptest! {
    #[test]
    fn requests_survive(request in any_request()) {
        let payload = request_frame(&request);
        let label = BeaconLabel::of(Channel::BeaconRequests, &payload).unwrap();
        prop_assert_eq!((label.requester, label.number), (request.requester, request.number));
        prop_assert_eq!(read(&requests(), &payload), [Message::BeaconRequest(request)]);
    }

    #[test]
    fn responses_survive(
        request in any_request(),
        epoch in any::<u64>(),
        stamps in any::<(i64, i64)>(),
        before in before(),
        common in common(),
    ) {
        let requester = sender_id(&name("saw"));
        let response = BeaconResponse {
            epoch,
            request: BeaconRequest { requester, ..request },
            received: Span::from_nanos(stamps.0),
            responded: Span::from_nanos(stamps.1),
            stamps: Stamps::Kernel,
            before,
            common: common.1.filter(|_| request.takes_common_time),
        };
        let payload = response_frame("press", &response);
        prop_assert_eq!(read(&responses(), &payload), [Message::BeaconResponse(response)]);
    }

    #[test]
    fn bytes_of_any_kind_give_one_message_or_none(bytes in proptest::collection::vec(any::<u8>(), 0..120)) {
        for reader in [requests(), responses()] {
            prop_assert!(matches!(read(&reader, &bytes)[..], [] | [Message::Rejected(_)]));
        }
    }

    #[test]
    fn a_flipped_bit_is_noticed(request in any_request(), place in any::<proptest::sample::Index>(), bit in 0..8_u8) {
        let mut payload = request_frame(&request);
        let place = place.index(payload.len());
        payload[place] ^= 1 << bit;
        prop_assert!(matches!(read(&requests(), &payload)[..], [Message::Rejected(_)]));
    }
}
