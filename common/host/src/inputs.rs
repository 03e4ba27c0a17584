//! The inputs of a node on their way into a recording: what it is told before each scan, and when the scan begins.
//!
//! Bounded, wait-free rings, as for its records. A scan that finds no room for all it was told is left out, and the next one says so.

use coaxle_clock::{Instant, Local};
use coaxle_node::command::CommandOrder;
use coaxle_node::frame::MAX_AXES;
use coaxle_node::{AxisSample, KeptMessage, Message, Received, Scan};
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer, RingBuffer};

/// Scans and messages that telemetry may lag behind: a second's worth of a few nodes at 1 kHz.
const ENTRIES: usize = 16_384;
/// Axes in them.
const AXES: usize = 512 * MAX_AXES;
/// Orders in them: more than come in a second.
const ORDERS: usize = 256;

/// A scan as it is recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct InputRecord {
    /// When the cycle should have begun.
    pub ideal_start: Instant<Machine>,
    /// When it really did.
    pub woke: Instant<Machine>,
    /// What the node was told.
    pub scan: Scan,
    /// Scans before it are missing.
    pub after_gap: bool,
}

/// One thing that the node was told, or the scan itself.
#[derive(Clone, Copy, Debug)]
enum Entry {
    Message {
        at: Instant<Local>,
        subscription: usize,
        message: Message<'static>,
        axes: usize,
    },
    Order,
    Scan {
        ideal_start: Instant<Machine>,
        woke: Instant<Machine>,
        now: Instant<Local>,
        is_whole: bool,
    },
}

/// The cycle thread's end.
pub(crate) struct InputTap {
    entries: Producer<Entry>,
    axes: Producer<Option<AxisSample>>,
    orders: Producer<CommandOrder>,
    /// Nothing of this scan is missing yet.
    is_whole: bool,
}

/// Telemetry's end.
pub(crate) struct Inputs {
    entries: Consumer<Entry>,
    axes: Consumer<Option<AxisSample>>,
    orders: Consumer<CommandOrder>,
    /// What has come of the scan that is not over yet.
    open: Scan,
    /// The last one was not whole.
    gap: bool,
}

/// The rings.
pub(crate) fn inputs() -> (InputTap, Inputs) {
    let (entries, entries_out) = RingBuffer::new(ENTRIES);
    let (axes, axes_out) = RingBuffer::new(AXES);
    let (orders, orders_out) = RingBuffer::new(ORDERS);
    let tap = InputTap {
        entries,
        axes,
        orders,
        is_whole: true,
    };
    let inputs = Inputs {
        entries: entries_out,
        axes: axes_out,
        orders: orders_out,
        open: Scan::default(),
        gap: false,
    };
    (tap, inputs)
}

impl InputTap {
    /// The node receives a message.
    pub(crate) fn received(
        &mut self,
        at: Instant<Local>,
        subscription: usize,
        message: &Message<'_>,
    ) {
        self.is_whole &= self.try_received(at, subscription, message).is_some();
    }

    /// The node executes an order. A copy shares the plate that may come with it, whose last owner is not this one: the
    /// order itself goes back to who took it.
    pub(crate) fn ordered(&mut self, order: &CommandOrder) {
        let has_room = !self.entries.is_full() && self.orders.push(order.clone()).is_ok();
        self.is_whole &= has_room && self.entries.push(Entry::Order).is_ok();
    }

    /// The scan begins.
    pub(crate) fn scan(
        &mut self,
        ideal_start: Instant<Machine>,
        woke: Instant<Machine>,
        now: Instant<Local>,
    ) {
        let scan = Entry::Scan {
            ideal_start,
            woke,
            now,
            is_whole: self.is_whole,
        };
        // What is left of one that has no room belongs to the next one, which is not whole then.
        self.is_whole = self.entries.push(scan).is_ok();
    }

    fn try_received(
        &mut self,
        at: Instant<Local>,
        subscription: usize,
        message: &Message<'_>,
    ) -> Option<()> {
        let (message, axes) = message.split();
        if self.entries.is_full() {
            return None;
        }
        let room = self.axes.write_chunk_uninit(axes.len()).ok()?;
        room.fill_from_iter(axes.iter().copied());
        let entry = Entry::Message {
            at,
            subscription,
            message,
            axes: axes.len(),
        };
        self.entries.push(entry).ok()
    }
}

