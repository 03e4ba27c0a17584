//! What a cycle took in of the followed clock, kept until the world fetches it or the next cycle
//! begins.

use std::collections::VecDeque;

use coaxle_clock::delay::Answer;
use coaxle_clock::{Instant, Local};
use coaxle_node::{Arrival, FrameHeader};

/// As many as one cycle can take in: a full inbox, and all responses that can wait.
const CAPACITY: usize = crate::inbox::CAPACITY + crate::delay::CAPACITY;

/// The arrivals of one cycle. It never grows.
#[derive(Debug)]
pub(crate) struct Arrivals(VecDeque<Arrival>);

impl Arrivals {
    pub(crate) fn new() -> Self {
        Self(VecDeque::with_capacity(CAPACITY))
    }

    /// A cycle begins: what nobody fetched is forgotten.
    pub(crate) fn begin(&mut self) {
        self.0.clear();
    }

    pub(crate) fn message(&mut self, at: Instant<Local>, header: &FrameHeader) {
        self.push(Arrival::Message(at, *header));
    }

    pub(crate) fn exchange(&mut self, at: Instant<Local>, answer: &Answer) {
        self.push(Arrival::Exchange(at, *answer));
    }

    /// The oldest that was not fetched yet.
    pub(crate) fn next(&mut self) -> Option<Arrival> {
        self.0.pop_front()
    }

    fn push(&mut self, arrival: Arrival) {
        if self.0.len() < CAPACITY {
            self.0.push_back(arrival);
        }
    }
}
