//! A program's view of its slave.

use coaxle_axis::{AxisStatus, CommandState, Job, Modulo};
use coaxle_cam::Tables;
use coaxle_slave::{JobError, SlaveAxis};

use super::masters::SlaveMasters;
use crate::program::{Outcome, Situation};

/// Inputs of a program's conditions about its slave.
pub(super) fn situation<'a>(
    axis: &SlaveAxis,
    plates: &Tables,
    starts_coupled: bool,
    masters: &SlaveMasters<'a>,
    master_modulo: Option<Modulo>,
) -> Situation<'a> {
    let status = axis.status();
    let first = masters.first();
    Situation {
        status,
        phase: axis.coupling_phase(),
        set: axis.set(),
        stands: axis.stands(),
        outlook: axis.outlook(),
        motion: axis.job().0,
        starts_coupled,
        // Without this a program that waits for power would seem to wait in vain while the drive switches on.
        is_switching_on: status == AxisStatus::Disabled && axis.is_power_on(),
        master: first.map(|master| master.set.position),
        master_modulo,
        promised: masters.promised(),
        first_master_ready: first.is_some_and(|master| master.is_ready),
        master_ready: masters.are_ready(),
        cam_table: match axis.coupling_phase() {
            Some(_) => axis.cam_state(plates).map_or(0, |cam| cam.table),
            None => 0,
        },
        cam_queued: axis.cam_queued(plates),
    }
}

/// The result of a job that has ended, as a program distinguishes them.
pub(super) fn end_of(axis: &SlaveAxis, job: Job) -> Option<Outcome> {
    match axis.progress(job) {
        CommandState::Idle
        | CommandState::Waiting
        | CommandState::Active
        | CommandState::InSync => None,
        CommandState::Done => Some(Outcome::Done),
        // Before the plain abort, which a roll-back is as well.
        CommandState::Aborted if axis.was_rolled_back(job) => Some(Outcome::RolledBack),
        CommandState::Aborted => Some(Outcome::Aborted),
        CommandState::Failed(JobError::Refused(_)) => Some(Outcome::Refused),
        CommandState::Failed(JobError::Failed(_)) => Some(Outcome::Failed),
    }
}
