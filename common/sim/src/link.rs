//! A link: one subscription, and the network's effects on its messages.

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::beacon::{BeaconLabel, BeaconSeal, CommonStamp, Departure};
use coaxle_node::config::Wrong;
use coaxle_node::faults::{LinkModel, Tampering};
use coaxle_node::frame::KeySeal;
use coaxle_node::{Channel, Message, Outgoing, Reader, Stamps};

use crate::setup::LinkSetup;
use crate::traffic::LinkCounts;
use crate::true_time::True;

/// A link from a node that publishes to one that subscribes.
pub(crate) struct Link {
    pub(crate) from: usize,
    pub(crate) channel: Channel,
    far: usize,
    pub(crate) to: usize,
    pub(crate) subscription: usize,
    seal: KeySeal,
    beacons: Beacons,
    reader: Reader,
    tampering: Vec<Tampering>,
    models: Vec<LinkModel>,
    /// Flow in the network of routers; none for a direct link between nodes.
    pub(crate) flow: Option<usize>,
    pub(crate) counts: LinkCounts,
}

/// Departure of a frame from its node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkDeparture {
    /// Time of the publisher's clock.
    pub(crate) left: Instant<Local>,
    /// True if frames of axes carry it.
    pub(crate) stamped: bool,
    /// The publisher's reading of a common time, for beacons.
    pub(crate) common_time: Option<CommonStamp>,
}

impl Link {
    pub(crate) fn new(setup: LinkSetup) -> Result<Self, Wrong> {
        let behaviour = || setup.behaviour.iter();
        let models = behaviour().map(|(config, seed)| LinkModel::new(config, *seed));
        let tampering = behaviour();
        let tampering =
            // Not every behaviour tampers with bytes, but each has a delay: the two lists differ in length.
            tampering.filter_map(|(config, seed)| Tampering::new(config, *seed, &setup.key));
        let (models, tampering) = (models.collect::<Result<_, _>>()?, tampering.collect());
        Ok(Self {
            from: setup.from,
            channel: setup.channel,
            far: setup.far,
            to: setup.to,
            subscription: setup.subscription,
            seal: KeySeal::new(&setup.key),
            beacons: Beacons {
                seal: BeaconSeal::new(&setup.key),
                before: None,
            },
            reader: setup.reader,
            tampering,
            models,
            flow: None,
            counts: LinkCounts::default(),
        })
    }

    /// True if it carries this output of the node `from`.
    pub(crate) fn takes(&self, from: usize, outgoing: &Outgoing<'_>) -> bool {
        self.from == from && self.channel == outgoing.channel && self.far == outgoing.far
    }

    /// Seals the frame with its departure; none if it is for another link.
    pub(crate) fn seal<'a>(
        &mut self,
        outgoing: &Outgoing<'_>,
        departure: &LinkDeparture,
        frame: &'a mut Vec<u8>,
    ) -> Option<&'a [u8]> {
        if outgoing.channel.is_timing() {
            let label = BeaconLabel::of(outgoing.channel, outgoing.body)?;
            // Beacons of a node leave in one stream for all; each link carries those of its own recipient only.
            if !self.reader.concerns(&label) {
                return None;
            }
            self.beacons.seal(outgoing, label, departure, frame);
        } else {
            // The setting concerns frames of axes; responses to time requests are useless without their
            // departure.
            let stamped = departure.stamped || !outgoing.channel.carries_axes();
            let stamp = stamped.then(|| departure.left - outgoing.ideal_start);
            self.seal.seal(outgoing.body, stamp, frame);
        }
        Some(frame)
    }

    /// Sends a frame at true time `now`: each message in it is delivered when due.
    pub(crate) fn send(
        &mut self,
        now: Instant<True>,
        frame: &[u8],
        deliver: impl FnMut(Instant<True>, &Message<'_>),
    ) {
        self.counts.send();
        self.pass_on(now, frame, deliver);
    }

    /// Passes on a frame that was counted at its sender and has arrived over routers.
    pub(crate) fn pass_on(
        &mut self,
        now: Instant<True>,
        frame: &[u8],
        mut deliver: impl FnMut(Instant<True>, &Message<'_>),
    ) {
        // Split into fields: the closures below borrow the models and the reader at once.
        let Self {
            reader,
            tampering,
            models,
            counts,
            ..
        } = self;
        let sent = now.since_epoch();
        tamper(tampering, counts, sent, frame, &mut |frame| {
            // Tampering precedes the delays: a duplicated frame is two messages, each with a delay of its own.
            pass(models, counts, sent, Span::ZERO, &mut |delay| {
                let mut messages = 0;
                reader.read(frame, |message| {
                    // A frame may hold several messages or, damaged, none at all: counted, so that the sums still
                    // agree.
                    messages += 1;
                    deliver(now + delay, message);
                });
                counts.became(messages);
            });
        });
    }
}

/// Beacons of one node to another: stamped like by a kernel, without delay.
struct Beacons {
    seal: BeaconSeal,
    /// The previous beacon, and its departure.
    before: Option<(BeaconLabel, Instant<Local>)>,
}

impl Beacons {
    fn seal(
        &mut self,
        outgoing: &Outgoing<'_>,
        label: BeaconLabel,
        departure: &LinkDeparture,
        frame: &mut Vec<u8>,
    ) {
        let (ideal_start, left) = (outgoing.ideal_start, departure.left);
        let before = self.before.replace((label, left));
        // A departure reported for a beacon of an earlier run would pair stamps of two clocks.
        let before = before.filter(|(before, _)| before.run == label.run);
        let departure = Departure {
            left: left - ideal_start,
            stamps: Stamps::Kernel,
            before: before.map(|(before, left)| (before.number, left - ideal_start)),
            common: departure.common_time.map(|common| CommonStamp {
                at_ns: common.at_ns - ideal_start.as_nanos(),
                ..common
            }),
        };
        self.seal.seal(outgoing.body, &departure, frame);
    }
}

/// Passes a frame through the tampering stages in series.
fn tamper(
    tampering: &mut [Tampering],
    counts: &LinkCounts,
    sent: Span,
    frame: &[u8],
    // A type parameter would be a new closure type in every stage, without end.
    arrive: &mut dyn FnMut(&[u8]),
) {
    match tampering.split_first_mut() {
        None => arrive(frame),
        Some((first, others)) => {
            let mut messages = 0;
            first.pass(sent, frame, |frame| {
                messages += 1;
                tamper(others, counts, sent, frame, arrive);
            });
            counts.became(messages);
        }
    }
}

/// Passes a message through the models in series. Each evaluates the message at its sending time,
/// independent of the models before it, and their delays add up.
fn pass(
    models: &mut [LinkModel],
    counts: &LinkCounts,
    sent: Span,
    delayed: Span,
    arrive: &mut impl FnMut(Span),
) {
    match models.split_first_mut() {
        None => arrive(delayed),
        Some((model, others)) => {
            let mut messages = 0;
            // An iterator, because a model may lose a message or duplicate it.
            for delay in model.offer(sent) {
                messages += 1;
                pass(others, counts, sent, delayed + delay, arrive);
            }
            counts.became(messages);
        }
    }
}
