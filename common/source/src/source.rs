//! Interface of a source of an axis.

use std::fmt;

use coaxle_axis::motion_plan::MotionPlan;
use coaxle_clock::Span;
use coaxle_curve::profile::Kinematics;
use serde::{Deserialize, Serialize};

use crate::followers::Followers;

/// Source of the motion of one axis.
///
/// A source depends on nothing but the time, and on its followers if it has any: the same times give the same motion.
/// Sampling allocates nothing.
pub trait AxisSource: fmt::Debug + Send {
    /// Returns the axis `since_start` after the start of the node. Times never go back.
    fn sample(&mut self, since_start: Span) -> SourceSample;

    /// Takes the state of the followers, `since_start`, before the sample of that time. Only a source with followers reacts to it.
    fn take_followers(&mut self, since_start: Span, followers: &Followers) {
        let _ = (since_start, followers);
    }

    /// True if it stands still, or ramps down, because a follower has failed.
    fn is_held(&self) -> bool {
        false
    }

    /// Returns the motion that is decided from the newest sample on, `since_start`, with instants after `origin`; none
    /// of a source that decides nothing ahead, or whose motion has no pieces of constant jerk.
    fn plan(&self, since_start: Span, origin: Span) -> Option<MotionPlan> {
        let _ = (since_start, origin);
        None
    }

    /// Returns the number of decisions so far: each changes the plan.
    fn decisions(&self) -> u64 {
        0
    }
}

/// State of an axis at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SourceSample {
    /// Actual motion.
    pub motion: Kinematics,
    /// Motion in its controller: set or measured values.
    pub seen: Kinematics,
    /// True if it is ready for motions.
    pub enabled: bool,
    /// Present activity.
    pub activity: Activity,
    /// Counter of its motions, wrapping.
    pub command_number: u16,
    /// End position of the current motion, u; the present position if it has none.
    pub target_position: f64,
}

/// Activity of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Activity {
    /// No motion.
    #[default]
    Idle,
    /// On its way to a position.
    Positioning,
    /// In the target position.
    InTarget,
    /// At, or on its way to, a constant velocity.
    Continuous,
    /// Coming to a standstill.
    Halting,
    /// Halted.
    Halted,
    /// Following set points from outside.
    Following,
    /// Measured, with an unknown source of motion.
    Measured,
}
