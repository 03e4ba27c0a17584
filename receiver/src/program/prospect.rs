//! Whether what a program waits for can still come.

use std::fmt;

use coaxle_axis::{AxisStatus, StateWord};
use coaxle_slave::{CouplingPhase, Outlook};
use serde::{Deserialize, Serialize};

use super::condition::{Part, Situation};
use super::outcome::Outcome;

/// What a program waits for: a field of its step, as a config spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WaitsFor {
    /// A time since the program began.
    TimeS,
    /// A time since the step before.
    AfterS,
    /// A mark to be used.
    AtMark,
    /// A mark, or that there is none.
    MarkSeen,
    /// That the slave moves with its master, or does not.
    InSync,
    /// That the slave stands, or does not.
    Standstill,
    /// The master, or that it is not there.
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
    /// A plate that waits for its moment, or that none does.
    CamTableQueued,
    /// Points that wait for their moment, or that none do.
    CamDataQueued,
    /// What became of its command.
    Done,
    /// What became of its command.
    Aborted,
    /// What became of its command.
    Failed,
    /// What became of its command.
    Refused,
    /// What became of its command.
    RolledBack,
    /// That a step waited for too long, or that none did.
    TimedOut,
}

/// Who can bring what is waited for; the more it takes, the greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Prospect {
    /// It may come by itself: with time, by a motion, by what the master does.
    ByItself,
    /// It can come once the master is there.
    ByMaster,
    /// Only a command of somebody else can bring it.
    ByOrder,
    /// Nothing can.
    Never,
}

/// Of the parts of a condition that do not hold the one that is hardest to come by, the first of those.
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
    /// Where it depends on what the master, the material or the drive does, it may come.
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
            // What waits comes by what the master does; what does not wait, somebody has to send.
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

/// It takes a master that is ready.
const fn once(master_ready: bool) -> Prospect {
    if master_ready {
        Prospect::ByItself
    } else {
        Prospect::ByMaster
    }
}

/// It takes a coupling, and none is engaged.
const fn by_start(now: &Situation) -> Prospect {
    if now.starts_coupled {
        once(now.first_master_ready)
    } else {
        Prospect::ByOrder
    }
}

/// It takes a motion; one without an end only if `leads_there`, by its velocity.
fn by_motion(now: &Situation, leads_there: impl FnOnce(f64) -> bool) -> Prospect {
    match now.outlook {
        Outlook::AtRest if now.is_switching_on => Prospect::ByItself,
        Outlook::AtRest => by_start(now),
        Outlook::ConstantVelocity(velocity) if !leads_there(velocity) => Prospect::ByOrder,
        Outlook::ConstantVelocity(_) | Outlook::UnderWay | Outlook::Led => Prospect::ByItself,
    }
}

/// It takes another state of the slave. Only commands lead to most of them.
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
