//! What a cycle took in of the followed clocks, kept until the world fetches it or the next cycle
//! begins.

use std::collections::VecDeque;

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::RESPONSES;
use coaxle_clock::{Instant, Local};
use coaxle_node::{Arrival, Arrived, FrameHeader};

/// Messages that can wait: more than a second's worth at a millisecond.
pub(crate) const INBOX_CAPACITY: usize = 1024;
/// As many as one cycle can take in of one node: a full inbox, and all responses that can wait.
const CAPACITY: usize = INBOX_CAPACITY + RESPONSES;

/// The arrivals of one cycle. It never grows.
#[derive(Debug)]
pub(crate) struct ArrivalLog(VecDeque<Arrival>);

/// The same for one far node to write in.
pub(crate) struct Arrivals<'a> {
    log: &'a mut VecDeque<Arrival>,
    far: usize,
}

impl ArrivalLog {
    /// A log for so many far nodes.
    pub(crate) fn new(far_nodes: usize) -> Self {
        Self(VecDeque::with_capacity(far_nodes * CAPACITY))
    }

    /// A cycle begins: what nobody fetched is forgotten.
    pub(crate) fn begin(&mut self) {
        self.0.clear();
    }

    /// For the far node with this number to write in.
    pub(crate) const fn of(&mut self, far: usize) -> Arrivals<'_> {
        Arrivals {
            log: &mut self.0,
            far,
        }
    }

    /// The oldest that was not fetched yet.
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
        if self.log.len() < self.log.capacity() {
            let far = self.far;
            self.log.push_back(Arrival { far, at, what });
        }
    }
}
