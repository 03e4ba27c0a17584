//! Between the threads that wait for the PLC and the node's cycle: rings in which buffers go round.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::thread::Thread;
use std::time::Duration;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, Instant, Local, Span};
use coaxle_os::{Machine, machine};
use rtrb::{Consumer, Producer, RingBuffer};

use crate::config::GatewayConfig;
use crate::{LinkState, PlcOutput, PlcSample, Port};

/// Samples that can wait for the node, and outputs for the PLC.
// At 1 kHz 64 ms, as many as the node takes in one cycle.
const RING: usize = 64;
/// Interval at which waiting threads check for the end.
// The longest delay of an end, beside the wait for a reply.
const STOP_POLL: Duration = Duration::from_millis(50);

/// Ends the threads.
#[derive(Debug, Default)]
pub(super) struct StopFlag(AtomicBool);

impl StopFlag {
    pub(super) fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Sleeps, but not beyond the end.
    pub(super) fn sleep(&self, pause: Span) {
        let until = machine::now() + pause;
        let poll = Span::from_nanos(STOP_POLL.as_nanos() as i64);
        while !self.is_set() && machine::now() < until {
            // In pieces, so that a pause of seconds does not delay the end.
            machine::sleep_until(until.min(machine::now() + poll));
        }
    }
}

/// State of the connection to the PLC, as the threads know it.
#[derive(Debug, Default)]
pub(super) struct PlcLink {
    is_up: AtomicBool,
    is_stopped: AtomicBool,
    connections: AtomicU32,
    torn: AtomicU64,
    refused: AtomicU64,
}

impl PlcLink {
    /// Marks the PLC as connected. Returns the number of the connection.
    pub(super) fn connected(&self) -> u32 {
        let before = self.connections.fetch_add(1, Ordering::Relaxed);
        self.is_up.store(true, Ordering::Relaxed);
        before + 1
    }

    pub(super) fn disconnected(&self) {
        self.is_up.store(false, Ordering::Relaxed);
        // A PLC that is away is not stopped: what is known of it ended with the connection.
        self.is_stopped.store(false, Ordering::Relaxed);
    }

    /// Stores whether the PLC's runtime is stopped. True if that has changed.
    pub(super) fn set_stopped(&self, is_stopped: bool) -> bool {
        // `swap` sets and compares at once: a change is logged once.
        self.is_stopped.swap(is_stopped, Ordering::Relaxed) != is_stopped
    }

    pub(super) fn count_torn(&self, samples: u64) {
        self.torn.fetch_add(samples, Ordering::Relaxed);
    }

    /// Counts a received message that is no sample. True for the first one.
    pub(super) fn count_refused(&self) -> bool {
        self.refused.fetch_add(1, Ordering::Relaxed) == 0
    }
}

/// The end of the node.
pub(super) struct RingPort {
    samples: Consumer<StampedSample>,
    emptied: Producer<StampedSample>,
    outputs: Producer<OutputSlot>,
    returned: Consumer<OutputSlot>,
    link: Arc<PlcLink>,
    /// Thread that sleeps until there is an output for the PLC.
    writer: Arc<std::sync::OnceLock<Thread>>,
}

/// The end of the threads.
pub(super) struct PlcEnd {
    pub(super) samples: Samples,
    pub(super) outputs: PlcOutputs,
    pub(super) link: Arc<PlcLink>,
    pub(super) stop: Arc<StopFlag>,
}

/// Samples on their way to the node.
pub(super) struct Samples {
    full: Producer<StampedSample>,
    empty: Consumer<StampedSample>,
    spare: Option<StampedSample>,
}

/// Outputs for the PLC.
pub(super) struct PlcOutputs {
    full: Consumer<OutputSlot>,
    empty: Producer<OutputSlot>,
    writer: Arc<std::sync::OnceLock<Thread>>,
}

/// A sample with its arrival by the machine's clock.
struct StampedSample {
    at: Instant<Machine>,
    sample: PlcSample,
}

/// Axes for the PLC.
#[derive(Clone, Debug)]
pub(super) struct OutputSlot {
    /// Index of the output in the config.
    pub(super) number: usize,
    pub(super) index: CycleIndex,
    pub(super) axes: Box<[Option<NcToPlcAxis>]>,
}

/// The two ends.
pub(super) fn rings(config: &GatewayConfig, stop: Arc<StopFlag>) -> (RingPort, PlcEnd) {
    let axes = config.axes.len();
    let (full, samples) = RingBuffer::new(RING);
    let (mut emptied, empty) = RingBuffer::new(RING);
    let (output, output_full) = RingBuffer::new(RING);
    let (mut output_empty, returned) = RingBuffer::new(RING);
    for _ in 0..RING {
        // Allocated here: buffers go round, and no cycle of the node allocates.
        let stamped = StampedSample {
            at: Instant::EPOCH,
            sample: PlcSample::of_axes(axes),
        };
        // They are as many as there is room for.
        let _ = emptied.push(stamped);
        let _ = output_empty.push(OutputSlot::of(config));
    }
    let (link, writer) = (Arc::new(PlcLink::default()), Arc::default());
    let port = RingPort {
        samples,
        emptied,
        outputs: output,
        returned,
        link: Arc::clone(&link),
        writer: Arc::clone(&writer),
    };
    let end = PlcEnd {
        samples: Samples {
            full,
            empty,
            spare: None,
        },
        outputs: PlcOutputs {
            full: output_full,
            empty: output_empty,
            writer,
        },
        link,
        stop,
    };
    (port, end)
}

