//! What moves an axis.

use std::fmt;

use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;
use serde::{Deserialize, Serialize};

/// What moves one axis.
///
/// A source depends on nothing but the time: the same times give the same motion, so a second one
/// opened from the same config knows what the first one does. Sampling allocates nothing.
pub trait Source: fmt::Debug + Send {
    /// What the axis does `since_start` after the start of the node. Times never go back.
    fn sample(&mut self, since_start: Span) -> AxisSample;
}

/// What an axis does at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSample {
    /// How it really moves.
    pub motion: Kinematics,
    /// How its controller sees it move: what it is set to, or measures.
    pub seen: Kinematics,
    /// Whether it is ready for motions.
    pub enabled: bool,
    /// What it is doing.
    pub activity: Activity,
    /// Counts its motions, wrapping.
    pub command_number: u16,
    /// Where the current motion ends, u; the present position where it has no end.
    pub target_position: f64,
}

/// What an axis is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Activity {
    /// Nothing.
    #[default]
    Idle,
    /// On its way to a position.
    Positioning,
    /// In the position it was sent to.
    InTarget,
    /// At, or on its way to, a velocity that it keeps.
    Continuous,
    /// Coming to a standstill.
    Halting,
    /// Halted.
    Halted,
    /// Following set points from outside.
    Following,
    /// Being measured; whatever moves it is not known.
    Measured,
}
