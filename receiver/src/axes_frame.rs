//! A frame of axes that the node publishes once per cycle.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::{Instant, Local};
use coaxle_node::frame::{body_capacity, encode_body};
use coaxle_node::{Channel, FrameHeader, Outgoing};

/// A frame of axes that the node publishes once per cycle.
#[derive(Debug)]
pub(crate) struct AxesFrame {
    pub(crate) channel: Channel,
    body: Vec<u8>,
    /// Bytes of `body` that wait to be sent.
    pub(crate) pending: Option<usize>,
    pub(crate) is_subscribed: bool,
}

impl AxesFrame {
    /// Creates a frame for this number of axes.
    pub(crate) fn new(channel: Channel, axes: usize) -> Self {
        Self {
            channel,
            body: vec![0; body_capacity(axes)],
            pending: None,
            // Until the host knows better: a frame without subscribers costs little, a missing one an error stop
            // elsewhere.
            is_subscribed: true,
        }
    }

    /// Encodes the frame of this cycle, if there are axes and subscribers.
    pub(crate) fn encode<'a>(
        &mut self,
        header: &FrameHeader,
        axes: impl FnOnce() -> &'a [NcToPlcAxis],
    ) {
        self.pending = match self.is_subscribed.then(axes) {
            None | Some([]) => None,
            // The body has room for a frame of all axes, so that encoding cannot fail.
            Some(axes) => encode_body(header, axes, &mut self.body).ok(),
        };
    }

    /// Takes the pending frame, once.
    pub(crate) fn take(&mut self, ideal_start: Instant<Local>) -> Option<Outgoing<'_>> {
        let length = self.pending.take()?;
        Some(Outgoing {
            channel: self.channel,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }
}
