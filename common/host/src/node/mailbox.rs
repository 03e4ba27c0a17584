//! The mailbox: messages on their way from the network's thread into the cycle thread.
//!
//! Bounded, wait-free rings: one of messages, one of the axes of those that are frames. When either is
//! full a message is rejected and counted; neither side ever waits for the other.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use coaxle_clock::Instant;
use coaxle_node::frame::MAX_AXES;
use coaxle_node::{AxisSample, Message};
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer, RingBuffer};

/// A message with its arrival and the number of following axes that belong to it.
#[derive(Clone, Copy, Debug)]
struct Stored {
    arrival: Instant<Machine>,
    message: Message<'static>,
    axes: usize,
}

/// The network's end, for pushing messages.
#[derive(Debug)]
pub(crate) struct Inbox {
    messages: Producer<Stored>,
    axes: Producer<Option<AxisSample>>,
    rejected: Arc<AtomicU64>,
}

/// The cycle thread's end, for draining them.
#[derive(Debug)]
pub(crate) struct Mailbox {
    messages: Consumer<Stored>,
    axes: Consumer<Option<AxisSample>>,
    /// The axes of one frame.
    // A single frame: the buffer is filled again for the next one.
    frame: Box<[Option<AxisSample>]>,
}

/// Memory of a mailbox with room for this number of messages and of axes, bytes.
pub(crate) const fn mailbox_bytes(messages: usize, axes: usize) -> usize {
    messages * size_of::<Stored>() + axes * size_of::<Option<AxisSample>>()
}

/// Creates a mailbox with room for this number of messages and of axes in all of them. Every
/// message that finds it full increments `rejected`.
#[must_use]
pub(crate) fn mailbox(messages: usize, axes: usize, rejected: Arc<AtomicU64>) -> (Inbox, Mailbox) {
    let (messages_in, messages_out) = RingBuffer::new(messages);
    let (axes_in, axes_out) = RingBuffer::new(axes);
    let inbox = Inbox {
        messages: messages_in,
        axes: axes_in,
        rejected,
    };
    let mailbox = Mailbox {
        messages: messages_out,
        axes: axes_out,
        // Never more than fits into the ring: a mailbox of exchanges has no axes.
        frame: vec![None; MAX_AXES.min(axes)].into(),
    };
    (inbox, mailbox)
}

impl Inbox {
    /// Pushes a message that arrived at `arrival`, which may lie in the future with faults applied
    /// to the link. A message without room is counted as rejected.
    pub(crate) fn push(&mut self, arrival: Instant<Machine>, message: &Message<'_>) {
        if self.try_push(arrival, message).is_none() {
            self.rejected.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn try_push(&mut self, arrival: Instant<Machine>, message: &Message<'_>) -> Option<()> {
        let (message, axes) = message.split();
        // Checked before the axes are written, which could not be taken back.
        if self.messages.is_full() {
            return None;
        }
        let room = self.axes.write_chunk_uninit(axes.len()).ok()?;
        room.fill_from_iter(axes.iter().copied());
        let stored = Stored {
            arrival,
            message,
            axes: axes.len(),
        };
        self.messages.push(stored).ok()
    }
}

impl Mailbox {
    /// Takes the messages that are in it now. Messages that arrive meanwhile wait for the next
    /// call, so a flood cannot hold up the cycle for longer than a full ring takes.
    pub(crate) fn drain(&mut self, mut each: impl FnMut(Instant<Machine>, &Message<'_>)) {
        // The number of now, not until empty: a flood would otherwise keep the cycle in here.
        for _ in 0..self.messages.slots() {
            let Ok(stored) = self.messages.pop() else {
                return;
            };
            // A message without axes gets an empty slice.
            let frame = &mut self.frame[..stored.axes];
            if let Ok(axes) = self.axes.read_chunk(stored.axes) {
                let (first, second) = axes.as_slices();
                // A ring wraps: a frame may lie in two pieces, at the end and at the beginning.
                let (start, end) = frame.split_at_mut(first.len());
                start.copy_from_slice(first);
                end.copy_from_slice(second);
                axes.commit_all();
            }
            each(stored.arrival, &stored.message.with_axes(frame));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_clock::{CycleIndex, CycleTime, Span};
    use coaxle_node::{Frame, FrameHeader, Rejection};

    const REFUSED: Message<'static> = Message::Rejected(Rejection::Malformed);

    fn at(nanos: i64) -> Instant<Machine> {
        Instant::from_nanos(nanos)
    }

    fn frame(count: u64, axes: &[Option<AxisSample>]) -> Message<'_> {
        let header = FrameHeader {
            sender: 1,
            epoch: 2,
            index: CycleIndex::of_count(count),
            count,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            present_after: None,
            send_stamp: None,
        };
        Message::Frame(Frame { header, axes })
    }

    fn axes(error_code: u32, count: usize) -> Vec<Option<AxisSample>> {
        let axis = AxisSample {
            error_code,
            ..AxisSample::default()
        };
        vec![Some(axis); count]
    }

    #[test]
    fn messages_come_out_in_order_and_a_full_box_counts() {
        let rejected = Arc::new(AtomicU64::new(0));
        // Four places for seven messages.
        let (mut inbox, mut mailbox) = mailbox(4, 0, Arc::clone(&rejected));
        (0..7).for_each(|k| inbox.push(at(k), &REFUSED));
        assert_eq!(rejected.load(Ordering::Relaxed), 3);

        let mut arrivals = Vec::new();
        mailbox.drain(|arrival, _| arrivals.push(arrival.as_nanos()));
        assert_eq!(arrivals, [0, 1, 2, 3]);
    }

    #[test]
    fn a_frame_keeps_its_axes_or_does_not_come_at_all() {
        let rejected = Arc::new(AtomicU64::new(0));
        let (mut inbox, mut mailbox) = mailbox(100, 5, Arc::clone(&rejected));
        let mut count = 0;
        let mut expected = 0;
        for _ in 0..10 {
            // Two of three axes fit.
            for _ in 0..3 {
                count += 1;
                inbox.push(at(0), &frame(count.into(), &axes(count, 2)));
                inbox.push(at(0), &REFUSED);
            }
            let mut frames = Vec::new();
            mailbox.drain(|_, message| {
                if let Message::Frame(frame) = message {
                    assert_eq!(frame.axes, axes(frame.header.count as u32, 2));
                    frames.push(frame.header.count as u32);
                }
            });
            assert_eq!(frames, [count - 2, count - 1]);
            expected += 1;
            assert_eq!(rejected.load(Ordering::Relaxed), expected);
        }
    }

    #[test]
    fn draining_ends_although_messages_keep_coming() {
        let (mut inbox, mut mailbox) = mailbox(4, 0, Arc::default());
        (0..3).for_each(|k| inbox.push(at(k), &REFUSED));
        let mut drained = 0;
        mailbox.drain(|arrival, message| {
            drained += 1;
            inbox.push(arrival, message);
        });
        // The messages that were pushed while draining wait for the next scan.
        assert_eq!(drained, 3);
    }
}
