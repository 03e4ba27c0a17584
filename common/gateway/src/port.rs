//! Between the node and the PLC: what comes out of it and goes in.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{CycleIndex, Instant, Local};

/// The axes of a PLC in one of its cycles.
#[derive(Clone, Debug, PartialEq)]
pub struct PlcSample {
    /// When they were there, in the node's clock.
    pub at: Instant<Local>,
    /// Of which cycle they are.
    pub index: CycleIndex,
    /// Over which connection they came: after another one nothing is known of how the PLC went on.
    pub connection: u32,
    /// The axes, in the order of the config.
    pub axes: Box<[NcToPlcAxis]>,
}

impl PlcSample {
    /// Room for the samples of so many axes.
    #[must_use]
    pub fn of_axes(axes: usize) -> Self {
        Self {
            at: Instant::EPOCH,
            index: CycleIndex(0),
            connection: 0,
            axes: vec![NcToPlcAxis::default(); axes].into(),
        }
    }

    /// Takes over another sample of as many axes; does not allocate.
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
    /// Which output of the config it is, from 0.
    pub number: usize,
    /// The receiver's cycle index.
    pub index: CycleIndex,
    /// The axes, in the order of the config. None that the receiver did not send, or nothing that can be believed.
    pub axes: &'a [Option<NcToPlcAxis>],
}

/// How it stands with a PLC.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkState {
    /// It is there, as far as is known.
    pub is_up: bool,
    /// It says of itself that its runtime is not in run.
    pub is_stopped: bool,
    /// How often it came, from 1 on: each time may be another run of it.
    pub connections: u32,
    /// Samples left out because parts of them were of different cycles.
    pub torn: u64,
    /// What came and was no sample.
    pub refused: u64,
}

/// The way to a PLC. Nothing in it allocates, locks, logs or waits.
pub trait Port {
    /// The next sample that has come, into `sample`; false if there is none. `now` is the ideal start of the cycle that asks.
    fn take(&mut self, now: Instant<Local>, sample: &mut PlcSample) -> bool;

    /// Hands axes to the PLC; what has no room is dropped.
    fn give(&mut self, output: &PlcOutput<'_>);

    /// How it stands with the PLC.
    fn state(&self) -> LinkState;
}
