//! Judges the messages of a node by the rules of docs/WIRE.md. Nothing here receives: messages are handed in with their
//! arrivals.

mod axes;
mod exchange;
mod frames;
mod pace;
mod presence;
pub(super) mod rules;
pub(super) mod runs;
mod stamps;
mod status;

use coaxle_clock::{CycleTime, Instant, Span};
use coaxle_host::network::transport::Delivery;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, TimeRequest};
use coaxle_os::Machine;

use crate::conform::rule::RuleFinding;
use axes::AxisChecks;
use exchange::ExchangeChecks;
use frames::FrameChecks;
use pace::PaceChecks;
use presence::PresenceChecks;
use rules::{SenderRule, Tallies};
use runs::{FramePlace, RunChecks};
use stamps::StampChecks;
use status::StatusChecks;

/// Sender of time requests to a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requester {
    /// Id of the requester.
    pub(super) id: u32,
    /// Run of the requester.
    pub(super) run: u64,
}

/// The clock of the node, as the newest frame shows it.
#[derive(Clone, Copy, Debug)]
struct FrameClock {
    epoch: u64,
    cycle_time: CycleTime,
    /// Departure, or due time, since the ideal start of the node's cycle 0 …
    left: Span,
    /// … and arrival.
    at: Instant<Machine>,
}

impl FrameClock {
    /// Time of the sender at an instant.
    fn time(&self, at: Instant<Machine>) -> Span {
        self.left + (at - self.at)
    }
}

/// State of all checks of a node.
#[derive(Debug)]
pub(super) struct SenderJudge {
    tallies: Tallies,
    frames: FrameChecks,
    runs: RunChecks,
    pace: PaceChecks,
    stamps: StampChecks,
    axes: AxisChecks,
    exchange: ExchangeChecks,
    status: StatusChecks,
    presence: PresenceChecks,
    clock: Option<FrameClock>,
}

impl SenderJudge {
    /// Judges a node that publishes its axes on this channel, listening since `since`.
    pub(super) fn new(
        node: &NodeName,
        channel: Channel,
        requester: Requester,
        since: Instant<Machine>,
    ) -> Self {
        Self {
            tallies: Tallies::default(),
            frames: FrameChecks::new(node, channel),
            runs: RunChecks::default(),
            pace: PaceChecks::default(),
            stamps: StampChecks::default(),
            axes: AxisChecks::default(),
            exchange: ExchangeChecks::new(node, requester),
            status: StatusChecks::new(node, since),
            presence: PresenceChecks::new(node),
            clock: None,
        }
    }

    /// Number of frames received, good or not.
    pub(super) const fn frames(&self) -> u64 {
        self.tallies.of(SenderRule::Version).all()
    }

    /// Takes a frame of axes.
    pub(super) fn frame(&mut self, at: Instant<Machine>, bytes: &[u8], delivery: Option<Delivery>) {
        let tallies = &mut self.tallies;
        presence::check_delivery(delivery, tallies);
        let Some((header, axes)) = self.frames.open(bytes, tallies) else {
            return;
        };
        if let Some(place) = self.runs.take(&header, tallies) {
            self.pace.take(at, &header, place);
            self.stamps.take(&header, place, tallies);
            let cycle = header.cycle_time.span();
            self.axes.take(&axes, cycle, place, tallies);
            self.note_clock(at, &header, place);
        }
    }

    /// Notes a time request of this tool; a node must refuse a bad one.
    pub(super) fn request_sent(
        &mut self,
        at: Instant<Machine>,
        request: TimeRequest,
        is_good: bool,
    ) {
        self.exchange.request_sent(at, request, is_good);
    }

    /// Takes a frame of time responses.
    pub(super) fn responses(
        &mut self,
        at: Instant<Machine>,
        bytes: &[u8],
        delivery: Option<Delivery>,
    ) {
        presence::check_delivery(delivery, &mut self.tallies);
        let clock = self.clock.as_ref();
        self.exchange.take(at, bytes, clock, &mut self.tallies);
    }

    /// Takes a status.
    pub(super) fn status(&mut self, at: Instant<Machine>, bytes: &[u8]) {
        let clock = self.clock.as_ref();
        self.status.take(at, bytes, clock, &mut self.tallies);
    }

    /// Takes the appearance or disappearance of a liveliness token.
    pub(super) fn token(&mut self, key: &str, is_there: bool) {
        self.presence.token(key, is_there);
    }

    /// A finding about each rule, in their order, at `end`.
    pub(super) fn findings(&self, end: Instant<Machine>) -> Vec<RuleFinding> {
        rules::findings(self, end)
    }

    fn note_clock(&mut self, at: Instant<Machine>, header: &FrameHeader, place: FramePlace) {
        let cycle = header.cycle_time.span();
        // A frame without a credible stamp left when it was due, as far as is known.
        let due = cycle * header.count as i64;
        let left = match place {
            FramePlace::Begins => None,
            FramePlace::Goes { .. } => self.stamps.left(),
        };
        self.clock = Some(FrameClock {
            epoch: header.epoch,
            cycle_time: header.cycle_time,
            left: left.filter(|left| *left >= due - cycle).unwrap_or(due),
            at,
        });
    }
}
