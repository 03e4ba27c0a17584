//! Prospect of the conditions that a program waits for.

use std::fmt;

use coaxle_axis::{AxisStatus, StateWord};
use coaxle_slave::{CouplingPhase, Outlook};
use serde::{Deserialize, Serialize};

use super::condition::{Part, Situation};
use super::outcome::Outcome;

/// Condition that a program waits for: a field of its step, as written in a config.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WaitsFor {
    /// A time since the program began.
    TimeS,
    /// A time since the step before.
    AfterS,
    /// A mark to be used.
    AtMark,
    /// A mark, or the absence of one.
    MarkSeen,
    /// Motion of the slave with its master, or its end.
    InSync,
    /// Standstill of the slave, or its end.
    Standstill,
    /// A ready master, or the absence of one.
    MasterReady,
    /// The master's position.
    MasterAbove,
    /// The master's position.
    MasterBelow,
    /// The slave's position.
    PositionAbove,
    /// The slave's position.
    PositionBelow,
    /// A state of the slave.
    State,
    /// An error stop, or its end.
    ErrorStop,
    /// The plate that couples the slave.
    CamTable,
    /// A pending plate, or the absence of one.
    CamTableQueued,
    /// Pending points, or the absence of some.
    CamDataQueued,
    /// Completion of its command.
    Done,
    /// Abort of its command.
    Aborted,
    /// Failure of its command.
    Failed,
    /// Refusal of its command.
    Refused,
    /// Roll-back of its command.
    RolledBack,
    /// Timeout of a step, or the absence of one.
    TimedOut,
}

/// Cause that can still meet a condition; the greater, the more it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Prospect {
    /// Time, a motion, or the master's motion.
    ByItself,
    /// The return of the master.
    ByMaster,
    /// A foreign command only.
    ByOrder,
    /// No cause.
    Never,
}

/// The unmet part of a condition that is hardest to meet; the first of equals.
pub(super) fn hardest(
    unmet: impl Iterator<Item = Part>,
    now: &Situation,
    is_busy: bool,
) -> Option<(Part, Prospect)> {
    unmet
        .map(|part| (part, part.prospect(now, is_busy)))
        .reduce(|a, b| if b.1 > a.1 { b } else { a })
}

impl Part {
    /// Prospect of a part. It may be met if it depends on the master, the material or the drive.
    fn prospect(self, now: &Situation, is_busy: bool) -> Prospect {
        use Prospect::{ByItself, ByOrder, Never};
        match self {
            Self::Time | Self::After => ByItself,
            Self::AtMark | Self::MarkSeen(true) => once(now.first_master_ready),
            Self::MasterAbove | Self::MasterBelow => {
                once(now.master.is_some() && now.first_master_ready)
            }
            Self::MasterReady(true) => once(false),
            Self::MarkSeen(false) | Self::MasterReady(false) => ByItself,
            Self::InSync(true) if now.phase.is_none() => by_start(now),
            Self::InSync(_) => ByItself,
            Self::Standstill(true) => match now.outlook {
                Outlook::ConstantVelocity(_) => ByOrder,
                _ => ByItself,
            },
            Self::Standstill(false) => by_motion(now, |_| true),
            Self::PositionAbove => by_motion(now, |velocity| velocity > 0.0),
            Self::PositionBelow => by_motion(now, |velocity| velocity < 0.0),
            Self::State(state) => to_state(state, now),
            Self::ErrorStop(true) | Self::Outcome(Outcome::Failed, true) => ByItself,
            Self::ErrorStop(false) => ByOrder,
            // A pending change takes effect by the master's motion; a new one has to be commanded.
            Self::CamTableQueued(false) | Self::CamDataQueued(false) => {
                once(now.first_master_ready)
            }
            Self::CamTableQueued(true) | Self::CamDataQueued(true) => ByOrder,
            Self::CamTable(0) => match now.phase {
                Some(CouplingPhase::Releasing) => ByItself,
                _ => ByOrder,
            },
            Self::CamTable(_) if now.queues(StateWord::CAM_TABLE_QUEUED) => {
                once(now.first_master_ready)
            }
            Self::CamTable(_) => by_start(now),
            Self::Outcome(..) if is_busy => ByItself,
            Self::Outcome(..) | Self::TimedOut(_) => Never,
        }
    }

