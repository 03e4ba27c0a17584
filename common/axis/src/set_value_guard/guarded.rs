//! Output of the guard of the set values.

use coaxle_curve::profile::Kinematics;

/// A set value that keeps the limits, and its relation to its target.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guarded {
    /// Set values for the drive. While [`GuardState::Tracking`] the target itself, with all three
    /// values; else the position, and the velocity and acceleration of its differences at this
    /// moment: that velocity is the mean of the last cycle plus half a cycle of the acceleration,
    /// as a drive with velocity feed-forward expects it. A stated velocity or acceleration of the
    /// target that exceeds a limit kept by its positions, or that does not match its positions, is
    /// replaced by those too. Stated velocities keep the limit of the acceleration from cycle to
    /// cycle, and stated accelerations that of the jerk.
    pub set: Kinematics,
    /// State of the guard.
    pub state: GuardState,
    /// The set position less that of the target, u; of the last target that was a number.
    pub distance: f64,
}

/// State of following a target. A window of the distance and a time turn a persistent distance into
/// a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum GuardState {
    /// The target passes unchanged.
    #[default]
    Tracking,
    /// The axis moves without a target: for one cycle after the last that passed, with its
    /// acceleration; or to a stop, if the target is not a number.
    Coasting,
    /// The axis is on its way to the target.
    CatchingUp,
    /// The axis is on its way, but the target is faster than the axis, or beyond a software limit.
    Cannot,
}

/// Policy for a distance left behind while a target could not be followed.
///
/// Named after the modes of a multi-master gear of Tc2_MC2. Its third mode, `POSSYNC2`, also
/// catches up the distances of ratio changes: the gear itself does that, since the guard sees only
/// positions and no ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum DistancePolicy {
    /// The distance stays: only the velocity of the target is followed.
    #[doc(alias = "VELOSYNC")]
    VeloSync,
    /// The distance is caught up.
    #[doc(alias = "POSSYNC1")]
    #[default]
    PosSync1,
}
