//! The part of a node that responds to time requests.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleTime, Instant, Local};

use crate::channel::Channel;
use crate::exchange::{
    MAX_TIME_RESPONSES, ReceivedRequest, TIME_RESPONSES_CAPACITY, TimeRequest, TimeResponsesHeader,
    encode_time_responses,
};
use crate::message::Outgoing;

/// Responds in each cycle to the requests received before it, all in one frame.
#[derive(Clone, Debug)]
pub struct TimeServer {
    sender: u32,
    epoch: u64,
    start: Instant<Local>,
    cycle_time: CycleTime,
    waiting: [(Instant<Local>, TimeRequest); MAX_TIME_RESPONSES],
    count: usize,
    body: [u8; TIME_RESPONSES_CAPACITY],
    /// Length of the body that waits to be sent, and the cycle it belongs to.
    pending: Option<(usize, Instant<Local>)>,
    counters: TimeServerCounters,
}

/// Counters of the requests by result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeServerCounters {
    /// Requests responded to.
    pub answered: u64,
    /// Requests dropped: too many arrived in one cycle.
    pub dropped: u64,
}

impl TimeServer {
    /// Responds as the node with the id `sender`, in its run `epoch`, whose cycle 0 is due at `start`.
    #[must_use]
    pub fn new(sender: u32, epoch: u64, start: Instant<Local>, cycle_time: CycleTime) -> Self {
        Self {
            sender,
            epoch,
            start,
            cycle_time,
            waiting: [<_>::default(); MAX_TIME_RESPONSES],
            count: 0,
            body: [0; TIME_RESPONSES_CAPACITY],
            pending: None,
            counters: TimeServerCounters::default(),
        }
    }

    /// Moves its cycle 0, and with it all cycles, to those that a lock has moved.
    pub fn set_start(&mut self, start: Instant<Local>) {
        self.start = start;
    }

    /// Stores a request that arrived at `at`.
    pub fn receive(&mut self, at: Instant<Local>, request: &TimeRequest) {
        if let Some(place) = self.waiting.get_mut(self.count) {
            *place = (at, *request);
            self.count += 1;
        } else {
            self.counters.dropped = self.counters.dropped.saturating_add(1);
        }
    }

    /// Responds in the cycle `tick`, which really began at `now`, to what had arrived by then.
    pub fn respond(&mut self, tick: &Tick, now: Instant<Local>) {
        let mut replies = [ReceivedRequest::default(); MAX_TIME_RESPONSES];
        let (mut answered, mut kept) = (0, 0);
        for n in 0..self.count {
            let (at, request) = self.waiting[n];
            if at <= now {
                let received = at - self.start;
                replies[answered] = ReceivedRequest { request, received };
                answered += 1;
            } else {
                self.waiting[kept] = self.waiting[n];
                kept += 1;
            }
        }
        self.count = kept;
        self.counters.answered = self.counters.answered.saturating_add(answered as u64);
        self.pending = (answered > 0).then(|| {
            let header = TimeResponsesHeader {
                sender: self.sender,
                epoch: self.epoch,
                count: tick.count,
                cycle_time: self.cycle_time,
            };
            let length = encode_time_responses(&header, &replies[..answered], &mut self.body);
            (length, tick.ideal_start)
        });
    }

    /// Returns the responses of the newest cycle, once.
    pub fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let (length, ideal_start) = self.pending.take()?;
        Some(Outgoing {
            channel: Channel::TimeResponses,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }

    /// Counters of the requests so far.
    #[must_use]
    pub const fn counters(&self) -> TimeServerCounters {
        self.counters
    }
}
