//! What comes to a node, and what goes out from it.

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{Instant, Local};

use crate::beacon::{BeaconRequest, BeaconResponse};
use crate::channel::Channel;
use crate::exchange::TimeRequest;
use crate::frame::{AxisSample, Frame};
use crate::rejection::Rejection;

/// What a node is told about its subscriptions. One variant per kind of event, so that the node is
/// the only place that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message<'a> {
    /// An accepted frame, reduced to the axes that this node follows.
    Frame(Frame<'a>),
    /// Somebody asks what this node's clock shows.
    TimeRequest(TimeRequest),
    /// The followed node responds to a request of this node.
    TimeResponse(TimeResponse),
    /// A beacon of a node that follows this one.
    BeaconRequest(BeaconRequest),
    /// The followed node answers a beacon of this node.
    BeaconResponse(BeaconResponse),
    /// A frame that was refused before it got here.
    Rejected(Rejection),
}

impl<'a> Message<'a> {
    /// The message without its axes, and these: so it can be kept in two places.
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
            Self::Rejected(reason) => (Message::Rejected(reason), &[]),
        }
    }

    /// The message with these axes, if it is a frame.
    #[must_use]
    pub const fn with_axes(self, axes: &'a [Option<AxisSample>]) -> Self {
        match self {
            Self::Frame(Frame { header, .. }) => Self::Frame(Frame { header, axes }),
            other => other,
        }
    }
}

/// A message that is kept, in a buffer that can be used again.
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

    /// The message.
    #[must_use]
    pub fn get(&self) -> Message<'_> {
        self.message.with_axes(&self.axes)
    }

    /// Its axes, to change them.
    pub fn axes_mut(&mut self) -> &mut [Option<AxisSample>] {
        &mut self.axes
    }
}

/// A frame to send, but for its last two fields.
///
/// The send stamp says how long after `ideal_start` the message really left, so whoever sends it
/// appends that (and the check sum) with [`crate::frame::seal`] at the last moment.
#[derive(Clone, Copy, Debug)]
pub struct Outgoing<'a> {
    /// Where it goes.
    pub channel: Channel,
    /// Which of the nodes that this one follows it goes to, counted from 0; 0 for its own channels.
    pub far: usize,
    /// The ideal start of the cycle it belongs to, in this node's clock.
    pub ideal_start: Instant<Local>,
    /// The frame up to its send stamp.
    pub body: &'a [u8],
}
