//! What the guard of the set values gives.

use coaxle_curve::profile::Kinematics;

/// A set value that keeps the limits, and how it is related to its target.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guarded {
    /// What the drive gets. While [`GuardState::Tracking`] the target itself, all three of its values; else
    /// the position, and the velocity and acceleration that its differences have at this moment: that
    /// velocity is the mean of the last cycle plus what half a cycle of the acceleration adds, as a drive
    /// with velocity feed-forward expects it. A velocity or acceleration that a target states beyond a
    /// limit that its positions keep, or that is not that of its positions, is replaced by those too. Stated velocities
    /// keep the limit of the acceleration from cycle to cycle, and stated accelerations that of the jerk.
    pub set: Kinematics,
    /// How the axis does.
    pub state: GuardState,
    /// The set position less that of the target, u; of the last target that was a number.
    pub distance: f64,
}

/// How an axis follows its target. A window of the distance and a time make a fault of what lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum GuardState {
    /// The target passes as it is.
    Tracking,
    /// The axis goes on without a target: for one cycle after the last that passed, with its acceleration;
    /// or to a stop, where the target is not a number.
    Coasting,
    /// The axis is on its way to the target.
    CatchingUp,
    /// So it is, but the target is faster than the axis, or beyond a software limit.
    Cannot,
}

/// What becomes of a distance that was left behind while a target could not be followed.
///
/// Named as the modes of a multi-master gear of Tc2_MC2. Its third mode, `POSSYNC2`, catches up what changes of the
/// ratio leave behind, too: the gear itself does that, the guard sees positions and knows no ratio.
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
