//! The outbox: frames on their way from the cycle thread to the publisher.
//!
//! A wait-free ring of bytes, so that frames of any length fit without an allocation.

use std::thread::Thread;

use coaxle_clock::{Instant, Span};
use coaxle_node::Channel;
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer, RingBuffer};

/// Bytes before each body: channel, ideal start, rate, length, far node.
// Bytes of the fields in this order: u8, i64, f64, u32, u16.
const HEADER: usize = 1 + 8 + 8 + 4 + 2;

/// Data about a frame, besides its body, for the publisher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OutgoingFrame {
    /// Channel to publish on.
    pub(crate) channel: Channel,
    /// Number of the followed node that the frame is sent to.
    pub(crate) far: u16,
    /// The ideal start of its cycle.
    pub(crate) ideal_start: Instant<Machine>,
    /// Rate of the node's clock relative to the machine's, ppm.
    pub(crate) drift_ppm: f64,
}

/// The cycle thread's end, for pushing frames.
pub(crate) struct Outbox {
    ring: Producer<u8>,
    publisher: Option<Thread>,
}

/// The publisher's end, for popping frames.
pub(crate) struct OutgoingFrames {
    ring: Consumer<u8>,
}

/// Creates an outbox of `capacity` bytes.
pub(crate) fn outbox(capacity: usize) -> (Outbox, OutgoingFrames) {
    let (producer, consumer) = RingBuffer::new(capacity);
    let outbox = Outbox {
        ring: producer,
        publisher: None,
    };
    (outbox, OutgoingFrames { ring: consumer })
}

impl Outbox {
    /// Sets the thread that [`Self::wake`] wakes.
    pub(crate) fn attach(&mut self, publisher: Thread) {
        self.publisher = Some(publisher);
    }

    /// Pushes a whole frame; returns false if it does not fit.
    #[must_use]
    pub(crate) fn push(&mut self, frame: &OutgoingFrame, body: &[u8]) -> bool {
        let header = frame.encode(body.len() as u32);
        // All or nothing: a frame cut by a full ring would shift all later ones.
        let Ok(mut chunk) = self.ring.write_chunk(HEADER + body.len()) else {
            return false;
        };
        // A free stretch that passes the end of the ring has two parts.
        let (first, second) = chunk.as_mut_slices();
        spread(&header, 0, first, second);
        spread(body, HEADER, first, second);
        chunk.commit_all();
        true
    }

    /// Wakes the publisher.
    pub(crate) fn wake(&self) {
        if let Some(publisher) = &self.publisher {
            publisher.unpark();
        }
    }
}

impl Drop for Outbox {
    /// Wakes the publisher: no more frames follow. The ring shows it only once this value is gone,
    /// a moment later; the publisher's park has a timeout for that.
    fn drop(&mut self) {
        self.wake();
    }
}

impl OutgoingFrames {
    /// Takes the oldest frame; its body replaces the contents of `body`.
    pub(crate) fn pop(&mut self, body: &mut Vec<u8>) -> Option<OutgoingFrame> {
        let mut header = [0; HEADER];
        // Fewer bytes than a header mean an empty ring: frames are committed whole.
        self.ring.pop_entire_slice(&mut header).ok()?;
        let (frame, length) = OutgoingFrame::decode(&header);
        body.clear();
        // The capacity stays from the longest frame of this wake-up.
        body.resize(length as usize, 0);
        self.ring
            .pop_entire_slice(body)
            .expect("a frame is put in as a whole");
        Some(frame)
    }

    /// True if no frame is left and none can follow.
    pub(crate) fn is_finished(&self) -> bool {
        // The order of the two checks matters: an abandoned ring receives no more frames.
        self.ring.is_abandoned() && self.ring.is_empty()
    }
}

impl OutgoingFrame {
    /// Time of an event since the ideal start of the frame's cycle, in the node's own clock.
    ///
    /// Measured on the machine's clock and scaled by the drift injected into the node's; without an
    /// injected drift the two are the same clock.
    pub(crate) fn since_ideal_start(&self, at: Instant<Machine>) -> Span {
        scaled(at - self.ideal_start, self.drift_ppm)
    }

