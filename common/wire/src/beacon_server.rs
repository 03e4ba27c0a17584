//! The part of a node that responds to the beacons of its followers.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleTime, Instant, Local};

use crate::beacon::{BEACON_CAPACITY, BeaconRequest, BeaconResponseHeader, encode_beacon_response};
use crate::channel::Channel;
use crate::message::Outgoing;

/// Greatest number of beacons responded to in one cycle.
pub const MAX_BEACONS: usize = 16;

/// Responds in each cycle to the beacons received before it, each by a beacon of its own.
#[derive(Clone, Debug)]
pub struct BeaconServer {
    header: BeaconResponseHeader,
    start: Instant<Local>,
    waiting: [(Instant<Local>, BeaconRequest); MAX_BEACONS],
    count: usize,
    /// Newest cycle, and its real start.
    cycle: (Instant<Local>, Instant<Local>),
    body: [u8; BEACON_CAPACITY],
    counters: BeaconServerCounters,
}

/// Counters of the beacons by result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeaconServerCounters {
    /// Beacons responded to.
    pub answered: u64,
    /// Beacons dropped: too many arrived in one cycle.
    pub dropped: u64,
    /// Beacons refused before they reached the server.
    pub refused: u64,
}

impl BeaconServer {
    /// Responds as the node with the id `sender`, in its run `epoch`, whose cycle 0 is due at `start`.
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

    /// Moves its cycle 0, and with it all cycles, to those that a lock has moved.
    pub fn set_start(&mut self, start: Instant<Local>) {
        self.start = start;
    }

    /// Stores a beacon that arrived at `at`. It replaces an older one of the same node.
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

    /// Responds in the cycle `tick`, which really began at `now`, to the beacons that had arrived by
    /// then.
    pub fn respond(&mut self, tick: &Tick, now: Instant<Local>) {
        self.header.count = tick.count;
        self.cycle = (tick.ideal_start, now);
    }

    /// Returns the next response of the newest cycle, until there is none left.
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

    /// Counters of the beacons so far.
    #[must_use]
    pub const fn counters(&self) -> BeaconServerCounters {
        self.counters
    }
}
