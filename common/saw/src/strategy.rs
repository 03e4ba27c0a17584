//! Timing and dynamics of a synchronisation.

/// `MC_SYNC_STRATEGY` (TF5410), the strategy of a synchronisation to a pair of positions.
///
/// Every strategy leads the slave along phases of constant jerk within the limits in force, and plans as
/// if the master kept its velocity.
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
    /// Over the whole distance, with the least sufficient part of acceleration, deceleration and jerk; at
    /// its position together with the master, like `Late`.
    #[doc(alias = "mcSyncStrategySlow")]
    Slow,
    /// As soon as the limits allow, before the synchronisation positions or after them, for any motion of
    /// the master: a profile over time that is planned again when the master deviates from the
    /// prediction. The master may stand, reverse, or be past its position.
    #[doc(alias = "mcSyncStrategyEarly")]
    Early,
}

impl SyncStrategy {
    /// Strategies.
    pub const ALL: [Self; 3] = [Self::Late, Self::Slow, Self::Early];
}
