//! How far a coupling is, whatever couples.

use coaxle_clock::Seconds;
use coaxle_curve::profile::Limits;

/// The time of a master, as a slave knows it, is wrong by this, s: far time is right to about a microsecond
/// (docs/OBSERVER.md), so where the coupling has the slave is known no better than the way of that.
const TIME_OF_MASTER: f64 = 1e-6;

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
    /// The slave would move with its master, and is farther from where its coupling has it than the window of
    /// [in sync](Self::InSync) allows: its limits have left it there, and it is on its way back.
    Behind,
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
    /// Whether the slave moves with its master, where its coupling has it.
    #[must_use]
    pub const fn is_in_sync(self) -> bool {
        matches!(self, Self::InSync | Self::InSyncBeforeSyncPosition)
    }

    /// The default window of a slave with these limits, u: its distance from where its coupling has it, while it is in
    /// sync. It is j·T³ + v·1 µs.
    ///
    /// A target that keeps the limits passes the guard as it is. One that misses them by its rounding, or by a jerk of
    /// twice the limit in a cycle, leaves the slave within j·T³ of it (j: no more than turns the acceleration round in a
    /// cycle). The rest is what the time of the master is wrong by.
    #[must_use]
    pub fn in_sync_window(limits: &Limits, cycle_time: Seconds) -> f64 {
        let cycle = cycle_time.0;
        let jerk = limits.binding_in_cycles(cycle).jerk();
        jerk * cycle * cycle * cycle + limits.velocity() * TIME_OF_MASTER
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