impl Inputs {
    /// The oldest scan that is whole, with what the node was told before it.
    pub(crate) fn take(&mut self) -> Option<InputRecord> {
        while let Ok(entry) = self.entries.pop() {
            match entry {
                Entry::Message {
                    at,
                    subscription,
                    message,
                    axes,
                } => {
                    let axes: Vec<_> = (0..axes).map_while(|_| self.axes.pop().ok()).collect();
                    self.open.received.push(Received {
                        at,
                        subscription,
                        message: KeptMessage::new(&message.with_axes(&axes)),
                    });
                }
                Entry::Order => self.open.orders.extend(self.orders.pop().ok()),
                Entry::Scan {
                    ideal_start,
                    woke,
                    now,
                    is_whole,
                } => {
                    let told = std::mem::take(&mut self.open);
                    if !is_whole {
                        self.gap = true;
                        continue;
                    }
                    return Some(InputRecord {
                        ideal_start,
                        woke,
                        scan: Scan { now, ..told },
                        after_gap: std::mem::take(&mut self.gap),
                    });
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use assert_no_alloc::assert_no_alloc;
    use coaxle_clock::{CycleIndex, CycleTime, Span};
    use coaxle_node::{Frame, FrameHeader, Rejection};

    const REFUSED: Message<'static> = Message::Rejected(Rejection::Malformed);

    fn frame(axes: &[Option<AxisSample>]) -> Message<'_> {
        let header = FrameHeader {
            sender: 1,
            epoch: 2,
            index: CycleIndex(3),
            count: 3,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            send_stamp: None,
        };
        Message::Frame(Frame { header, axes })
    }

    fn at<D: coaxle_clock::Domain>(nanos: i64) -> Instant<D> {
        Instant::from_nanos(nanos)
    }

    fn order() -> CommandOrder {
        let json = r#"{"version":1,"slave":"saw","command":{"home":{"position":3}}}"#;
        CommandOrder::from_json(json.as_bytes()).unwrap()
    }

    #[test]
    fn a_scan_comes_with_all_that_the_node_was_told_before_it() {
        let (mut tap, mut inputs) = inputs();
        let axes = [Some(AxisSample::default()), None];
        let order = order();
        assert_no_alloc(|| {
            tap.received(at(1), 0, &frame(&axes));
            tap.received(at(2), 3, &REFUSED);
            tap.ordered(&order);
            tap.scan(at(10), at(11), at(12));
            tap.scan(at(20), at(21), at(22));
        });
        let first = inputs.take().unwrap();
        assert_eq!((first.ideal_start, first.woke), (at(10), at(11)));
        assert_eq!(first.scan.now, at(12));
        assert_eq!((first.scan.orders, first.after_gap), (vec![order], false));
        let received = &first.scan.received;
        assert_eq!(received[0].message.get(), frame(&axes));
        assert_eq!((received[1].at, received[1].subscription), (at(2), 3));
        let second = inputs.take().unwrap();
        assert_eq!(second.scan.now, at(22));
        assert_eq!(
            (second.scan.received.len(), second.scan.orders.len()),
            (0, 0)
        );
        assert_eq!(inputs.take(), None);
    }

    #[test]
    fn a_scan_that_has_no_room_for_all_is_left_out_and_said() {
        let (mut tap, mut inputs) = inputs();
        for _ in 0..ENTRIES {
            tap.received(at(1), 0, &REFUSED);
        }
        // No room for itself.
        tap.scan(at(10), at(11), at(12));
        assert_eq!(inputs.take(), None);
        // What came before is in this one.
        tap.received(at(2), 0, &REFUSED);
        tap.scan(at(20), at(21), at(22));
        tap.scan(at(30), at(31), at(32));
        let whole = inputs.take().unwrap();
        assert_eq!((whole.scan.now, whole.scan.received.len()), (at(32), 0));
        assert!(whole.after_gap);
    }
}
