//! Judges the messages of a node by the rules of docs/WIRE.md. Nothing here receives: messages are handed in with their
//! arrivals.

use coaxle_clock::Instant;
use coaxle_host::transport::Delivery;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, TimeRequest};
use coaxle_os::Machine;

use super::axes::Axes;
use super::exchange::{Exchange, FrameClock};
use super::frames::{Frames, Opened};
use super::pace::Pace;
use super::presence::Presence;
use super::runs::{Runs, Step};
use super::stamps::Stamps;
use super::status::Status;
use crate::conform::rule::Finding;

/// Sender of time requests to a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Requester {
    /// Id of the requester.
    pub(super) id: u32,
    /// Run of the requester.
    pub(super) run: u64,
}

/// State of all checks of a node.
#[derive(Debug)]
pub(super) struct Judge {
    frames: Frames,
    runs: Runs,
    pace: Pace,
    stamps: Stamps,
    axes: Axes,
    exchange: Exchange,
    status: Status,
    presence: Presence,
    clock: Option<FrameClock>,
}

impl Judge {
    /// Judges a node that publishes its axes on this channel, listening since `since`.
    pub(super) fn new(
        node: &NodeName,
        channel: Channel,
        requester: Requester,
        since: Instant<Machine>,
    ) -> Self {
        Self {
            frames: Frames::new(node, channel),
            runs: Runs::default(),
            pace: Pace::default(),
            stamps: Stamps::default(),
            axes: Axes::default(),
            exchange: Exchange::new(node, requester.id, requester.run),
            status: Status::new(node, since),
            presence: Presence::new(node),
            clock: None,
        }
    }

    /// Number of frames received, good or not.
    pub(super) const fn frames(&self) -> u64 {
        self.frames.all()
    }

    /// Takes a frame of axes.
    pub(super) fn frame(&mut self, at: Instant<Machine>, bytes: &[u8], delivery: Option<Delivery>) {
        self.presence.delivery(delivery);
        match self.frames.open(bytes) {
            Opened::Good(header, axes) => {
                if let Some(step) = self.runs.take(&header) {
                    self.pace.take(at, &header, step);
                    self.stamps.take(&header, step);
                    self.axes.take(&axes, header.cycle_time.span(), step);
                    self.note(at, &header, step);
                }
            }
            Opened::CycleTime(nanos) => {
                let nanos = nanos.map_or("another one".to_owned(), |ns| format!("{ns} ns"));
                self.runs.cycle_time_out_of_range(nanos);
            }
            Opened::Other => {}
        }
    }

    /// Notes a time request of this tool; a node must refuse a bad one.
    pub(super) fn asked(&mut self, at: Instant<Machine>, request: TimeRequest, is_good: bool) {
        self.exchange.asked(at, request, is_good);
    }

    /// Takes a frame of time responses.
    pub(super) fn responses(
        &mut self,
        at: Instant<Machine>,
        bytes: &[u8],
        delivery: Option<Delivery>,
    ) {
        self.presence.delivery(delivery);
        self.exchange.take(at, bytes, self.clock.as_ref());
    }

    /// Takes a status.
    pub(super) fn status(&mut self, at: Instant<Machine>, bytes: &[u8]) {
        self.status.take(at, bytes, self.clock.as_ref());
    }

    /// Takes the appearance or disappearance of a liveliness token.
    pub(super) fn token(&mut self, key: &str, is_there: bool) {
        self.presence.token(key, is_there);
    }

    /// A finding about each rule, in their order, at `end`.
    pub(super) fn findings(&self, end: Instant<Machine>) -> Vec<Finding> {
        let epoch = self.clock.map(|clock| clock.epoch);
        [
            self.frames.findings(),
            self.runs.findings(),
            self.pace.findings(),
            self.stamps.findings(),
            self.axes.findings(),
            self.exchange.findings(end),
            self.status.findings(end),
            self.presence.findings(epoch),
        ]
        .concat()
    }

    fn note(&mut self, at: Instant<Machine>, header: &FrameHeader, step: Step) {
        // A frame without a credible stamp left when it was due, as far as is known.
        let due = header.cycle_time.span() * header.count as i64;
        let left = match step {
            Step::Begins => None,
            Step::Goes { .. } => self.stamps.left(),
        };
        self.clock = Some(FrameClock {
            epoch: header.epoch,
            cycle_time: header.cycle_time,
            left: left
                .filter(|left| *left >= due - header.cycle_time.span())
                .unwrap_or(due),
            at,
        });
    }
}
