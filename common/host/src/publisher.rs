//! The publisher: a thread of its own, because handing a frame to the transport allocates and takes
//! some ten microseconds.

use std::sync::Arc;
use std::time::Duration;

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_node::frame::KeySeal;

use crate::counters::{Counters, count};
use crate::faults::Faults;
use crate::machine::{self, Machine};
use crate::outbox::{OutgoingFrame, OutgoingFrames};
use crate::transport::Publisher;

/// How long it sleeps at most when nobody wakes it.
const IDLE: Duration = Duration::from_millis(50);

/// What sealing adds to a body at most, amply.
const SEAL_ROOM: usize = 32;

/// One channel this node publishes.
pub(crate) struct PublishedChannel {
    pub(crate) channel: Channel,
    /// Which of the nodes that this one follows it is to.
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

/// Publishes what comes out of the ring until nothing more will come.
pub(crate) fn publish(
    mut frames: OutgoingFrames,
    channels: &mut [PublishedChannel],
    send_stamps: bool,
    counters: &Counters,
) {
    while !frames.is_finished() {
        publish_waiting(&mut frames, channels, send_stamps, counters, machine::now);
        std::thread::park_timeout(IDLE);
    }
}

/// Publishes what is in the ring; `now` reads the machine's clock.
pub(crate) fn publish_waiting(
    frames: &mut OutgoingFrames,
    channels: &mut [PublishedChannel],
    send_stamps: bool,
    counters: &Counters,
    now: impl Fn() -> Instant<Machine>,
) {
    let mut body = Vec::new();
    while let Some(frame) = frames.pop(&mut body) {
        let found = channels.iter_mut().find(|channel| channel.is_for(&frame));
        match found.map(|channel| send(channel, &frame, &body, send_stamps, &now)) {
            Some(Ok(())) => count(&counters.published),
            Some(Err(error)) => {
                tracing::debug!(%error, "the transport refused a frame");
                count(&counters.publish_failed);
            }
            None => count(&counters.publish_failed),
        }
    }
}

/// Sends a frame, as often and as late as the faults want it. Nothing is held back for a delay:
/// the frame leaves at once, with a stamp that says it left that much earlier.
fn send(
    channel: &mut PublishedChannel,
    frame: &OutgoingFrame,
    body: &[u8],
    send_stamps: bool,
    now: impl Fn() -> Instant<Machine>,
) -> anyhow::Result<()> {
    let stamped = send_stamps || !frame.channel.carries_axes();
    let at = now();
    let mut outcome = Ok(());
    for delay in channel.faults.deliveries(at) {
        let mut sealed = Vec::with_capacity(body.len() + SEAL_ROOM);
        let stamp = stamped.then(|| send_stamp(frame, now()) - delay);
        channel.seal.seal(body, stamp, &mut sealed);
        // The transport keeps the frame, so each gets a buffer of its own.
        channel.faults.tamper(at, &sealed, |frame| {
            let published = channel.publisher.publish(frame.to_vec());
            outcome = std::mem::replace(&mut outcome, Ok(())).and(published);
        });
    }
    outcome
}

/// How long after the ideal start of its cycle the frame leaves, in the node's own clock.
///
/// Measured on the machine's clock and scaled by the drift injected into the node's; without an
/// injected drift the two are the same clock.
fn send_stamp(frame: &OutgoingFrame, now: Instant<Machine>) -> Span {
    scaled(now - frame.ideal_start, frame.drift_ppm)
}

fn scaled(passed: Span, drift_ppm: f64) -> Span {
    let gained = passed.as_nanos() as f64 * drift_ppm * 1e-6;
    passed + Span::from_nanos(gained.round() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_clock_counts_more_nanoseconds() {
        let passed = Span::from_micros(300);
        assert_eq!(scaled(passed, 0.0), passed);
        assert_eq!(scaled(passed, 500.0), passed + Span::from_nanos(150));
        assert_eq!(scaled(passed, -500.0), passed - Span::from_nanos(150));
    }
}
