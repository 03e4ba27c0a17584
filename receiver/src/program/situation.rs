//! Situation of a slave and its program, which the conditions of a step test.

use coaxle_axis::{AxisStatus, Job, Modulo, StateWord};
use coaxle_cam::TableId;
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_slave::{CouplingPhase, Outlook};

use super::outcome::Outcome;
use crate::promised::PromisedMotion;

/// Inputs of a condition: slave and master after the last cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation<'a> {
    pub(crate) status: AxisStatus,
    pub(crate) phase: Option<CouplingPhase>,
    pub(crate) set: Kinematics,
    /// True if it has stood for a cycle.
    pub(crate) stands: bool,
    /// Further course of the set values without a command.
    pub(crate) outlook: Outlook,
    /// The job that moves the slave, or did so last.
    pub(crate) motion: Option<Job>,
    /// True if it is coupled as soon as its master is there.
    pub(crate) starts_coupled: bool,
    /// True if power is commanded, but its drive does not follow yet.
    pub(crate) is_switching_on: bool,
    /// Position of the master; none without one.
    pub(crate) master: Option<f64>,
    /// Modulo period of the master; none without one.
    pub(crate) master_modulo: Option<Modulo>,
    /// Motion that its node has promised; none without a promise.
    pub(crate) promised: Option<PromisedMotion<'a>>,
    /// True if the master of that position is there, without error, and its clock is known.
    pub(crate) first_master_ready: bool,
    /// True if all masters are ready.
    pub(crate) master_ready: bool,
    /// The plate that couples it, the first of several; 0 without one.
    pub(crate) cam_table: TableId,
    /// Pending changes of the coupling by plates.
    pub(crate) cam_queued: StateWord,
}

impl Situation<'_> {
    /// True if this change is pending in the coupling by plates.
    pub(super) const fn queues(&self, what: StateWord) -> bool {
        self.cam_queued.contains(what)
    }
}

/// Inputs from the program itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProgramInputs {
    pub(super) since_start: Seconds,
    pub(super) since_step: Seconds,
    /// True if there is a mark to be used.
    pub(super) mark_seen: bool,
    /// Result of the last command.
    pub(super) outcome: Option<Outcome>,
    /// True if a step waited for too long, and no command was given since.
    pub(super) timed_out: bool,
}

/// Inputs of a condition.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inputs<'a> {
    pub(super) slave: &'a Situation<'a>,
    pub(super) passed: &'a ProgramInputs,
    /// True if a command of the program is under way.
    pub(super) is_busy: bool,
}
