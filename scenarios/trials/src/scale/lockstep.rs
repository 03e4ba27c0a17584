//! Nodes in virtual time, all in the same cycle: publishers first, then followers, with a clock beside them.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::frame::KeySeal;
use coaxle_node::wiring::{self, Wiring, WiringLink};
use coaxle_node::{Channel, Node, Outgoing, Reader};
use coaxle_os::machine;
use coaxle_receiver::{Drives, Receiver, ReceiverConfig};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;

use super::size::Size;

/// Every node of a size.
pub(super) struct Lockstep {
    senders: Vec<Sender>,
    receivers: Vec<Receiver>,
    wirings: Vec<Wiring>,
    /// The links from each publication of each node.
    ways: Vec<Vec<Vec<WiringLink>>>,
    /// Seal of each publication of each node.
    seals: Vec<Vec<KeySeal>>,
    /// Reader of each subscription of each node.
    readers: Vec<Vec<Reader>>,
    /// Frames published and not delivered yet; their buffers are reused.
    posted: Vec<PendingFrame>,
    waiting: usize,
    cycle: i64,
    /// Messages that were published, and that were delivered.
    pub(super) published: u64,
    pub(super) delivered: u64,
}

/// A frame, with the indices of its node and publication.
struct PendingFrame {
    node: usize,
    publication: usize,
    frame: Vec<u8>,
}

/// Time that a cycle of all nodes took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CycleTimes {
    /// Senders: their cycle and its frames.
    pub(super) senders: Span,
    /// Frames read, and taken in.
    pub(super) intake: Span,
    /// Receivers: their scan and its frames.
    pub(super) receivers: Span,
}

impl CycleTimes {
    pub(super) fn all(self) -> Span {
        self.senders + self.intake + self.receivers
    }
}

impl std::ops::AddAssign for CycleTimes {
    fn add_assign(&mut self, other: Self) {
        self.senders += other.senders;
        self.intake += other.intake;
        self.receivers += other.receivers;
    }
}

impl Lockstep {
    /// # Errors
    /// A node that cannot be built.
    pub(super) fn new(size: Size) -> anyhow::Result<Self> {
        let (senders, receivers) = (size.senders()?, size.receiver_configs()?);
        let of_senders = senders.iter().map(SenderConfig::wiring);
        let of_receivers = receivers.iter().map(ReceiverConfig::wiring);
        let wirings: Vec<_> = of_senders.chain(of_receivers).collect();
        let mut ways: Vec<Vec<Vec<WiringLink>>> = Vec::new();
        ways.extend((wirings.iter()).map(|wiring| vec![Vec::new(); wiring.publications.len()]));
        for way in wiring::links(&wirings) {
            ways[way.from][way.publication].push(way);
        }
        let seals = wirings.iter().map(|wiring| {
            let publications = wiring.publications.iter();
            let key = publications.map(|one| one.node.channel_key(one.channel));
            key.map(|key| KeySeal::new(&key)).collect()
        });
        let readers = wirings.iter().map(|wiring| {
            let subscriptions = wiring.subscriptions.iter();
            subscriptions.map(|one| one.reader.clone()).collect()
        });
        let (seals, readers) = (seals.collect(), readers.collect());
        let build = senders
            .iter()
            .map(|one| Sender::new(one, Instant::EPOCH, 1));
        let senders = build.collect::<Result<_, _>>()?;
        let build = receivers.iter().map(|one| {
            let drives = Drives::simulated();
            Receiver::with_drives(one, drives, Instant::EPOCH, 1)
        });
        let receivers = build.collect::<Result<_, _>>()?;
        let mut lockstep = Self {
            senders,
            receivers,
            wirings,
            ways,
            seals,
            readers,
            posted: Vec::new(),
            waiting: 0,
            cycle: 0,
            published: 0,
            delivered: 0,
        };
        // Nodes publish some channels for subscribers only.
        lockstep.tell_subscribed();
        Ok(lockstep)
    }

    fn tell_subscribed(&mut self) {
        for (node, wiring) in self.wirings.iter().enumerate() {
            for channel in Channel::ALL {
                let ways = wiring.publications.iter().zip(&self.ways[node]);
                let mut ways = ways.filter(|(publication, _)| publication.channel == channel);
                let is_subscribed = ways.any(|(_, ways)| !ways.is_empty());
                match node.checked_sub(self.senders.len()) {
                    None => self.senders[node].set_subscribed(channel, is_subscribed),
                    Some(n) => self.receivers[n].set_subscribed(channel, is_subscribed),
                }
            }
        }
    }

