//! The publisher: a thread of its own, because handing a frame to Zenoh allocates and takes some
//! ten microseconds.

use std::sync::Arc;
use std::time::Duration;

use coaxle_clock::Span;
use coaxle_node::Channel;
use coaxle_node::frame::KeySeal;
use zenoh::Wait;
use zenoh::pubsub::Publisher;

use crate::counters::{Counters, count};
use crate::faults::Faults;
use crate::machine;
use crate::outbox::{Outgoings, Parcel};

/// How long it sleeps at most when nobody wakes it.
const IDLE: Duration = Duration::from_millis(50);

/// What sealing adds to a body at most, amply.
const SEAL_ROOM: usize = 32;

/// One channel this node publishes.
pub(crate) struct PublishedChannel {
    pub(crate) channel: Channel,
    pub(crate) seal: KeySeal,
    pub(crate) publisher: Arc<Publisher<'static>>,
    pub(crate) faults: Faults,
}

/// Publishes what comes out of the ring until nothing more will come.
pub(crate) fn publish(
    mut outgoings: Outgoings,
    channels: &mut [PublishedChannel],
    send_stamps: bool,
    counters: &Counters,
) {
    let mut body = Vec::new();
    while !outgoings.is_finished() {
        while let Some(parcel) = outgoings.pop(&mut body) {
            let found = channels
                .iter_mut()
                .find(|channel| channel.channel == parcel.channel);
            match found.map(|channel| send(channel, &parcel, &body, send_stamps)) {
                Some(Ok(())) => count(&counters.published),
                Some(Err(error)) => {
                    tracing::debug!(%error, "Zenoh refused a frame");
                    count(&counters.publish_failed);
                }
                None => count(&counters.publish_failed),
            }
        }
        std::thread::park_timeout(IDLE);
    }
}

/// Sends a frame, as often and as late as the faults want it. Nothing is held back for a delay:
/// the frame leaves at once, with a stamp that says it left that much earlier.
fn send(
    channel: &mut PublishedChannel,
    parcel: &Parcel,
    body: &[u8],
    send_stamps: bool,
) -> zenoh::Result<()> {
    let stamped = send_stamps || !parcel.channel.carries_axes();
    for delay in channel.faults.of(machine::now()) {
        // Zenoh keeps the frame, so each gets a buffer of its own.
        let mut sealed = Vec::with_capacity(body.len() + SEAL_ROOM);
        let stamp = stamped.then(|| send_stamp(parcel) - delay);
        channel.seal.seal(body, stamp, &mut sealed);
        channel.publisher.put(sealed).wait()?;
    }
    Ok(())
}

/// How long after the ideal start of its cycle the frame leaves, in the node's own clock.
///
/// Measured on the machine's clock and scaled by the drift injected into the node's; without an
/// injected drift the two are the same clock.
fn send_stamp(parcel: &Parcel) -> Span {
    scaled(machine::now() - parcel.ideal_start, parcel.drift_ppm)
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
