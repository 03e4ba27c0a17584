//! The publisher: a thread of its own, because handing a frame to the transport allocates and takes
//! some ten microseconds.

use std::sync::Arc;
use std::time::Duration;

use coaxle_clock::Instant;
use coaxle_node::Channel;
use coaxle_node::frame::KeySeal;
use coaxle_os::machine::{self, Machine};

use crate::network::transport::Publisher;
use crate::node::counters::{Counters, count};
use crate::node::faults::Faults;
use crate::node::outbox::{OutgoingFrame, OutgoingFrames};
use crate::node::timing::{BeaconSender, Socket};

/// Longest sleep without a wake-up.
// The last wake-up may come before the ring counts as abandoned: its end is noticed within this time.
const IDLE: Duration = Duration::from_millis(50);

/// Greatest number of bytes that sealing adds to a body, with a margin.
// A stamp of 11 bytes (a flag, and an i64 of ten) and a check sum of 4.
const SEAL_ROOM: usize = 32;

/// A channel this node publishes.
pub(crate) struct PublishedChannel {
    pub(crate) channel: Channel,
    /// Number of the followed node that it is sent to.
    pub(crate) far: usize,
    pub(crate) seal: KeySeal,
    pub(crate) publisher: Arc<dyn Publisher>,
    pub(crate) faults: Faults,
}

impl PublishedChannel {
    fn is_for(&self, frame: &OutgoingFrame) -> bool {
        self.channel == frame.channel && self.far == usize::from(frame.far)
    }
}

/// Publishes frames from the ring until no more can follow.
pub(crate) fn publish(
    mut frames: OutgoingFrames,
    channels: &mut [PublishedChannel],
    mut beacons: Option<BeaconSender<Socket>>,
    send_stamps: bool,
    counters: &Counters,
) {
    while !frames.is_finished() {
        let beacons = beacons.as_mut();
        publish_waiting(
            &mut frames,
            channels,
            beacons,
            send_stamps,
            counters,
            machine::now,
        );
        std::thread::park_timeout(IDLE);
    }
}

/// Publishes what is in the ring; `now` reads the machine's clock.
pub(crate) fn publish_waiting(
    frames: &mut OutgoingFrames,
    channels: &mut [PublishedChannel],
    mut beacons: Option<&mut BeaconSender<Socket>>,
    send_stamps: bool,
    counters: &Counters,
    now: impl Fn() -> Instant<Machine>,
) {
    // Allocated once per wake-up, not per frame.
    let mut body = Vec::new();
    while let Some(frame) = frames.pop(&mut body) {
        // Beacons are UDP datagrams of their own: the transport never sees them.
        if frame.channel.is_timing() {
            let sent = beacons
                .as_mut()
                .is_some_and(|beacons| beacons.send(&frame, &body));
            count(if sent {
                &counters.published
            } else {
                &counters.publish_failed
            });
            continue;
        }
        let found = channels.iter_mut().find(|channel| channel.is_for(&frame));
        match found.map(|channel| send(channel, &frame, &body, send_stamps, &now)) {
            Some(Ok(())) => count(&counters.published),
            Some(Err(error)) => {
                tracing::debug!(%error, "the transport refused a frame");
                count(&counters.publish_failed);
            }
            // No channel for it: wiring declares one for each channel that a node sends on.
            None => count(&counters.publish_failed),
        }
    }
}

/// Sends a frame with the copies and delays of the faults. No frame is held back for a delay: it
/// leaves at once, with a stamp that much earlier.
fn send(
    channel: &mut PublishedChannel,
    frame: &OutgoingFrame,
    body: &[u8],
    send_stamps: bool,
    now: impl Fn() -> Instant<Machine>,
) -> anyhow::Result<()> {
    // Requests and responses are worth nothing without their departure, so that they are always stamped.
    let stamped = send_stamps || !frame.channel.carries_axes();
    let at = now();
    let mut outcome = Ok(());
    for delay in channel.faults.deliveries(at) {
        let mut sealed = Vec::with_capacity(body.len() + SEAL_ROOM);
        // The stamp is read as late as possible: what follows it until the network is measured as delay.
        let stamp = stamped.then(|| frame.since_ideal_start(now()) - delay);
        channel.seal.seal(body, stamp, &mut sealed);
        // The transport keeps the frame, so each gets a buffer of its own.
        channel.faults.tamper(at, &sealed, |frame| {
            let published = channel.publisher.publish(frame.to_vec());
            // The first error stays: a second copy that passes does not make the frame published.
            outcome = std::mem::replace(&mut outcome, Ok(())).and(published);
        });
    }
    outcome
}
