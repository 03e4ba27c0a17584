//! The inputs of a node on their way into a recording: everything received before each scan, and
//! the start of the scan.
//!
//! Bounded, wait-free rings, as for its records. A scan without room for all its inputs is left
//! out, and the next one is marked as after a gap.

use coaxle_clock::{Instant, Local};
use coaxle_node::circles::CircleChange;
use coaxle_node::command::CommandOrder;
use coaxle_node::frame::MAX_AXES;
use coaxle_node::{AxisSample, KeptMessage, Message, NodeScan, ReceivedMessage};
use coaxle_os::machine::Machine;
use rtrb::{Consumer, Producer, RingBuffer};

/// Scans and messages that telemetry may lag behind: a second's worth of a few nodes at 1 kHz.
// A second at 1 kHz has 1000 scans; fifteen messages per scan come on top.
const ENTRIES: usize = 16_384;
/// Axes in these messages.
// 512 frames of the longest kind, or 16 384 of four axes each.
const AXES: usize = 512 * MAX_AXES;
/// Orders in these scans: more than arrive in a second.
const ORDERS: usize = 256;

/// A recorded scan.
#[derive(Clone, Debug, PartialEq)]
pub struct InputRecord {
    /// Nominal start of the cycle.
    pub ideal_start: Instant<Machine>,
    /// Actual start of the cycle.
    pub woke: Instant<Machine>,
    /// Inputs of the node.
    pub scan: NodeScan,
    /// True if scans before it are missing.
    pub after_gap: bool,
}

/// An input of the node, or the scan itself.
#[derive(Clone, Copy, Debug)]
enum InputEntry {
    Message {
        at: Instant<Local>,
        subscription: usize,
        message: Message<'static>,
        axes: usize,
    },
    Circle(CircleChange),
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
    entries: Producer<InputEntry>,
    axes: Producer<Option<AxisSample>>,
    orders: Producer<CommandOrder>,
    /// True while no input of this scan is missing.
    is_whole: bool,
}

/// Telemetry's end.
pub(crate) struct Inputs {
    entries: Consumer<InputEntry>,
    axes: Consumer<Option<AxisSample>>,
    orders: Consumer<CommandOrder>,
    /// Inputs of the scan that is not complete yet.
    open: NodeScan,
    /// True if the last scan was incomplete.
    gap: bool,
}

/// Creates the rings.
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
        open: NodeScan::default(),
        gap: false,
    };
    (tap, inputs)
}

impl InputTap {
    /// Records a message that the node receives.
    pub(crate) fn received(
        &mut self,
        at: Instant<Local>,
        subscription: usize,
        message: &Message<'_>,
    ) {
        self.is_whole &= self.try_received(at, subscription, message).is_some();
    }

    /// Records a circle across nodes that the node takes.
    pub(crate) fn circle(&mut self, change: CircleChange) {
        self.is_whole &= self.entries.push(InputEntry::Circle(change)).is_ok();
    }

    /// Records an order that the node executes. The copy shares the plate that may come with the
    /// order and is not its last owner: the order itself goes back to the command server.
    pub(crate) fn ordered(&mut self, order: &CommandOrder) {
        // Pushed in this order: an order entry without its order would take that of the next entry.
        let has_room = !self.entries.is_full() && self.orders.push(order.clone()).is_ok();
        self.is_whole &= has_room && self.entries.push(InputEntry::Order).is_ok();
    }

    /// Records the start of the scan.
    pub(crate) fn scan(
        &mut self,
        ideal_start: Instant<Machine>,
        woke: Instant<Machine>,
        now: Instant<Local>,
    ) {
        let scan = InputEntry::Scan {
            ideal_start,
            woke,
            now,
            is_whole: self.is_whole,
        };
        // Entries left over from a scan without room belong to the next one, which is incomplete then.
        // A scan whose entry is lost leaves its inputs in the ring.
        self.is_whole = self.entries.push(scan).is_ok();
    }

