//! Cost of a size.

use coaxle_clock::Span;
use coaxle_os::{Os, System};
use serde::{Deserialize, Serialize};

use super::lockstep::{CycleTimes, Lockstep};
use super::size::Size;

/// Cost of a size.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Cost {
    #[serde(flatten)]
    pub(super) size: Size,
    /// Nodes.
    pub(super) nodes: usize,
    /// Far axes of all receivers, and slaves.
    pub(super) axes: usize,
    /// A cycle of all senders, µs.
    pub(super) senders_us: f64,
    /// Messages of all nodes in a cycle, read and taken in, µs.
    pub(super) intake_us: f64,
    /// A scan of all receivers, µs.
    pub(super) receivers_us: f64,
    /// Memory of all nodes, bytes; absent where the system does not report it.
    pub(super) memory_bytes: Option<u64>,
    /// Messages that are published in a cycle, and that come to a node.
    pub(super) published_per_cycle: f64,
    pub(super) delivered_per_cycle: f64,
}

/// Cycles until clocks are known and slaves coupled.
const UNTIL_SYNCED: usize = 3_000;
/// Cycles that are measured together, and how often: the fastest counts, as other load only adds to it.
// 25 cycles of 100 axes take half a millisecond: most batches end before another process gets the processor.
const BATCH: usize = 25;
const BATCHES: usize = 200;

impl Cost {
    /// Measures a size, in a process of its own.
    ///
    /// # Errors
    /// A node that cannot be built.
    pub(super) fn of(size: Size) -> anyhow::Result<Self> {
        let before = memory();
        let mut lockstep = Lockstep::new(size)?;
        for _ in 0..UNTIL_SYNCED {
            lockstep.cycle();
        }
        // Before the batches: by now everything is allocated, and a cycle allocates nothing.
        let after = memory();
        let messages = [lockstep.published, lockstep.delivered];
        let best = (0..BATCHES).map(|_| batch(&mut lockstep));
        // By the sum: the fastest parts of different batches would not belong together.
        let best = best.min_by_key(|took| took.all()).unwrap_or_default();
        let cycles = (BATCH * BATCHES) as f64;
        let micros = |span: Span| span.as_micros_f64() / BATCH as f64;
        Ok(Self {
            size,
            nodes: size.axes_of_senders().len() + size.receivers(),
            axes: size.axes(),
            senders_us: micros(best.senders),
            intake_us: micros(best.intake),
            receivers_us: micros(best.receivers),
            memory_bytes: before
                .zip(after)
                // The system may have taken pages back meanwhile.
                .map(|(before, after)| after.saturating_sub(before)),
            published_per_cycle: (lockstep.published - messages[0]) as f64 / cycles,
            delivered_per_cycle: (lockstep.delivered - messages[1]) as f64 / cycles,
        })
    }

    /// Processor time of a cycle of all nodes, µs.
    pub(super) fn cycle_us(&self) -> f64 {
        self.senders_us + self.intake_us + self.receivers_us
    }

    /// Processor time of a cycle for each axis, µs.
    pub(super) fn per_axis_us(&self) -> f64 {
        self.cycle_us() / self.axes as f64
    }

    /// Cost of each axis beyond the first of its nodes, µs, if the fixed part costs as much as in `first`.
    pub(super) fn further_axis_us(&self, first: &Self) -> Option<f64> {
        let more = self.further_axes(first)?;
        Some((self.cycle_us() - self.times(first) * first.cycle_us()) / more)
    }

    /// Memory of each axis more than in `first`, bytes, with its share of its nodes: most of a process's memory does not
    /// belong to the axes.
    pub(super) fn further_axis_bytes(&self, first: &Self) -> Option<f64> {
        let more = self.axes.checked_sub(first.axes).filter(|more| *more > 0)?;
        let (memory, first_memory) = (self.memory_bytes?, first.memory_bytes?);
        Some((memory as f64 - first_memory as f64) / more as f64)
    }

    fn further_axes(&self, first: &Self) -> Option<f64> {
        let more = self.axes as f64 - self.times(first) * first.axes as f64;
        // The smallest size itself has no further axis.
        (more > 0.0).then_some(more)
    }

    /// Number of nodes in multiples of `first`: the factor of the fixed costs in the series of axes.
    fn times(&self, first: &Self) -> f64 {
        self.nodes as f64 / first.nodes as f64
    }
}

fn batch(lockstep: &mut Lockstep) -> CycleTimes {
    let mut sum = CycleTimes::default();
    for _ in 0..BATCH {
        sum += lockstep.cycle();
    }
    sum
}

/// Memory of this process.
fn memory() -> Option<u64> {
    Os::resident_memory(std::process::id())
}
