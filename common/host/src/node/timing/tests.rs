//! Beacons over sockets: a simulated one, and the system's own on this machine.

use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::beacon::{
    BEACON_CAPACITY, BeaconLabel, BeaconResponseHeader, BeaconSeal, PairKeys,
    encode_beacon_request, encode_beacon_response,
};
use coaxle_node::config::LinkConfig;
use coaxle_node::frame::sender_id;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{Subscription, Wiring};
use coaxle_node::{BeaconRequest, Channel, Message, Stamps};
use coaxle_os::machine;
use coaxle_os::stamped_socket::{ReceivedDatagram, StampedSocket};

use super::receiver::{BeaconPath, BeaconReceiver};
use super::sender::{BeaconChannel, BeaconSender};
use super::{Peers, SecuredBeacons, Socket};
use crate::network::credentials::{
    AUTHORITY_FILE, Authority, REVOKED_FILE, RevocationList, Validity,
};
use crate::node::counters::Counters;
use crate::node::faults::Faults;
use crate::node::mailbox::{Mailbox, mailbox};
use crate::node::outbox::OutgoingFrame;
use crate::node::reception::{Contact, Reception};

type Sent = Arc<Mutex<Vec<(Vec<u8>, SocketAddr)>>>;

/// A socket that keeps the datagrams sent; the test sets their departure.
#[derive(Clone, Default)]
struct Paper {
    sent: Sent,
    departures: Arc<Mutex<VecDeque<(u32, i64)>>>,
    refuses: bool,
}

impl StampedSocket for Paper {
    fn bind(_: SocketAddr) -> io::Result<Self> {
        Ok(Self::default())
    }

    fn try_clone(&self) -> io::Result<Self> {
        Ok(self.clone())
    }

    fn address(&self) -> io::Result<SocketAddr> {
        Ok(at(1))
    }

    fn stamps(&self) -> Stamps {
        Stamps::Kernel
    }

    fn receive(&mut self, _: &mut [u8]) -> io::Result<Option<ReceivedDatagram>> {
        Ok(None)
    }

    fn send(&mut self, bytes: &[u8], to: SocketAddr) -> io::Result<()> {
        if self.refuses {
            return Err(io::ErrorKind::NetworkUnreachable.into());
        }
        self.sent.lock().unwrap().push((bytes.to_vec(), to));
        Ok(())
    }

    fn departure(&mut self) -> Option<(u32, i64)> {
        self.departures.lock().unwrap().pop_front()
    }
}

fn at(port: u16) -> SocketAddr {
    ([127, 0, 0, 1], port).into()
}

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn key(channel: Channel) -> String {
    name("belt").channel_key(channel)
}

fn channel(channel: Channel, to: Option<SocketAddr>) -> BeaconChannel {
    let faults = Faults::new(&LinkConfig::default(), 1, &key(channel), channel, 0);
    BeaconChannel {
        channel,
        far: 0,
        to,
        seal: BeaconSeal::new(&key(channel)),
        faults: faults.unwrap(),
    }
}

fn frame(channel: Channel) -> OutgoingFrame {
    OutgoingFrame {
        channel,
        far: 0,
        ideal_start: machine::now(),
        drift_ppm: 0.0,
    }
}

fn request(number: u32) -> Vec<u8> {
    let mut body = [0; BEACON_CAPACITY];
    let ideal = Instant::<Local>::EPOCH;
    let label = BeaconLabel {
        requester: sender_id(&name("saw")),
        run: 7,
        number,
    };
    let length = encode_beacon_request(&label, false, ideal, &mut body);
    body[..length].to_vec()
}

fn read(bytes: &[u8]) -> BeaconRequest {
    let seal = BeaconSeal::new(&key(Channel::BeaconRequests));
    seal.open_request(bytes).unwrap()
}

#[test]
fn each_beacon_tells_when_the_one_before_left() {
    let paper = Paper::default();
    let mut sender = BeaconSender::new(paper.clone(), Peers::default());
    sender.add(channel(Channel::BeaconRequests, Some(at(5))));
    let frame = frame(Channel::BeaconRequests);
    let mut left = Vec::new();
    for number in 0..4 {
        assert!(sender.send(&frame, &request(number)));
        // Two microseconds after the call: as a kernel stamps.
        left.push(machine::now().as_nanos() + 2_000);
        let nothing_is_known = number == 1;
        if !nothing_is_known {
            let departed = (number, left[number as usize]);
            paper.departures.lock().unwrap().push_back(departed);
        }
    }
    let sent = paper.sent.lock().unwrap();
    let known: Vec<_> = (sent.iter())
        .map(|(bytes, to)| (read(bytes).before, *to))
        .collect();
    let before = |number: u32| {
        let since = Instant::from_nanos(left[number as usize]) - frame.ideal_start;
        Some((number, since.as_nanos()))
    };
    // The departure of number 1 is not known when number 2 is sent.
    let expected = [None, before(0), None, before(2)];
    for ((known, to), expected) in known.iter().zip(expected) {
        assert_eq!(known.map(|it| (it.number, it.left_ns)), expected);
        assert_eq!(*to, at(5));
    }
    assert_eq!(read(&sent[3].0).stamps, Stamps::Kernel);
}