    /// A cycle of every node.
    pub(super) fn cycle(&mut self) -> CycleTimes {
        // The cycle time of all configs is 1 ms.
        let now = Instant::EPOCH + Span::from_millis(self.cycle);
        self.cycle += 1;
        let begin = machine::now();
        // Taken out, as a scan posts its frames into the rest of this value.
        let mut senders = std::mem::take(&mut self.senders);
        for (node, sender) in senders.iter_mut().enumerate() {
            self.scan(node, sender, now);
        }
        self.senders = senders;
        let sent = machine::now();
        // After the senders and before the receivers: a frame arrives in the cycle that made it.
        self.deliver(now);
        let taken = machine::now();
        let mut receivers = std::mem::take(&mut self.receivers);
        let first = self.senders.len();
        for (n, receiver) in receivers.iter_mut().enumerate() {
            self.scan(first + n, receiver, now);
        }
        self.receivers = receivers;
        CycleTimes {
            senders: sent - begin,
            intake: taken - sent,
            receivers: machine::now() - taken,
        }
    }

    fn scan(&mut self, number: usize, node: &mut impl Node, now: Instant<Local>) {
        let _ = node.cycle(now);
        while let Some(outgoing) = node.transmit() {
            self.post(number, &outgoing, now);
        }
        while node.arrival().is_some() {}
    }

    fn post(&mut self, node: usize, outgoing: &Outgoing<'_>, now: Instant<Local>) {
        let publications = self.wirings[node].publications.iter();
        let mut numbered = publications.enumerate();
        let is_it =
            |one: &wiring::Publication| one.channel == outgoing.channel && one.far == outgoing.far;
        let Some((publication, _)) = numbered.find(|(_, one)| is_it(one)) else {
            return;
        };
        // The list grows in the first cycles only; later its buffers are reused, and nothing allocates.
        if self.waiting == self.posted.len() {
            self.posted.push(PendingFrame {
                node,
                publication,
                frame: Vec::new(),
            });
        }
        let posted = &mut self.posted[self.waiting];
        (posted.node, posted.publication) = (node, publication);
        // 0 in virtual time, but a stamp has its place in a real frame.
        let stamp = Some(now - outgoing.ideal_start);
        self.seals[node][publication].seal(outgoing.body, stamp, &mut posted.frame);
        self.waiting += 1;
        self.published += 1;
    }

    /// Delivers all frames published since the last call: by senders in this cycle, by receivers in the one before.
    fn deliver(&mut self, now: Instant<Local>) {
        let first = self.senders.len();
        for posted in &self.posted[..self.waiting] {
            for way in &self.ways[posted.node][posted.publication] {
                let reader = &mut self.readers[way.to][way.subscription];
                let (senders, receivers) = (&mut self.senders, &mut self.receivers);
                reader.read(&posted.frame, |message| match way.to.checked_sub(first) {
                    None => senders[way.to].receive(now, way.subscription, message),
                    Some(n) => receivers[n].receive(now, way.subscription, message),
                });
                self.delivered += 1;
            }
        }
        self.waiting = 0;
    }

    /// True if every slave of every receiver follows its master.
    #[cfg(test)]
    pub(super) fn is_in_sync(&self) -> bool {
        let slaves = self.receivers.iter().flat_map(|receiver| {
            let signals = &receiver.snapshot().signals;
            signals.slaves.iter().map(|slave| slave.velocity)
        });
        let velocities: Vec<f64> = slaves.flatten().collect();
        !velocities.is_empty() && velocities.iter().all(|velocity| *velocity > 99.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slave_follows_and_every_frame_comes_to_all_who_hear_it() {
        // A frame to three, three frames to one, and two pairs of nodes with 65 axes each.
        for (size, frames) in [("receivers:3", 3), ("senders:3", 3), ("axes:130", 2)] {
            let mut lockstep = Lockstep::new(size.parse().unwrap()).unwrap();
            for _ in 0..4_000 {
                lockstep.cycle();
            }
            assert!(lockstep.is_in_sync(), "{size}");
            let each = lockstep.delivered as f64 / 4_000.0;
            // Plus time requests and their responses.
            assert!(
                each > f64::from(frames) && each < f64::from(frames) + 0.5,
                "{size}: {each}"
            );
        }
    }
}
