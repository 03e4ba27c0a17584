//! The timing channel in the real world: beacons over UDP, apart from the transport, stamped by the
//! kernel.
//!
//! A thread of its own receives; the publish thread sends. The two share the socket and the
//! addresses of the requesters.

mod common_time;
mod receiver;
mod secured;
mod sender;
#[cfg(test)]
mod tests;

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Context;
use coaxle_node::beacon::{BeaconLabel, BeaconSeal, PairKeys};
use coaxle_node::config::TimingEndpoints;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{Publication, Subscription};
use coaxle_node::{Channel, Reader, Stamps};
use coaxle_os::{Os, StampedSocket, System};

use crate::network::credentials::TIMING_KEYS_FILE;
use crate::node::counters::Counters;
use crate::node::faults::Faults;
use crate::node::mailbox::Inbox;
use crate::node::reception::{Contact, Reception};
use common_time::CommonClock;
use receiver::BeaconPath;
use sender::BeaconChannel;

pub(crate) use receiver::BeaconReceiver;
pub(crate) use secured::SecuredBeacons;
pub(crate) use sender::BeaconSender;

/// The socket of the system this was built for.
pub(crate) type Socket = <Os as System>::StampedSocket;

/// Length of the longest beacon, with a margin; longer datagrams are not beacons.
// A beacon has at most 512 bytes: docs/WIRE.md.
const LONGEST_BEACON: usize = 512;

/// The timing channel of a node, before its threads have its ends.
pub(crate) struct TimingChannel {
    sender: BeaconSender<Socket>,
    receiver: BeaconReceiver<Socket>,
    endpoints: TimingEndpoints,
    keys: Option<PairKeys>,
}

impl TimingChannel {
    /// Opens the channel for the beacons that the node sends. With keys, its beacons are
    /// authenticated, each with that of its pair, and all others are rejected.
    ///
    /// # Errors
    /// The address, or a file that faults name, cannot be used.
    pub(crate) fn open(
        node: &NodeName,
        endpoints: &TimingEndpoints,
        publications: &[Publication],
        seed: u64,
        secured: Option<SecuredBeacons>,
    ) -> anyhow::Result<Self> {
        // A node that only asks needs no known port: the response goes to the source of its datagram.
        let address = endpoints.listen.unwrap_or_else(|| any_like(endpoints));
        let socket = Socket::bind(address)
            .with_context(|| format!("timing: cannot open UDP {address} for beacons"))?;
        let other = socket
            // Two handles of one socket: both directions have the same port, which firewalls expect.
            .try_clone()
            .context("timing: cannot share the socket")?;
        // Port 0 becomes the one that the system chose.
        let bound = socket.address().unwrap_or(address);
        let stamps = stamped_by(socket.stamps());
        tracing::info!(%node, "timing channel on UDP {bound}, stamped by {stamps}");
        let peers = Peers::default();
        let keys = secured.as_ref().map(SecuredBeacons::keys).cloned();
        let common = endpoints.common_time.as_ref();
        let common = common.map(|setup| CommonClock::new(setup, seed));
        let mut sender = BeaconSender::new(other, peers.clone()).with_common_time(common);
        // Requests to several nodes, and responses, share the socket.
        for publication in publications.iter().filter(|p| p.channel.is_timing()) {
            let Publication {
                channel,
                far,
                faults,
                ..
            } = publication;
            let key = publication.node.channel_key(*channel);
            sender.add(BeaconChannel {
                channel: *channel,
                far: *far,
                to: address_of(endpoints, true, *channel, *far),
                seal: match (&keys, channel) {
                    (None, _) => BeaconSeal::new(&key),
                    (Some(keys), Channel::BeaconResponses) => {
                        BeaconSeal::new(&key).authenticated_by(keys)
                    }
                    (Some(keys), _) => match keys.of(&publication.node) {
                        Some(secret) => BeaconSeal::new(&key).authenticated(secret),
                        None => {
                            warn_of_missing_key(node, &publication.node);
                            continue;
                        }
                    },
                },
                faults: Faults::new(faults, seed, &key, *channel, *far)?,
            });
        }
        Ok(Self {
            sender,
            receiver: BeaconReceiver::new(socket, peers, secured),
            endpoints: endpoints.clone(),
            keys,
        })
    }

