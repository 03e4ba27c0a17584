//! Messages to a node, and messages that it sends.

use coaxle_axis::motion_plan::{MotionPiece, PlanFault};
use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{Instant, Local, Span};
use coaxle_curve::profile::Limits;

use crate::beacon::{BeaconRequest, BeaconResponse};
use crate::channel::Channel;
use crate::exchange::TimeRequest;
use crate::frame::{AxisSample, Frame};
use crate::present_after::PresentAfter;
use crate::rejection::Rejection;

/// Event on a subscription of a node. One variant per kind of event, so that only the node counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message<'a> {
    /// Accepted frame, reduced to the axes that this node follows.
    Frame(Frame<'a>),
    /// Time request of another node for this node's clock.
    TimeRequest(TimeRequest),
    /// Response of the followed node to a request of this node.
    TimeResponse(TimeResponse),
    /// Beacon of a node that follows this one.
    BeaconRequest(BeaconRequest),
    /// Response of the followed node to a beacon of this node.
    BeaconResponse(BeaconResponse),
    /// Piece of the plan of an axis that this node follows.
    PlannedPiece(PlannedPiece),
    /// Plan of an axis that this node follows, refused on its way in.
    PlanRefused(PlanFault),
    /// Report of a follower about an axis of this node.
    FollowerReport(ReceivedReport),
    /// Frame that was refused on its way in.
    Rejected(Rejection),
}

/// A piece of the plan of a followed axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedPiece {
    /// Run of the sender.
    pub epoch: u64,
    /// The sender's cycle count when it made the plan.
    pub count: u64,
    /// Number of the axis among those that are followed, from 0.
    pub axis: u16,
    /// Number of the piece in its plan, from 0.
    pub number: u8,
    /// Number of pieces of the plan.
    pub of: u8,
    /// The instant until which the axis will not deviate from the plan.
    pub promised_until: Span,
    /// The piece.
    pub piece: MotionPiece,
}

/// Report about an axis of this node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceivedReport {
    /// Run of the follower.
    pub epoch: u64,
    /// The follower's cycle count when it made the report.
    pub count: u64,
    /// Run of this node that it follows.
    pub run: u64,
    /// Id of the axis.
    pub axis_id: u32,
    /// State of its slaves.
    pub state: FollowerState,
}

/// State of the slaves of a node that follow an axis of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowerState {
    /// Number of slaves.
    pub slaves: u16,
    /// Number of those that are in sync.
    pub in_sync: u16,
    /// Number of those in error.
    pub in_error: u16,
    /// Greatest distance of a slave in sync from the position of its coupling, u of the slave.
    pub distance: f64,
    /// Limits within which the axis leads all slaves that are not in error within theirs: in units of the axis.
    pub limits: Limits,
    /// Presentation delay with which the node would find the frames that it needs; none if it is unknown, or if the node shows the axis now.
    pub wanted_delay: Option<PresentAfter>,
}

impl<'a> Message<'a> {
    /// Splits off the axes, so that both parts can be kept in two places.
    #[must_use]
    pub const fn split(&self) -> (Message<'static>, &'a [Option<AxisSample>]) {
        match *self {
            Self::Frame(Frame { header, axes }) => {
                (Message::Frame(Frame { header, axes: &[] }), axes)
            }
            Self::TimeRequest(request) => (Message::TimeRequest(request), &[]),
            Self::TimeResponse(response) => (Message::TimeResponse(response), &[]),
            Self::BeaconRequest(request) => (Message::BeaconRequest(request), &[]),
            Self::BeaconResponse(response) => (Message::BeaconResponse(response), &[]),
            Self::PlannedPiece(piece) => (Message::PlannedPiece(piece), &[]),
            Self::PlanRefused(fault) => (Message::PlanRefused(fault), &[]),
            Self::FollowerReport(report) => (Message::FollowerReport(report), &[]),
            Self::Rejected(reason) => (Message::Rejected(reason), &[]),
        }
    }

    /// Returns the message with these axes, if it is a frame.
    #[must_use]
    pub const fn with_axes(self, axes: &'a [Option<AxisSample>]) -> Self {
        match self {
            Self::Frame(Frame { header, .. }) => Self::Frame(Frame { header, axes }),
            other => other,
        }
    }
}

/// Message that is kept, in a buffer that can be used again.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptMessage {
    message: Message<'static>,
    axes: Vec<Option<AxisSample>>,
}

impl KeptMessage {
    /// Keeps a message.
    #[must_use]
    pub fn new(message: &Message<'_>) -> Self {
        let (message, axes) = message.split();
        Self {
            message,
            axes: axes.to_vec(),
        }
    }

    /// Keeps another message instead.
    pub fn replace(&mut self, message: &Message<'_>) {
        let (message, axes) = message.split();
        self.message = message;
        self.axes.clear();
        self.axes.extend_from_slice(axes);
    }

    /// Returns the message.
    #[must_use]
    pub fn get(&self) -> Message<'_> {
        self.message.with_axes(&self.axes)
    }

    /// Axes of the message, to change them.
    pub fn axes_mut(&mut self) -> &mut [Option<AxisSample>] {
        &mut self.axes
    }
}

/// Frame to send, without its last two fields.
///
/// The send stamp is the departure of the message after `ideal_start`, so the sending thread appends it
/// (and the check sum) with [`crate::frame::seal`] at the last moment.
#[derive(Clone, Copy, Debug)]
pub struct Outgoing<'a> {
    /// Channel to publish on.
    pub channel: Channel,
    /// Far node that it goes to, by its index from 0 among the followed nodes; 0 for the node's own channels.
    pub far: usize,
    /// Ideal start of the cycle it belongs to, in this node's clock.
    pub ideal_start: Instant<Local>,
    /// Frame up to its send stamp.
    pub body: &'a [u8],
}
