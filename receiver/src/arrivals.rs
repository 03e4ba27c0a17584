//! Measurements of the followed clocks taken in by a cycle, kept until they are fetched or the next
//! cycle begins.

use std::collections::VecDeque;

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::RESPONSES;
use coaxle_clock::{Instant, Local};
use coaxle_node::{Arrival, Arrived, FrameHeader};

/// Capacity for waiting messages: more than a second's worth at a millisecond.
pub(crate) const INBOX_CAPACITY: usize = 1024;
/// Most arrivals that one cycle can take in of one node: a full inbox, and all waiting responses.
const CAPACITY: usize = INBOX_CAPACITY + RESPONSES;

/// The arrivals of one cycle. It never grows.
#[derive(Debug)]
pub(crate) struct ArrivalLog(VecDeque<Arrival>);

/// The log with the number of the far node that writes to it.
pub(crate) struct Arrivals<'a> {
    log: &'a mut VecDeque<Arrival>,
    far: usize,
}

impl ArrivalLog {
    /// Creates a log for this number of far nodes.
    pub(crate) fn new(far_nodes: usize) -> Self {
        // At the start, for the worst cycle of all nodes at once: the cycles never allocate.
        Self(VecDeque::with_capacity(far_nodes * CAPACITY))
    }

    /// Begins a cycle: arrivals that were not fetched are discarded.
    pub(crate) fn begin(&mut self) {
        // Keeps its memory.
        self.0.clear();
    }

    /// The log for the far node with this number.
    pub(crate) const fn of(&mut self, far: usize) -> Arrivals<'_> {
        Arrivals {
            log: &mut self.0,
            far,
        }
    }

    /// Takes the oldest arrival.
    pub(crate) fn next(&mut self) -> Option<Arrival> {
        self.0.pop_front()
    }
}

impl Arrivals<'_> {
    pub(crate) fn message(&mut self, at: Instant<Local>, header: &FrameHeader) {
        self.push(at, Arrived::Message(*header));
    }

    pub(crate) fn exchange(&mut self, at: Instant<Local>, response: &TimeResponse) {
        self.push(at, Arrived::Exchange(*response));
    }

    fn push(&mut self, at: Instant<Local>, what: Arrived) {
        // A full log loses arrivals rather than allocate: it serves recordings only.
        if self.log.len() < self.log.capacity() {
            let far = self.far;
            self.log.push_back(Arrival { far, at, what });
        }
    }
}
