//! The distances of master and slave to a synchronisation position.

use super::command::GearInPos;
use super::refusal::SawRefusal;
use super::task::{SyncTask, finite};

/// Distances from the coupling moment to the synchronisation position.
pub(super) struct SyncSpan<'a> {
    pub(super) task: &'a SyncTask,
    /// M, signed.
    pub(super) master: f64,
    /// Δs.
    pub(super) slave: f64,
    /// Start slope.
    pub(super) from: f64,
    /// Start curvature.
    pub(super) curvature: f64,
    /// Positions at which master and slave are synchronous.
    pub(super) sync: (f64, f64),
}

impl<'a> SyncSpan<'a> {
    /// # Errors
    /// Positions that are not finite, or not ahead of master and slave.
    pub(super) fn new(task: &'a SyncTask, command: &GearInPos) -> Result<Self, SawRefusal> {
        let span = Self::of_master(task, command)?;
        // By the position of the master ahead, not by its velocity, which may be 0.
        let direction = task.ratio.signum() * span.master.signum();
        // With a strategy a slave may come from either side.
        // TS5055 13 refuses one that is past its position.
        if span.slave * direction <= 0.0 {
            return Err(SawRefusal::SlaveNotAhead {
                position: task.slave_position,
                sync_position: span.sync.1,
                direction,
            });
        }
        Ok(span)
    }

    /// Makes the distances of a slave that may approach from either side.
    ///
    /// # Errors
    /// Positions that are not finite, or not ahead of the master.
    pub(super) fn of_master(task: &'a SyncTask, command: &GearInPos) -> Result<Self, SawRefusal> {
        check_positions(command)?;
        let sync = (command.master_sync_position, command.slave_sync_position);
        let master = sync.0 - task.master_position;
        let slave = sync.1 - task.slave_position;
        // A master at rest may start in either direction, so its position only has to be another one.
        if master == 0.0 || master * task.master_velocity < 0.0 {
            return Err(SawRefusal::MasterNotAhead {
                position: task.master_position,
                velocity: task.master_velocity,
                sync_position: sync.0,
            });
        }
        Ok(Self {
            task,
            master,
            slave,
            from: task.slope(),
            curvature: task.curvature(),
            sync,
        })
    }
}

/// # Errors
/// A synchronisation position that is not finite.
pub(super) fn check_positions(command: &GearInPos) -> Result<(), SawRefusal> {
    finite("master-sync-position", command.master_sync_position)?;
    finite("slave-sync-position", command.slave_sync_position)
}