    fn encode(&self, length: u32) -> [u8; HEADER] {
        let mut header = [0; HEADER];
        header[0] = self.channel as u8;
        // Native order: both ends are threads of one process.
        header[1..9].copy_from_slice(&self.ideal_start.as_nanos().to_ne_bytes());
        header[9..17].copy_from_slice(&self.drift_ppm.to_ne_bytes());
        header[17..21].copy_from_slice(&length.to_ne_bytes());
        header[21..].copy_from_slice(&self.far.to_ne_bytes());
        header
    }

    fn decode(header: &[u8; HEADER]) -> (Self, u32) {
        let eight = |at: usize| {
            let mut bytes = [0; 8];
            bytes.copy_from_slice(&header[at..at + 8]);
            bytes
        };
        let frame = Self {
            // A number out of `encode` of this very process.
            channel: Channel::ALL[usize::from(header[0])],
            far: u16::from_ne_bytes([header[21], header[22]]),
            ideal_start: Instant::from_nanos(i64::from_ne_bytes(eight(1))),
            drift_ppm: f64::from_ne_bytes(eight(9)),
        };
        let mut length = [0; 4];
        length.copy_from_slice(&header[17..21]);
        (frame, u32::from_ne_bytes(length))
    }
}

fn scaled(passed: Span, drift_ppm: f64) -> Span {
    // Nanoseconds of a cycle fit a float exactly; ppm · 1e-6 is the relative rate.
    let gained = passed.as_nanos() as f64 * drift_ppm * 1e-6;
    passed + Span::from_nanos(gained.round() as i64)
}

/// Copies `bytes` to offset `at` of a target that is split in two.
fn spread(bytes: &[u8], at: usize, first: &mut [u8], second: &mut [u8]) {
    // `at` may lie beyond the first part: then all bytes go into the second.
    let room = first.len().saturating_sub(at).min(bytes.len());
    let (head, tail) = bytes.split_at(room);
    if !head.is_empty() {
        first[at..at + room].copy_from_slice(head);
    }
    if !tail.is_empty() {
        let start = (at + room) - first.len();
        second[start..start + tail.len()].copy_from_slice(tail);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(k: i64) -> OutgoingFrame {
        OutgoingFrame {
            channel: Channel::ALL[k as usize % Channel::ALL.len()],
            far: k as u16 * 131,
            ideal_start: Instant::from_nanos(k * 1_000_003),
            drift_ppm: k as f64 * 0.5,
        }
    }

    #[test]
    fn frames_of_every_length_pass_the_end_of_the_ring_unharmed() {
        // A prime length, so that frames wrap at another place each time round.
        let (mut outbox, mut frames) = outbox(101);
        let mut body = Vec::new();
        for k in 0..500 {
            let sent: Vec<u8> = (0..k % 37).map(|byte| (byte + k) as u8).collect();
            assert!(outbox.push(&frame(k), &sent));
            assert_eq!(frames.pop(&mut body), Some(frame(k)));
            assert_eq!(body, sent);
        }
        assert_eq!(frames.pop(&mut body), None);
    }

    #[test]
    fn a_frame_that_does_not_fit_leaves_the_others_whole() {
        let (mut outbox, mut frames) = outbox(100);
        assert!(outbox.push(&frame(1), &[7; 60]));
        // 60 + 23 bytes leave 17 of 100: 30 with their header do not fit.
        assert!(!outbox.push(&frame(2), &[8; 30]));
        drop(outbox);
        assert!(!frames.is_finished());
        let mut body = Vec::new();
        assert_eq!(frames.pop(&mut body), Some(frame(1)));
        assert_eq!(body, [7; 60]);
        assert!(frames.is_finished());
    }

    #[test]
    fn a_fast_clock_counts_more_nanoseconds() {
        let passed = Span::from_micros(300);
        assert_eq!(scaled(passed, 0.0), passed);
        // 300 µs · 500 ppm = 150 ns.
        assert_eq!(scaled(passed, 500.0), passed + Span::from_nanos(150));
        assert_eq!(scaled(passed, -500.0), passed - Span::from_nanos(150));
    }
}
