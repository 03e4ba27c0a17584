//! Interface between the node and the PLC.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, Instant, Local};

/// The axes of a PLC in one of its cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct PlcSample {
    /// Time of the sample, in the node's clock.
    pub at: Instant<Local>,
    /// Index of their cycle.
    pub index: CycleIndex,
    /// Number of the connection: the PLC's count is unknown after a new one.
    pub connection: u32,
    /// The axes, in the order of the config.
    pub axes: Box<[NcToPlcAxis]>,
}

impl PlcSample {
    /// Allocates a sample of this number of axes.
    #[must_use]
    pub fn of_axes(axes: usize) -> Self {
        Self {
            at: Instant::EPOCH,
            index: CycleIndex(0),
            connection: 0,
            axes: vec![NcToPlcAxis::default(); axes].into(),
        }
    }

    /// Copies another sample with an equal number of axes; does not allocate.
    pub fn replace(&mut self, other: &Self) {
        self.at = other.at;
        self.index = other.index;
        self.connection = other.connection;
        self.axes.copy_from_slice(&other.axes);
    }
}

/// The axes of a receiver in one of its cycles, on their way to the PLC.
#[derive(Clone, Copy, Debug)]
pub struct PlcOutput<'a> {
    /// Number of the output in the config, from 0.
    pub number: usize,
    /// The receiver's cycle index.
    pub index: CycleIndex,
    /// The axes, in the order of the config; none for one that the receiver did not send, or without
    /// plausible values.
    pub axes: &'a [Option<NcToPlcAxis>],
}

/// State of the connection to a PLC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkState {
    /// The PLC is connected, as far as is known.
    pub is_up: bool,
    /// The PLC reports that its runtime is not in run.
    pub is_stopped: bool,
    /// Number of connections, from 1 on: each may be another run of the PLC.
    pub connections: u32,
    /// Samples dropped because their parts were of different cycles.
    pub torn: u64,
    /// Number of invalid messages.
    pub refused: u64,
}

/// The connection to a PLC. Nothing in it allocates, locks, logs or waits.
pub trait Port {
    /// Takes the next sample that has arrived, into `sample`; false if there is none. `now` is the ideal
    /// start of the current cycle.
    fn receive(&mut self, now: Instant<Local>, sample: &mut PlcSample) -> bool;

    /// Passes axes to the PLC; axes without room in the queue are dropped.
    fn send(&mut self, output: &PlcOutput<'_>);

    /// Returns the state of the connection to the PLC.
    fn state(&self) -> LinkState;
}
