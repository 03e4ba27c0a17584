//! The part of a node that answers the beacons of those who follow it.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleTime, Instant, Local};

use crate::beacon::{BEACON_CAPACITY, BeaconRequest, BeaconResponseHeader, encode_beacon_response};
use crate::channel::Channel;
use crate::message::Outgoing;

/// Most beacons answered in one cycle.
pub const MAX_BEACONS: usize = 16;

/// Answers, in each cycle, the beacons that came before it, each by one of its own.
#[derive(Clone, Debug)]
pub struct BeaconServer {
    header: BeaconResponseHeader,
    start: Instant<Local>,
    waiting: [(Instant<Local>, BeaconRequest); MAX_BEACONS],
    count: usize,
    /// The newest cycle, and when it really began.
    cycle: (Instant<Local>, Instant<Local>),
    body: [u8; BEACON_CAPACITY],
    counters: BeaconServerCounters,
}

/// What became of the beacons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeaconServerCounters {
    /// Answered.
    pub answered: u64,
    /// Not answered: too many came in one cycle.
    pub dropped: u64,
    /// Refused before they got here.
    pub refused: u64,
}

impl BeaconServer {
    /// Answers as the node with the id `sender`, in its run `epoch`, whose cycle 0 is due at `start`.
    #[must_use]
    pub fn new(sender: u32, epoch: u64, start: Instant<Local>, cycle_time: CycleTime) -> Self {
        Self {
            header: BeaconResponseHeader {
                sender,
                epoch,
                count: 0,
                cycle_time,
            },
            start,
            waiting: [<_>::default(); MAX_BEACONS],
            count: 0,
            cycle: (start, start),
            body: [0; BEACON_CAPACITY],
            counters: BeaconServerCounters::default(),
        }
    }

    /// Stores a beacon that arrived at `at`. Of two of one node the newer one counts.
    pub fn receive(&mut self, at: Instant<Local>, request: &BeaconRequest) {
        let mut waiting = self.waiting[..self.count].iter_mut();
        let same = waiting.find(|(_, other)| other.requester == request.requester);
        if let Some(place) = same {
            *place = (at, *request);
            self.counters.dropped = self.counters.dropped.saturating_add(1);
        } else if let Some(place) = self.waiting.get_mut(self.count) {
            *place = (at, *request);
            self.count += 1;
        } else {
            self.counters.dropped = self.counters.dropped.saturating_add(1);
        }
    }

    /// Counts a beacon that was refused.
    pub fn reject(&mut self) {
        self.counters.refused = self.counters.refused.saturating_add(1);
    }

    /// The cycle `tick` really began at `now`: what had arrived by then is answered in it.
    pub fn respond(&mut self, tick: &Tick, now: Instant<Local>) {
        self.header.count = tick.count;
        self.cycle = (tick.ideal_start, now);
    }

    /// The next answer of the newest cycle, until there is none left.
    pub fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let (ideal_start, now) = self.cycle;
        let due = self.waiting[..self.count].iter();
        let place = due.clone().position(|(at, _)| *at <= now)?;
        let (at, request) = self.waiting[place];
        self.waiting.copy_within(place + 1..self.count, place);
        self.count -= 1;
        self.counters.answered = self.counters.answered.saturating_add(1);
        let received = at - self.start;
        let length = encode_beacon_response(&self.header, &request, received, &mut self.body);
        Some(Outgoing {
            channel: Channel::BeaconResponses,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }

    /// What became of the beacons so far.
    #[must_use]
    pub const fn counters(&self) -> BeaconServerCounters {
        self.counters
    }
}