    /// Hands the beacons of this subscription to `inbox`.
    ///
    /// # Errors
    /// A file that its faults name cannot be used.
    pub(crate) fn receive(
        &mut self,
        subscription: &Subscription,
        seed: u64,
        inbox: Inbox,
        counters: &Arc<Counters>,
    ) -> anyhow::Result<()> {
        let Subscription { channel, far, .. } = *subscription;
        let contact = Contact::new();
        let mut subscription = subscription.clone();
        // Without this a datagram of anybody with a right check sum would be accepted.
        if let (Reader::Beacons(intake), Some(keys)) = (&mut subscription.reader, &self.keys) {
            *intake = match (channel, keys.of(&subscription.node)) {
                (Channel::BeaconRequests, _) => intake.clone().authenticated_by(keys),
                (_, Some(secret)) => intake.clone().authenticated(secret),
                // Without a key no request was sent either: `open` has logged it.
                (_, None) => return Ok(()),
            };
        }
        self.receiver.add(BeaconPath {
            channel,
            from: address_of(&self.endpoints, false, channel, far),
            reception: Reception::new(&subscription, seed, inbox, contact, Arc::clone(counters))?,
        });
        Ok(())
    }

    /// Splits it into the ends for the threads that send and receive.
    pub(crate) fn ends(self) -> (BeaconSender<Socket>, BeaconReceiver<Socket>) {
        (self.sender, self.receiver)
    }
}

fn warn_of_missing_key(node: &NodeName, other: &NodeName) {
    tracing::warn!(
        %node,
        "no timing channel with {other}: {TIMING_KEYS_FILE} has no key of the pair; `coaxle secure renew` with the \
         configs of both writes it"
    );
}

const fn stamped_by(stamps: Stamps) -> &'static str {
    match stamps {
        Stamps::Application => "the program itself",
        Stamps::Kernel => "the kernel",
        Stamps::Hardware => "the network card",
    }
}

/// Address of a channel to or from a followed node; none for responses to requesters.
///
/// A requested node has a channel of requests to it here; the responder accepts requests from any
/// address.
fn address_of(
    endpoints: &TimingEndpoints,
    publication: bool,
    channel: Channel,
    far: usize,
) -> Option<SocketAddr> {
    // A publication of requests goes to a node, and a subscription to responses comes from it.
    let follows = match channel {
        Channel::BeaconRequests => publication,
        _ => !publication,
    };
    let mut nodes = endpoints.nodes.iter().filter(|_| follows);
    nodes
        .find(|(number, _)| *number == far)
        .map(|(_, address)| *address)
}

/// Any port, of the address family that it sends to.
fn any_like(endpoints: &TimingEndpoints) -> SocketAddr {
    // An IPv4 socket reaches no IPv6 address.
    match endpoints.nodes.first() {
        Some((_, SocketAddr::V6(_))) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        Some((_, SocketAddr::V4(_))) | None => (Ipv4Addr::UNSPECIFIED, 0).into(),
    }
}

/// Addresses of the senders of beacons, by node id.
#[derive(Clone, Debug, Default)]
pub(crate) struct Peers(Arc<Mutex<Vec<Peer>>>);

#[derive(Clone, Copy, Debug)]
struct Peer {
    requester: u32,
    run: u64,
    number: u32,
    address: SocketAddr,
}

/// Greatest number of nodes that get responses.
// Bounds the memory: source addresses of datagrams are not authenticated in a plain network.
const MOST_PEERS: usize = 64;

impl Peers {
    /// Notes that a node sent a beacon from there. A beacon older than its newest one is ignored.
    fn note(&self, label: BeaconLabel, address: SocketAddr) {
        let mut peers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let peer = Peer {
            requester: label.requester,
            run: label.run,
            number: label.number,
            address,
        };
        let known = peers
            .iter_mut()
            .find(|known| known.requester == peer.requester);
        match known {
            Some(known) => {
                // Numbers wrap: the difference as a signed one is the distance, up to 2³¹ either way.
                let ahead = peer.number.wrapping_sub(known.number) as i32;
                // Another run counts from its own beginning, so that its number says nothing.
                if known.run != peer.run || ahead > 0 {
                    *known = peer;
                }
            }
            None => {
                if peers.len() == MOST_PEERS {
                    // The oldest entry goes: a requester that is still there is noted with its next beacon, 20 ms later.
                    peers.remove(0);
                }
                peers.push(peer);
            }
        }
    }

    fn address_of(&self, requester: u32) -> Option<SocketAddr> {
        let peers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = peers.iter().find(|peer| peer.requester == requester);
        found.map(|peer| peer.address)
    }
}
