//! How far a coupling is, whatever couples.

/// How far a coupling is. Of those of a flying saw with a strategy, `EGearInPosSyncState` of MC3 has
/// five: `Waiting`, `Synchronizing`, `SynchronizingAfterMasterSyncPosition`,
/// `InSyncBeforeMasterSyncPosition` and `InSync`.
#[doc(alias = "EGearInPosSyncState")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum CouplingPhase {
    /// The slave waits for its master.
    Waiting,
    /// The slave is led to the master's motion.
    Synchronizing,
    /// The slave moves with its master.
    InSync,
    /// The slave is led away from the master's motion.
    Releasing,
    /// The slave is released and stands.
    Released,
    /// The slave is led to the master's motion, and the master has passed its synchronisation position:
    /// a flying saw with a strategy.
    SynchronizingAfterSyncPosition,
    /// The slave moves with its master, which has not come to its synchronisation position yet: a flying
    /// saw with a strategy.
    InSyncBeforeSyncPosition,
}

impl CouplingPhase {
    /// Whether the slave moves with its master.
    #[must_use]
    pub const fn is_in_sync(self) -> bool {
        matches!(self, Self::InSync | Self::InSyncBeforeSyncPosition)
    }

    /// Whether the slave is led to the master's motion.
    #[must_use]
    pub const fn is_synchronizing(self) -> bool {
        matches!(
            self,
            Self::Synchronizing | Self::SynchronizingAfterSyncPosition
        )
    }
}
