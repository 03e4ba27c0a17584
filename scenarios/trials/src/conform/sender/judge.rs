//! Judges the messages of a node by the rules of docs/WIRE.md. Nothing here receives: messages are handed in with their
//! arrivals.

use coaxle_clock::Instant;
use coaxle_host::network::transport::Delivery;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, FrameHeader, TimeRequest};
use coaxle_os::Machine;

use super::axes::AxisChecks;
use super::exchange::{ExchangeChecks, FrameClock};
use super::frames::{FrameChecks, OpenedFrame};
use super::pace::PaceChecks;
use super::presence::PresenceChecks;
use super::runs::{FramePlace, RunChecks};
use super::stamps::StampChecks;
use super::status::StatusChecks;
use crate::conform::rule::RuleFinding;

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
pub(super) struct SenderJudge {
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
            frames: FrameChecks::new(node, channel),
            runs: RunChecks::default(),
            pace: PaceChecks::default(),
            stamps: StampChecks::default(),
            axes: AxisChecks::default(),
            exchange: ExchangeChecks::new(node, requester.id, requester.run),
            status: StatusChecks::new(node, since),
            presence: PresenceChecks::new(node),
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
            OpenedFrame::Good(header, axes) => {
                if let Some(step) = self.runs.take(&header) {
                    self.pace.take(at, &header, step);
                    self.stamps.take(&header, step);
                    self.axes.take(&axes, header.cycle_time.span(), step);
                    self.note(at, &header, step);
                }
            }
            OpenedFrame::CycleTime(nanos) => {
                let nanos = nanos.map_or("another one".to_owned(), |ns| format!("{ns} ns"));
                self.runs.cycle_time_out_of_range(nanos);
            }
            OpenedFrame::Other => {}
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
    pub(super) fn findings(&self, end: Instant<Machine>) -> Vec<RuleFinding> {
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
            self.frames.present_after(),
        ]
        .concat()
    }

    fn note(&mut self, at: Instant<Machine>, header: &FrameHeader, step: FramePlace) {
        // A frame without a credible stamp left when it was due, as far as is known.
        let due = header.cycle_time.span() * header.count as i64;
        let left = match step {
            FramePlace::Begins => None,
            FramePlace::Goes { .. } => self.stamps.left(),
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
