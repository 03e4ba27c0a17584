//! State of the coupling of an axis, as the axis itself is led by it.

use coaxle_axis::{CouplingPhase, MasterDemands, SyncPositions};
use coaxle_cam::Tables;
use coaxle_curve::profile::Limits;

use super::SlaveAxis;
use crate::refusal::Refusal;

impl SlaveAxis {
    /// Phase of the coupling; none without one. In sync refers to the axis itself: beyond the
    /// window of its distance it is [behind](CouplingPhase::Behind).
    #[must_use]
    pub fn coupling_phase(&self) -> Option<CouplingPhase> {
        let phase = self.couplings.get(self.engaged()?).phase()?;
        // The coupling knows its own set values, the axis those that its limits have left.
        let is_behind = phase.is_in_sync() && self.left_behind.is_some();
        Some(if is_behind {
            CouplingPhase::Behind
        } else {
            phase
        })
    }

    /// Checks that a tool on it can cut now: not while the axis is led to its master or away from
    /// it, nor while it is behind. An axis without a master cuts at its position.
    ///
    /// # Errors
    /// [`Refusal::CutNotInSync`].
    pub fn check_cut(&self) -> Result<(), Refusal> {
        match self.coupling_phase() {
            Some(
                phase @ (CouplingPhase::Behind
                | CouplingPhase::Synchronizing
                | CouplingPhase::SynchronizingAfterSyncPosition
                | CouplingPhase::Releasing),
            ) => Err(Refusal::CutNotInSync {
                phase,
                distance: self.distance,
                window: self.in_sync_window,
            }),
            _ => Ok(()),
        }
    }

    /// Greatest distance of the set position from that of the coupling while the axis is in sync, u.
    #[must_use]
    pub const fn in_sync_window(&self) -> f64 {
        self.in_sync_window
    }

    /// Positions of master and slave at which they are synchronous, if the coupling leads to such a pair.
    #[must_use]
    pub fn sync_positions(&self) -> Option<SyncPositions> {
        self.couplings.get(self.engaged()?).sync_positions()
    }

    /// Scaling of the master positions by the coupling: 1 without one.
    #[must_use]
    pub fn master_scaling(&self, plates: &Tables) -> f64 {
        let scaling = |kind| self.couplings.master_scaling(kind, plates);
        self.engaged().map_or(1.0, scaling)
    }

    /// Limits within which the master of this number, from 0, leads the axis within `limits`; those of an axis without limits while
    /// it is not coupled to it.
    #[must_use]
    pub fn limits_of_master(&self, plates: &Tables, master: usize, limits: &Limits) -> Limits {
        let demands = |kind| self.couplings.demands_of(kind, plates, master);
        let demands = self.engaged().map_or(MasterDemands::default(), demands);
        demands.limits_of_master(limits)
    }
}