#[test]
fn a_stamp_of_another_time_is_not_believed_and_a_refused_datagram_breaks_nothing() {
    let paper = Paper::default();
    let mut sender = BeaconSender::new(paper.clone(), Peers::default());
    sender.add(channel(Channel::BeaconRequests, Some(at(5))));
    let frame = frame(Channel::BeaconRequests);
    assert!(sender.send(&frame, &request(0)));
    // A second ago: far outside the 50 ms after the call.
    let long_ago = machine::now().as_nanos() - 1_000_000_000;
    paper.departures.lock().unwrap().push_back((0, long_ago));
    assert!(sender.send(&frame, &request(1)));
    // The kernel counted a datagram that it did not send.
    let left = machine::now().as_nanos();
    paper.departures.lock().unwrap().push_back((2, left));
    assert!(sender.send(&frame, &request(2)));
    let left = machine::now().as_nanos();
    paper.departures.lock().unwrap().push_back((3, left));
    assert!(sender.send(&frame, &request(3)));
    let sent = paper.sent.lock().unwrap();
    let before: Vec<_> = (sent.iter())
        .map(|(bytes, _)| read(bytes).before.map(|before| before.number))
        .collect();
    // The departure of 0 was not believed. Those of 1 and 2 fit by time, and by the corrected count.
    assert_eq!(before, [None, None, Some(1), Some(2)]);
    let mut refusing = BeaconSender::new(
        Paper {
            refuses: true,
            ..Paper::default()
        },
        Peers::default(),
    );
    refusing.add(channel(Channel::BeaconRequests, Some(at(5))));
    assert!(!refusing.send(&frame, &request(0)));
    assert!(!refusing.send(&frame, &[1, 2]), "no beacon");
}

fn subscription(channel: Channel) -> Subscription {
    let wiring = |node| Wiring {
        node: name(node),
        publications: Vec::new(),
        subscriptions: Vec::new(),
    };
    let wiring = match channel {
        Channel::BeaconRequests => wiring("belt").with_timing_server(),
        _ => wiring("saw").with_timing_link(&name("belt"), 0, &LinkConfig::default()),
    };
    wiring.subscriptions[0].clone()
}

fn way(channel: Channel, from: Option<SocketAddr>) -> (BeaconPath, Mailbox) {
    let counters = Arc::new(Counters::default());
    let (inbox, mailbox) = mailbox(16, 0, Arc::clone(&counters.mailbox_dropped));
    let subscription = subscription(channel);
    let reception = Reception::new(&subscription, 1, inbox, Contact::new(), counters);
    let way = BeaconPath {
        channel,
        from,
        reception: reception.unwrap(),
    };
    (way, mailbox)
}

fn messages(mailbox: &mut Mailbox) -> Vec<(i64, bool)> {
    let mut messages = Vec::new();
    mailbox.drain(|arrival, message| {
        let is_good = !matches!(message, Message::Rejected(_));
        messages.push((arrival.as_nanos(), is_good));
    });
    messages
}

fn came(length: usize, from: SocketAddr, at_ns: Option<i64>) -> ReceivedDatagram {
    ReceivedDatagram {
        length,
        from,
        at_ns,
    }
}

#[test]
fn answers_go_to_where_the_newest_good_beacon_came_from() {
    let paper = Paper::default();
    let peers = Peers::default();
    let mut receiver = BeaconReceiver::new(Paper::default(), peers.clone(), None);
    let (requests, mut mailbox) = way(Channel::BeaconRequests, None);
    receiver.add(requests);
    let mut sender = BeaconSender::new(paper.clone(), peers);
    sender.add(channel(Channel::BeaconResponses, None));
    let asked = |number: u32| {
        let mut sealed = Vec::new();
        let departure = coaxle_node::beacon::Departure {
            left: Span::ZERO,
            stamps: Stamps::Kernel,
            before: None,
            common: None,
        };
        let seal = BeaconSeal::new(&key(Channel::BeaconRequests));
        seal.seal(&request(number), &departure, &mut sealed);
        sealed
    };
    let answer = {
        let header = BeaconResponseHeader {
            sender: sender_id(&name("belt")),
            epoch: 1,
            count: 5,
            cycle_time: coaxle_clock::CycleTime::new(Span::from_millis(1)).unwrap(),
        };
        let mut body = [0; BEACON_CAPACITY];
        let request = read(&asked(9));
        let length = encode_beacon_response(&header, &request, Span::ZERO, &mut body);
        body[..length].to_vec()
    };
    let label = BeaconLabel::of(Channel::BeaconResponses, &answer).unwrap();
    assert_eq!(
        (label.requester, label.number),
        (sender_id(&name("saw")), 9)
    );
    let frame = frame(Channel::BeaconResponses);
    assert!(!sender.send(&frame, &answer), "nobody asked as yet");

    let good = asked(9);
    receiver.take(&came(good.len(), at(100), Some(50)), &good);
    // An older beacon from another address, a damaged one, one without a stamp, one that is too long.
    let older = asked(8);
    receiver.take(&came(older.len(), at(200), Some(60)), &older);
    let mut damaged = asked(10);
    // A flipped bit, so that the check sum does not fit.
    damaged[3] ^= 1;
    receiver.take(&came(damaged.len(), at(300), Some(70)), &damaged);
    let unstamped = asked(11);
    receiver.take(&came(unstamped.len(), at(400), None), &unstamped);
    // 513 bytes are one too many.
    receiver.take(&came(513, at(500), Some(80)), &[1; 513]);
    assert_eq!(
        messages(&mut mailbox),
        // The damaged one arrives as refused. Those without a stamp and too long arrive nowhere.
        [(50, true), (60, true), (70, false)]
    );
    assert!(sender.send(&frame, &answer));
    assert_eq!(paper.sent.lock().unwrap()[0].1, at(100));
}

