//! Sending beacons.

use std::net::SocketAddr;

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::beacon::{BeaconLabel, BeaconSeal, Departure};
use coaxle_os::machine::{self, Machine};
use coaxle_os::stamped_socket::StampedSocket;

use super::Peers;
use super::common_time::CommonClock;
use crate::node::faults::Faults;
use crate::node::outbox::OutgoingFrame;

/// A channel of beacons that this node sends.
pub(crate) struct BeaconChannel {
    pub(crate) channel: Channel,
    /// Number of the followed node that it is sent to.
    pub(crate) far: usize,
    /// Address of that node; none for responses, which go to the address that the beacon came from.
    pub(crate) to: Option<SocketAddr>,
    pub(crate) seal: BeaconSeal,
    pub(crate) faults: Faults,
}

/// The newest beacon to a node.
#[derive(Clone, Copy, Debug)]
struct SentBeacon {
    channel: Channel,
    far: u16,
    label: BeaconLabel,
    /// Number of datagrams sent before it.
    number: u32,
    called: Instant<Machine>,
    /// Departure by its stamp.
    left: Option<Instant<Machine>>,
    /// Time by which the injected faults move the departure earlier.
    earlier: Span,
}

/// The sending end of a timing channel.
pub(crate) struct BeaconSender<S> {
    socket: S,
    peers: Peers,
    channels: Vec<BeaconChannel>,
    sent: Vec<SentBeacon>,
    /// Number of datagrams sent.
    number: u32,
    sealed: Vec<u8>,
    /// Time in common with other nodes, if there is one.
    common: Option<CommonClock>,
}

/// Latest departure of a datagram after the call that sends it.
const LATEST: Span = Span::from_millis(50);
/// Tolerance because the clocks are read one after the other.
const READING: Span = Span::from_micros(1);
/// Greatest number of nodes whose newest beacon is known.
// As many as get responses.
const MOST: usize = 64;

impl<S: StampedSocket> BeaconSender<S> {
    pub(super) const fn new(socket: S, peers: Peers) -> Self {
        Self {
            socket,
            peers,
            channels: Vec::new(),
            sent: Vec::new(),
            number: 0,
            sealed: Vec::new(),
            common: None,
        }
    }

    /// Reads a common time for each beacon.
    pub(super) fn with_common_time(self, common: Option<CommonClock>) -> Self {
        Self { common, ..self }
    }

    /// Adds a channel to send on.
    pub(crate) fn add(&mut self, channel: BeaconChannel) {
        self.channels.push(channel);
    }

    /// Sends a beacon; returns false if it cannot.
    pub(crate) fn send(&mut self, frame: &OutgoingFrame, body: &[u8]) -> bool {
        // First: the departure of the previous beacon goes into this one.
        self.note_departures();
        let Some(label) = BeaconLabel::of(frame.channel, body) else {
            return false;
        };
        let channel = self.channels.iter_mut().find(|channel| {
            channel.channel == frame.channel && channel.far == usize::from(frame.far)
        });
        let Some(channel) = channel else {
            return false;
        };
        let to = channel
            .to
            .or_else(|| self.peers.address_of(label.requester));
        // A response to a node that has not asked yet, or was displaced by 64 others.
        let Some(to) = to else {
            return false;
        };
        let Some(earlier) = channel.faults.deliveries(machine::now()).next() else {
            // Lost by an injected fault.
            return true;
        };
        let same = |sent: &SentBeacon| {
            (sent.channel, sent.far, sent.label.requester)
                == (frame.channel, frame.far, label.requester)
        };
        let place = self.sent.iter().position(same);
        // Taken out, since the entry of this beacon replaces it at the end of the list.
        let before = place.map(|place| self.sent.remove(place));
        // A beacon of an earlier run is of another clock.
        let before = before.filter(|before| before.label.run == label.run);
        // The departure may not be known yet: the field stays empty then.
        let before = before.and_then(|before| Some((before, before.left?)));
        let called = machine::now();
        let departure = Departure {
            left: frame.since_ideal_start(called) - earlier,
            stamps: self.socket.stamps(),
            before: before.map(|(sent, left)| {
                (
                    // In the clock of this frame's cycle: the ideal start is the common zero.
                    sent.label.number,
                    frame.since_ideal_start(left) - sent.earlier,
                )
            }),
            common: (self.common.as_mut()).and_then(|common| common.read(frame)),
        };
        if !channel.seal.seal(body, &departure, &mut self.sealed) {
            // The key of the pair has been withdrawn.
            return false;
        }
        if let Err(error) = self.socket.send(&self.sealed, to) {
            tracing::debug!(%error, "the timing channel refused a beacon");
            return false;
        }
        // The list is in the order of sending: the first is the one not used for longest.
        if self.sent.len() == MOST {
            self.sent.remove(0);
        }
        self.sent.push(SentBeacon {
            channel: frame.channel,
            far: frame.far,
            label,
            number: self.number,
            called,
            left: None,
            earlier,
        });
        // Counted as the kernel counts: it numbers the datagrams of a socket from 0, and wraps.
        self.number = self.number.wrapping_add(1);
        true
    }

    /// Notes the departures of the last beacons, as far as known.
    fn note_departures(&mut self) {
        while let Some((number, left_ns)) = self.socket.departure() {
            let left = Instant::from_nanos(left_ns);
            // A stamp of another beacon would be off by far more.
            let fits = |sent: &SentBeacon| {
                // A stamp of another datagram would make a departure that never was.
                sent.left.is_none()
                    && (sent.called - READING..=sent.called + LATEST).contains(&left)
            };
            let counted = |sent: &SentBeacon| sent.number == number && fits(sent);
            let sent = &mut self.sent;
            // A datagram that the kernel refused may have been counted by it, or not.
            let place = sent.iter().position(counted);
            if let Some(place) = place.or_else(|| sent.iter().position(fits)) {
                // Moved along by the difference, so that later numbers fit again.
                self.number = (self.number).wrapping_add(number.wrapping_sub(sent[place].number));
                sent[place].left = Some(left);
            }
        }
    }
}