    fn try_received(
        &mut self,
        at: Instant<Local>,
        subscription: usize,
        message: &Message<'_>,
    ) -> Option<()> {
        let (message, axes) = message.split();
        // Before the axes are written: axes without a message would be read as those of the next message.
        if self.entries.is_full() {
            return None;
        }
        let room = self.axes.write_chunk_uninit(axes.len()).ok()?;
        room.fill_from_iter(axes.iter().copied());
        let entry = InputEntry::Message {
            at,
            subscription,
            message,
            axes: axes.len(),
        };
        self.entries.push(entry).ok()
    }
}

impl Inputs {
    /// Takes the oldest complete scan with its inputs.
    pub(crate) fn take(&mut self) -> Option<InputRecord> {
        while let Ok(entry) = self.entries.pop() {
            match entry {
                InputEntry::Message {
                    at,
                    subscription,
                    message,
                    axes,
                } => {
                    // `map_while` ends early only if the rings disagree, which the order of pushing prevents.
                    let axes: Vec<_> = (0..axes).map_while(|_| self.axes.pop().ok()).collect();
                    self.open.received.push(ReceivedMessage {
                        at,
                        subscription,
                        message: KeptMessage::new(&message.with_axes(&axes)),
                    });
                }
                InputEntry::Circle(change) => self.open.circles.push(change),
                InputEntry::Order => self.open.orders.extend(self.orders.pop().ok()),
                InputEntry::Scan {
                    ideal_start,
                    woke,
                    now,
                    is_whole,
                } => {
                    // The inputs of an incomplete scan are dropped with it, so that they are not replayed in the next one.
                    let told = std::mem::take(&mut self.open);
                    if !is_whole {
                        self.gap = true;
                        continue;
                    }
                    return Some(InputRecord {
                        ideal_start,
                        woke,
                        scan: NodeScan { now, ..told },
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
    use coaxle_node::circles::CircleState;
    use coaxle_node::{Channel, Frame, FrameHeader, Rejection};

    const REFUSED: Message<'static> = Message::Rejected(Rejection::Malformed);

    fn frame(axes: &[Option<AxisSample>]) -> Message<'_> {
        let header = FrameHeader {
            sender: 1,
            epoch: 2,
            index: CycleIndex(3),
            count: 3,
            cycle_time: CycleTime::new(Span::from_millis(1)).unwrap(),
            present_after: None,
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
        let circle = CircleChange {
            channel: Channel::Slaves,
            id: 1,
            state: CircleState::Closed,
        };
        assert_no_alloc(|| {
            tap.received(at(1), 0, &frame(&axes));
            tap.received(at(2), 3, &REFUSED);
            tap.circle(circle);
            tap.ordered(&order);
            tap.scan(at(10), at(11), at(12));
            tap.scan(at(20), at(21), at(22));
        });
        let first = inputs.take().unwrap();
        assert_eq!((first.ideal_start, first.woke), (at(10), at(11)));
        assert_eq!(first.scan.now, at(12));
        assert_eq!((first.scan.orders, first.after_gap), (vec![order], false));
        assert_eq!(first.scan.circles, [circle]);
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
        // A message per entry fills the ring to the last place.
        for _ in 0..ENTRIES {
            tap.received(at(1), 0, &REFUSED);
        }
        // No room for the scan entry itself.
        tap.scan(at(10), at(11), at(12));
        assert_eq!(inputs.take(), None);
        // The earlier inputs are in this one.
        tap.received(at(2), 0, &REFUSED);
        tap.scan(at(20), at(21), at(22));
        tap.scan(at(30), at(31), at(32));
        let whole = inputs.take().unwrap();
        // The second scan is incomplete as well: it holds the inputs of both. The third is whole.
        assert_eq!((whole.scan.now, whole.scan.received.len()), (at(32), 0));
        assert!(whole.after_gap);
    }
}
