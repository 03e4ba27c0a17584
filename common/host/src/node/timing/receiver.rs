//! Receiving beacons.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::beacon::BeaconLabel;
use coaxle_os::machine;
use coaxle_os::stamped_socket::{ReceivedDatagram, StampedSocket};

use super::{LONGEST_BEACON, Peers, SecuredBeacons};
use crate::node::reception::Reception;

/// Pause after a datagram that could not be received.
// A socket whose interface is down fails at once, and the loop would take a whole processor.
const PAUSE: Span = Span::from_millis(100);

/// A path by which beacons arrive.
pub(crate) struct BeaconPath {
    pub(crate) channel: Channel,
    /// Required source address: responses come from the address that the beacons were sent to.
    pub(crate) from: Option<SocketAddr>,
    pub(crate) reception: Reception,
}

/// The receiving end of a timing channel.
pub(crate) struct BeaconReceiver<S> {
    socket: S,
    peers: Peers,
    paths: Vec<BeaconPath>,
    /// Keys and revocations in a secure network.
    secured: Option<SecuredBeacons>,
}

impl<S: StampedSocket> BeaconReceiver<S> {
    pub(super) const fn new(socket: S, peers: Peers, secured: Option<SecuredBeacons>) -> Self {
        Self {
            socket,
            peers,
            paths: Vec::new(),
            secured,
        }
    }

    /// Adds a path to receive by.
    pub(crate) fn add(&mut self, path: BeaconPath) {
        self.paths.push(path);
    }

    /// Receives until `stop` is set.
    pub(crate) fn work(&mut self, stop: &AtomicBool) {
        // A byte more than allowed, so that a longer datagram is seen as such.
        let mut buffer = [0; LONGEST_BEACON + 1];
        while !stop.load(Ordering::Relaxed) {
            if let Some(secured) = &mut self.secured {
                // The wait below has a limit, so that a list is obeyed even where nothing arrives.
                secured.obey();
            }
            match self.socket.receive(&mut buffer) {
                // The length that the kernel states may exceed what the buffer took.
                Ok(Some(came)) => self.take(&came, &buffer[..came.length.min(buffer.len())]),
                Ok(None) => {}
                Err(error) => {
                    tracing::debug!(%error, "the timing channel cannot receive");
                    // Limits the rate of retries.
                    machine::sleep_until(machine::now() + PAUSE);
                }
            }
        }
    }

    /// Takes a datagram. One without a valid stamp is ignored, and so is one that is too long.
    pub(super) fn take(&mut self, came: &ReceivedDatagram, bytes: &[u8]) {
        // Without a stamp the arrival is unknown by a whole wait of the thread: worse than no beacon.
        let Some(at) = came.at_ns.filter(|_| bytes.len() <= LONGEST_BEACON) else {
            return;
        };
        // Responses of a node come from its address; all else counts as beacons to this one.
        let answers = |path: &&mut BeaconPath| path.from == Some(came.from);
        let path = match self.paths.iter_mut().find(answers) {
            Some(path) => Some(path),
            // Requests have no fixed source: nodes are noted by the beacons that they send.
            None => self.paths.iter_mut().find(|path| path.from.is_none()),
        };
        let Some(path) = path else {
            return;
        };
        let is_good = path.reception.take(Instant::from_nanos(at), bytes);
        if !is_good && self.secured.is_some() {
            SecuredBeacons::note_refused(came.from);
        }
        // Only a good request sets the address: a forged one would lead the responses away.
        if is_good
            && path.channel == Channel::BeaconRequests
            && let Some(label) = BeaconLabel::of(path.channel, bytes)
        {
            self.peers.note(label, came.from);
        }
    }
}
