//! The circle across nodes that an axis is in, as a node takes it before a scan.

use coaxle_slave::CircleState;
use serde::{Deserialize, Serialize};

use crate::channel::Channel;

/// The circle that an axis of a node is in from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CircleChange {
    /// Channel on which the node publishes the axis.
    pub channel: Channel,
    /// Axis id on that channel.
    pub id: u32,
    /// The circle.
    pub state: CircleState,
}

/// A change in a recorded scan.
#[derive(Serialize, Deserialize)]
pub(crate) struct CircleOnWire {
    /// Index in [`Channel::ALL`].
    channel: u8,
    id: u32,
    /// Index in [`STATES`].
    state: u8,
}

const STATES: [CircleState; 3] = [CircleState::None, CircleState::Open, CircleState::Closed];

impl From<&CircleChange> for CircleOnWire {
    fn from(change: &CircleChange) -> Self {
        let place = |place: Option<usize>| place.map_or(u8::MAX, |place| place as u8);
        let mut channels = Channel::ALL.iter();
        let mut states = STATES.iter();
        Self {
            channel: place(channels.position(|channel| *channel == change.channel)),
            id: change.id,
            state: place(states.position(|state| *state == change.state)),
        }
    }
}

impl CircleOnWire {
    /// The change; none if it names a channel or state that does not exist.
    pub(crate) fn change(&self) -> Option<CircleChange> {
        Some(CircleChange {
            channel: *Channel::ALL.get(usize::from(self.channel))?,
            id: self.id,
            state: *STATES.get(usize::from(self.state))?,
        })
    }
}