#[test]
fn answers_are_taken_from_where_the_beacons_went() {
    let mut receiver = BeaconReceiver::new(Paper::default(), Peers::default(), None);
    let (responses, mut mailbox) = way(Channel::BeaconResponses, Some(at(7)));
    receiver.add(responses);
    let bytes = [1, 2, 3];
    receiver.take(&came(3, at(8), Some(50)), &bytes);
    assert_eq!(messages(&mut mailbox), []);
    receiver.take(&came(3, at(7), Some(50)), &bytes);
    // Three bytes are no beacon: refused, but taken.
    assert_eq!(messages(&mut mailbox), [(50, false)]);
}

#[test]
fn the_key_of_a_revoked_member_is_withdrawn_while_the_node_runs() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new(Validity::days(machine::wall_clock(), 1)).unwrap();
    std::fs::write(folder.path().join(AUTHORITY_FILE), authority.certificate()).unwrap();
    let mut keys = PairKeys::default();
    for node in ["saw", "press"] {
        keys.add(name(node), 0, &[1; 32]);
    }
    let seal_for = |node: &str| {
        let secret = keys.of(&name(node)).unwrap();
        BeaconSeal::new(&key(Channel::BeaconRequests)).authenticated(secret)
    };
    let (saw, press) = (seal_for("saw"), seal_for("press"));
    let departure = coaxle_node::beacon::Departure {
        left: Span::ZERO,
        stamps: Stamps::Kernel,
        before: None,
        common: None,
    };
    let seals = |seal: &BeaconSeal| seal.seal(&request(1), &departure, &mut Vec::new());
    let mut secured = SecuredBeacons::new(keys.clone(), folder.path());
    secured.obey();
    assert!(seals(&saw) && seals(&press));
    let list = RevocationList {
        number: 1,
        before: [("saw".to_owned(), 7)].into(),
    };
    let signed = authority.sign(&list).unwrap();
    std::fs::write(folder.path().join(REVOKED_FILE), signed).unwrap();
    // The file is looked at once a second.
    let tries = (0..6_000).find(|_| {
        secured.obey();
        std::thread::park_timeout(std::time::Duration::from_millis(10));
        !seals(&saw)
    });
    assert!(tries.is_some() && seals(&press));
}

#[test]
fn the_systems_socket_says_when_datagrams_left_and_came() {
    let mut one = Socket::bind(at(0)).unwrap();
    let mut other = Socket::bind(at(0)).unwrap();
    let to = other.address().unwrap();
    let mut buffer = [0; 64];
    for number in 0..20 {
        let before = machine::now().as_nanos();
        one.send(&[number; 9], to).unwrap();
        let came = loop {
            if let Some(came) = other.receive(&mut buffer).unwrap() {
                break came;
            }
        };
        let after = machine::now().as_nanos();
        assert_eq!((came.length, came.from), (9, one.address().unwrap()));
        assert_eq!(buffer[..9], [number; 9]);
        // A clock that is set meanwhile, or a machine that stalls for long, leaves no stamp.
        let Some(received) = came.at_ns else {
            continue;
        };
        // A microsecond for reading two clocks.
        assert!((before - 1_000..=after + 1_000).contains(&received));
        if one.stamps() == Stamps::Application {
            assert_eq!(one.departure(), None);
            continue;
        }
        if let Some((count, left)) = one.departure() {
            assert_eq!(count, u32::from(number));
            assert!(
                (before - 1_000..=received + 1_000).contains(&left),
                "{left} {received}"
            );
        }
        assert_eq!(one.departure(), None);
    }
    assert_eq!(one.receive(&mut buffer).unwrap(), None, "nothing comes");
}
