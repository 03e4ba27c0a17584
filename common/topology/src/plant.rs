//! Nodes as their configs, or their statuses, describe them.

use coaxle_axis::Modulo;
use coaxle_clock::{CycleTime, Span};
use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::config::{PresentAfterRange, Unit};
use coaxle_node::keys::NodeName;
use serde::{Deserialize, Serialize};

use crate::way::WaySource;

/// A node with its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantNode {
    /// File of its config, for findings; of a running node, its status.
    pub file: String,
    /// The node's name.
    pub name: NodeName,
    /// Kind of node.
    pub role: PlantRole,
    /// Cycle time of its frames, where it is known.
    pub cycle_time: Option<CycleTime>,
    /// Axes that it has, in any order.
    pub axes: Vec<PlantAxis>,
    /// False if it may publish further axes: a status shows some of a sender's only.
    pub is_complete: bool,
    /// Measured hold-back of its slaves; none where it is to be computed.
    pub hold_back: Option<Span>,
}

/// Kind of node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlantRole {
    /// Publishes axes of its own.
    Sender,
    /// Follows axes of others.
    Receiver,
    /// Stands for a PLC.
    Gateway,
    /// A running node that does not say.
    #[serde(other)]
    Unknown,
}

impl PlantRole {
    /// Returns its word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sender => "sender",
            Self::Receiver => "receiver",
            Self::Gateway => "gateway",
            Self::Unknown => "unknown",
        }
    }
}

/// An axis of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantAxis {
    /// Name in its node.
    pub name: String,
    /// Place in the file: `slave[0]`.
    pub field: String,
    /// Channel and id under which others can follow it.
    pub published: Option<(Channel, u32)>,
    /// Stated unit; none where it follows from elsewhere, or is unknown.
    pub unit: Option<Unit>,
    /// Stated length of its modulo period.
    pub modulo: Option<Modulo>,
    /// Limits that its motion keeps.
    pub limits: Option<StatedLimits>,
    /// Origin of its motion.
    pub origin: AxisOrigin,
}

/// Limits of a motion, in units of the axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatedLimits {
    /// Greatest speed, u/s.
    pub velocity: f64,
    /// Greatest acceleration, u/s².
    pub acceleration: f64,
    /// Greatest deceleration, u/s².
    pub deceleration: f64,
    /// Greatest jerk, u/s³; none without a limit.
    pub jerk: Option<f64>,
}

/// Origin of an axis's motion.
#[derive(Clone, Debug, PartialEq)]
pub enum AxisOrigin {
    /// The axis is the root of a motion.
    Root {
        /// Source of the motion.
        motion: RootMotion,
        /// Time after its generation at which it is shown: one, or what its followers decide.
        present_after: Option<PresentAfterRange>,
        /// Nodes that it waits for and stops with.
        followers: Vec<NodeName>,
    },
    /// The axis follows one of another node.
    Far(FarReference),
    /// The axis is coupled to axes of its own node: their indices.
    Slave {
        /// Masters, the first one first.
        masters: Vec<usize>,
    },
    /// The axis is written into a PLC as received.
    Output(FarReference),
}

/// Source of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RootMotion {
    /// Calculated ahead: a program.
    Program,
    /// Measured by an encoder.
    Encoder,
    /// Recorded before.
    Replay,
    /// From a PLC.
    Plc,
    /// Unknown, of a running node that does not say.
    Unknown,
}

impl RootMotion {
    /// True if its motion is known before it happens, so that it may be shown later at no loss.
    #[must_use]
    pub const fn is_generated(self) -> bool {
        matches!(self, Self::Program)
    }

    /// Returns its word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Program => "program",
            Self::Encoder => "encoder",
            Self::Replay => "replay",
            Self::Plc => "PLC",
            Self::Unknown => "axis",
        }
    }
}

/// Reference to an axis of another node.
#[derive(Clone, Debug, PartialEq)]
pub struct FarReference {
    /// Place in the file of what is common to all axes of that node: `far[0]`.
    pub field: String,
    /// Followed axis, then the same axis of each standby.
    pub sources: Vec<AxisAddress>,
    /// Source of the delay of its messages.
    pub way: WaySource,
    /// Instant that is shown.
    pub showing: Showing,
    /// Values of a running node.
    pub measured: Option<MeasuredStage>,
}

/// Values that a running node measures of an axis that it follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasuredStage {
    /// Delay that the frames state; zero without one.
    pub present_after: Span,
    /// Part of it that the node waits for.
    pub lag: Option<Span>,
}

/// Figures that a receiver measures of a far node, as far as they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeasuredWay {
    /// Delay of its messages.
    pub delay: Option<Span>,
    /// Presentation delay that would do.
    pub needed: Option<Span>,
    /// Presentation delay that its frames state.
    pub present_after: Option<Span>,
    /// Lag of its axes.
    pub lag: Option<Span>,
}

impl FarReference {
    /// Replaces what a config says by what its receiver measures.
    pub fn measure(&mut self, measured: &MeasuredWay) {
        if let Some(delay) = measured.delay {
            self.way = WaySource::Measured {
                delay,
                needed: measured.needed,
            };
        }
        self.measured = Some(MeasuredStage {
            present_after: measured.present_after.unwrap_or_default(),
            lag: measured.lag,
        });
        // A receiver that shows the newest values has no lag.
        if self.showing != Showing::AsReceived && measured.lag.is_none() {
            self.showing = Showing::Now;
        }
    }
}

/// Instant of a far axis that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Showing {
    /// As much later as its frames say, with this lag.
    Later(LagRule),
    /// The newest values moved to now.
    Now,
    /// The newest values as they are.
    AsReceived,
}

/// Rule for the lag of an axis that is shown later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LagRule {
    /// All of the delay: nothing is left for followers.
    Full,
    /// As much as the way needs.
    Auto,
    /// As stated.
    Fixed(Span),
}

impl LagRule {
    /// Returns the lag of `delay`, given the time that the way asks for; none if that is needed and unknown.
    pub(crate) fn lag(self, delay: Span, asked: Option<Span>) -> Option<Span> {
        match self {
            Self::Full => Some(delay),
            Self::Auto => Some(asked?.min(delay)),
            Self::Fixed(lag) => Some(lag.min(delay)),
        }
    }
}
