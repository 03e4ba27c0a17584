//! When and how hard a slave is synchronised.

/// `MC_SYNC_STRATEGY` (TF5410), the strategy of a synchronisation to a pair of positions.
///
/// All three lead the slave along phases of constant jerk within the limits in force, and plan as if the
/// master kept its velocity.
#[doc(alias = "MC_SYNC_STRATEGY")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SyncStrategy {
    /// As late as possible, with nearly all of acceleration, deceleration and jerk: the slave keeps its
    /// velocity until then. It is at its synchronisation position when the master is at its own, since
    /// the profile is one over the master's position.
    #[doc(alias = "mcSyncStrategyLate")]
    Late,
    /// Over the whole way, with the least part of acceleration, deceleration and jerk that is enough; at
    /// its position with the master, like the one before.
    #[doc(alias = "mcSyncStrategySlow")]
    Slow,
    /// As soon as the limits allow, before the synchronisation positions or after them, whatever the
    /// master does meanwhile: a profile over time that is planned anew wherever the master does not
    /// do what it was expected to. The master may stand, turn round, or be past its position.
    #[doc(alias = "mcSyncStrategyEarly")]
    Early,
}

impl SyncStrategy {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Late, Self::Slow, Self::Early];
}