    pub(super) const fn name(self) -> WaitsFor {
        match self {
            Self::Time => WaitsFor::TimeS,
            Self::After => WaitsFor::AfterS,
            Self::AtMark => WaitsFor::AtMark,
            Self::MarkSeen(_) => WaitsFor::MarkSeen,
            Self::InSync(_) => WaitsFor::InSync,
            Self::Standstill(_) => WaitsFor::Standstill,
            Self::MasterReady(_) => WaitsFor::MasterReady,
            Self::MasterAbove => WaitsFor::MasterAbove,
            Self::MasterBelow => WaitsFor::MasterBelow,
            Self::PositionAbove => WaitsFor::PositionAbove,
            Self::PositionBelow => WaitsFor::PositionBelow,
            Self::State(_) => WaitsFor::State,
            Self::ErrorStop(_) => WaitsFor::ErrorStop,
            Self::CamTable(_) => WaitsFor::CamTable,
            Self::CamTableQueued(_) => WaitsFor::CamTableQueued,
            Self::CamDataQueued(_) => WaitsFor::CamDataQueued,
            Self::Outcome(Outcome::Done, _) => WaitsFor::Done,
            Self::Outcome(Outcome::Aborted, _) => WaitsFor::Aborted,
            Self::Outcome(Outcome::Failed, _) => WaitsFor::Failed,
            Self::Outcome(Outcome::Refused, _) => WaitsFor::Refused,
            Self::Outcome(Outcome::RolledBack, _) => WaitsFor::RolledBack,
            Self::TimedOut(_) => WaitsFor::TimedOut,
        }
    }
}

/// Prospect that requires a ready master.
const fn once(master_ready: bool) -> Prospect {
    if master_ready {
        Prospect::ByItself
    } else {
        Prospect::ByMaster
    }
}

/// Prospect that requires a coupling while none is engaged.
const fn by_start(now: &Situation) -> Prospect {
    if now.starts_coupled {
        once(now.first_master_ready)
    } else {
        Prospect::ByOrder
    }
}

/// Prospect that requires a motion; an endless one counts only if `leads_there`, by its velocity.
fn by_motion(now: &Situation, leads_there: impl FnOnce(f64) -> bool) -> Prospect {
    match now.outlook {
        Outlook::AtRest if now.is_switching_on => Prospect::ByItself,
        Outlook::AtRest => by_start(now),
        Outlook::ConstantVelocity(velocity) if !leads_there(velocity) => Prospect::ByOrder,
        Outlook::ConstantVelocity(_) | Outlook::UnderWay | Outlook::Led => Prospect::ByItself,
    }
}

/// Prospect that requires another state of the slave. Only commands lead to most of them.
fn to_state(wanted: AxisStatus, now: &Situation) -> Prospect {
    use AxisStatus as S;
    let may_come = match (now.status, wanted) {
        (_, S::ErrorStop) => true,
        (S::ErrorStop, _) => false,
        (S::Disabled, S::Standstill) => now.is_switching_on,
        (S::Disabled, S::SynchronizedMotion) => return by_start(now),
        (S::Homing | S::DiscreteMotion | S::Stopping, S::Standstill) => true,
        // Without power it is stopped first.
        (S::Stopping, S::Disabled) => true,
        // A coupling can end by itself, at rest or in motion, or be rolled back.
        (S::SynchronizedMotion, S::Standstill | S::ContinuousMotion | S::DiscreteMotion) => true,
        _ => false,
    };
    if may_come {
        Prospect::ByItself
    } else {
        Prospect::ByOrder
    }
}

impl fmt::Display for WaitsFor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TimeS => "time-s",
            Self::AfterS => "after-s",
            Self::AtMark => "at-mark",
            Self::MarkSeen => "mark-seen",
            Self::InSync => "in-sync",
            Self::Standstill => "standstill",
            Self::MasterReady => "master-ready",
            Self::MasterAbove => "master-above",
            Self::MasterBelow => "master-below",
            Self::PositionAbove => "position-above",
            Self::PositionBelow => "position-below",
            Self::State => "state",
            Self::ErrorStop => "error-stop",
            Self::CamTable => "cam-table",
            Self::CamTableQueued => "cam-table-queued",
            Self::CamDataQueued => "cam-data-queued",
            Self::Done => "done",
            Self::Aborted => "aborted",
            Self::Failed => "failed",
            Self::Refused => "refused",
            Self::RolledBack => "rolled-back",
            Self::TimedOut => "timed-out",
        })
    }
}
