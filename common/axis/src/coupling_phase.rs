//! Phases of a coupling, of every kind.

use coaxle_clock::Seconds;
use coaxle_curve::profile::Limits;

/// Error of a master's time, as a slave knows it, s: far time is right to about a microsecond
/// (docs/OBSERVER.md), so the slave's coupled position is uncertain by the distance of that time.
const TIME_OF_MASTER: f64 = 1e-6;

/// Phase of a coupling. For a flying saw with a strategy, `EGearInPosSyncState` of MC3 has five:
/// `Waiting`, `Synchronizing`, `SynchronizingAfterMasterSyncPosition`,
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
    /// The slave would move with its master, but is farther from the position of its coupling than
    /// the window of [in sync](Self::InSync) allows: its limits have left it there, and it is
    /// catching up.
    Behind,
    /// The slave is led away from the master's motion.
    Releasing,
    /// The slave is released and at rest.
    Released,
    /// The slave is led to the master's motion, and the master has passed its synchronisation position:
    /// a flying saw with a strategy.
    SynchronizingAfterSyncPosition,
    /// The slave moves with its master, which has not reached its synchronisation position yet: a
    /// flying saw with a strategy.
    InSyncBeforeSyncPosition,
}

impl CouplingPhase {
    /// True if the slave moves with its master, at the position of its coupling.
    #[must_use]
    pub const fn is_in_sync(self) -> bool {
        matches!(self, Self::InSync | Self::InSyncBeforeSyncPosition)
    }

    /// The default window of a slave with these limits, u: its greatest distance from the position
    /// of its coupling in sync. It is j·T³ + v·1 µs.
    ///
    /// A target that keeps the limits passes the guard unchanged. A target that exceeds them by its
    /// rounding, or by a jerk of twice the limit in a cycle, leaves the slave within j·T³ of it (j:
    /// at most the jerk that reverses the acceleration in a cycle). The rest is the error of the
    /// master's time.
    #[must_use]
    pub fn in_sync_window(limits: &Limits, cycle_time: Seconds) -> f64 {
        let cycle = cycle_time.0;
        // A jerk limit that means "none" would otherwise make a window in which everything is in sync.
        let jerk = limits.binding_in_cycles(cycle).jerk();
        jerk * cycle * cycle * cycle + limits.velocity() * TIME_OF_MASTER
    }

    /// True while the slave is led to the master's motion.
    #[must_use]
    pub const fn is_synchronizing(self) -> bool {
        matches!(
            self,
            Self::Synchronizing | Self::SynchronizingAfterSyncPosition
        )
    }
}