impl Port for RingPort {
    fn receive(&mut self, now: Instant<Local>, sample: &mut PlcSample) -> bool {
        let Ok(stamped) = self.samples.pop() else {
            return false;
        };
        // Copied: the buffers of the ring are those of the threads.
        sample.replace(&stamped.sample);
        // The node's clock reads `now` at the start of this cycle.
        sample.at = now + (stamped.at - machine::cycle_start());
        // Room is certain: there are as many buffers as places.
        let _ = self.emptied.push(stamped);
        true
    }

    fn send(&mut self, output: &PlcOutput<'_>) {
        // All buffers are with the writer, which hangs: newer axes follow.
        let Ok(mut slot) = self.returned.pop() else {
            return;
        };
        slot.number = output.number;
        slot.index = output.index;
        // A slot has room for the longest output; this one may be shorter.
        slot.axes[..output.axes.len()].copy_from_slice(output.axes);
        let _ = self.outputs.push(slot);
        if let Some(writer) = self.writer.get() {
            writer.unpark();
        }
    }

    fn state(&self) -> LinkState {
        let PlcLink {
            is_up,
            is_stopped,
            connections,
            torn,
            refused,
        } = &*self.link;
        LinkState {
            is_up: is_up.load(Ordering::Relaxed),
            is_stopped: is_stopped.load(Ordering::Relaxed),
            connections: connections.load(Ordering::Relaxed),
            torn: torn.load(Ordering::Relaxed),
            refused: refused.load(Ordering::Relaxed),
        }
    }
}

impl Samples {
    /// Sends the sample that `fill` writes, which was there at `at`. A sample without room at the node is dropped: the node
    /// has stood still, and newer ones follow.
    pub(super) fn send<E>(
        &mut self,
        at: Instant<Machine>,
        fill: impl FnOnce(&mut PlcSample) -> Result<(), E>,
    ) -> Result<(), E> {
        // No buffer: the node stands still, or 64 samples came in one of its cycles.
        let Some(mut stamped) = self.spare.take().or_else(|| self.empty.pop().ok()) else {
            return Ok(());
        };
        stamped.at = at;
        if let Err(error) = fill(&mut stamped.sample) {
            // Kept here: only the node's end may push into the ring of empty ones.
            self.spare = Some(stamped);
            return Err(error);
        }
        let _ = self.full.push(stamped);
        Ok(())
    }
}

impl PlcOutputs {
    /// Registers this thread to be woken when there is an output.
    pub(super) fn attach(&self) {
        let _ = self.writer.set(std::thread::current());
    }

    /// Takes the oldest one into `slot`, or waits for a moment.
    pub(super) fn next_into(&mut self, slot: &mut OutputSlot) -> bool {
        if self.take(slot) {
            return true;
        }
        // Wakes by itself as well, since the flag of the end wakes nobody.
        std::thread::park_timeout(STOP_POLL);
        // Looked at again: the wake-up came with an output.
        self.take(slot)
    }

    /// Takes the newest one of each output into its slot; those before it are left out.
    pub(super) fn newest_into(&mut self, slots: &mut NewestSlots) {
        while self.take(&mut slots.spare) {
            let number = slots.spare.number;
            if let Some((slot, is_new)) = slots.newest.get_mut(number) {
                // The buffers change places: the older one is filled next.
                std::mem::swap(slot, &mut slots.spare);
                *is_new = true;
            }
        }
    }

    fn take(&mut self, slot: &mut OutputSlot) -> bool {
        let Ok(mut taken) = self.full.pop() else {
            return false;
        };
        std::mem::swap(slot, &mut taken);
        let _ = self.empty.push(taken);
        true
    }
}

impl OutputSlot {
    /// A place for any output of a config.
    pub(super) fn of(config: &GatewayConfig) -> Self {
        let axes = config.outputs.iter().map(|output| output.axes.len());
        Self {
            number: 0,
            index: CycleIndex(0),
            axes: vec![None; axes.max().unwrap_or(0)].into(),
        }
    }
}

/// The newest of each output.
pub(super) struct NewestSlots {
    newest: Vec<(OutputSlot, bool)>,
    spare: OutputSlot,
}

impl NewestSlots {
    pub(super) fn of(config: &GatewayConfig) -> Self {
        Self {
            newest: vec![(OutputSlot::of(config), false); config.outputs.len()],
            spare: OutputSlot::of(config),
        }
    }

    /// The slots that are new since they were taken.
    pub(super) fn take(&mut self) -> impl Iterator<Item = &OutputSlot> {
        let new = self.newest.iter_mut();
        new.filter_map(|(slot, is_new)| std::mem::take(is_new).then_some(&*slot))
    }
}
