//! Unmet parts of a step's condition.

use coaxle_axis::{AxisStatus, Job, StateWord};
use coaxle_cam::TableId;
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_slave::{CouplingPhase, Outlook};

use super::config::When;
use super::outcome::Outcome;

/// Inputs of a condition: slave and master after the last cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation {
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
    /// True if the master of that position is there, without error, and its clock is known.
    pub(crate) first_master_ready: bool,
    /// True if all masters are ready.
    pub(crate) master_ready: bool,
    /// The plate that couples it, the first of several; 0 without one.
    pub(crate) cam_table: TableId,
    /// Pending changes of the coupling by plates.
    pub(crate) cam_queued: StateWord,
}

impl Situation {
    /// True if this change is pending in the coupling by plates.
    pub(super) const fn queues(&self, what: StateWord) -> bool {
        self.cam_queued.contains(what)
    }
}

/// Inputs from the program itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passed {
    pub(super) since_start: Seconds,
    pub(super) since_step: Seconds,
    /// True if there is a mark to be used.
    pub(super) mark_seen: bool,
    /// Result of the last command.
    pub(super) outcome: Option<Outcome>,
    /// True if a step waited for too long, and no command was given since.
    pub(super) timed_out: bool,
}

/// A part of a condition, with its required value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Time,
    After,
    AtMark,
    MarkSeen(bool),
    InSync(bool),
    Standstill(bool),
    MasterReady(bool),
    MasterAbove,
    MasterBelow,
    PositionAbove,
    PositionBelow,
    State(AxisStatus),
    ErrorStop(bool),
    CamTable(TableId),
    CamTableQueued(bool),
    CamDataQueued(bool),
    Outcome(Outcome, bool),
    TimedOut(bool),
}

impl When {
    /// The unmet parts, in the order of the fields.
    pub(super) fn unmet(
        &self,
        now: &Situation,
        passed: &Passed,
    ) -> impl Iterator<Item = Part> + use<> {
        let in_sync = now.phase == Some(CouplingPhase::InSync);
        let error_stop = now.status == AxisStatus::ErrorStop;
        let master = now.master.unwrap_or(f64::NAN);
        let position = now.set.position;
        // Comparisons with a non-finite number are unmet.
        let lacks = |holds: bool, part: Part| (!holds).then_some(part);
        let differs = |asked: Option<bool>, is: bool| asked.filter(|asked| *asked != is);
        let outcome = |asked: Option<bool>, outcome| {
            let part = |asked| Part::Outcome(outcome, asked);
            differs(asked, passed.outcome == Some(outcome)).map(part)
        };
        [
            self.time_s
                .and_then(|time| lacks(passed.since_start.0 >= time.get(), Part::Time)),
            self.after_s
                .and_then(|time| lacks(passed.since_step.0 >= time.get(), Part::After)),
            differs(self.mark_seen, passed.mark_seen).map(Part::MarkSeen),
            differs(self.in_sync, in_sync).map(Part::InSync),
            differs(self.standstill, now.stands).map(Part::Standstill),
            differs(self.master_ready, now.master_ready).map(Part::MasterReady),
            self.master_above
                .and_then(|limit| lacks(master > limit.get(), Part::MasterAbove)),
            self.master_below
                .and_then(|limit| lacks(master < limit.get(), Part::MasterBelow)),
            self.position_above
                .and_then(|limit| lacks(position > limit.get(), Part::PositionAbove)),
            self.position_below
                .and_then(|limit| lacks(position < limit.get(), Part::PositionBelow)),
            self.state
                .and_then(|state| lacks(now.status == state, Part::State(state))),
            differs(self.error_stop, error_stop).map(Part::ErrorStop),
            self.cam_table
                .and_then(|table| lacks(now.cam_table == table, Part::CamTable(table))),
            differs(
                self.cam_table_queued,
                now.queues(StateWord::CAM_TABLE_QUEUED),
            )
            .map(Part::CamTableQueued),
            differs(self.cam_data_queued, now.queues(StateWord::CAM_DATA_QUEUED))
                .map(Part::CamDataQueued),
            outcome(self.done, Outcome::Done),
            outcome(self.aborted, Outcome::Aborted),
            outcome(self.failed, Outcome::Failed),
            outcome(self.refused, Outcome::Refused),
            outcome(self.rolled_back, Outcome::RolledBack),
            differs(self.timed_out, passed.timed_out).map(Part::TimedOut),
        ]
        .into_iter()
        .flatten()
    }

    /// True if it requires a trouble, which the step then handles itself.
    pub(super) fn asks_for_trouble(&self) -> bool {
        [
            self.error_stop,
            self.aborted,
            self.failed,
            self.refused,
            self.rolled_back,
            self.timed_out,
        ]
        .contains(&Some(true))
    }
}
