//! Prospect of the conditions that a program waits for.

use coaxle_axis::{AxisStatus, StateWord};
use coaxle_cam::TableId;
use coaxle_slave::{CouplingPhase, Outlook};

use super::situation::Inputs;

/// Cause that can still meet a condition; the greater, the more it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Prospect {
    /// Time, a motion, or the master's motion.
    Spontaneous,
    /// The return of the master.
    ByMaster,
    /// A foreign command only.
    ByOrder,
    /// No cause.
    Never,
}

/// Prospect that requires the master's motion, or material on it.
pub(super) const fn by_master(at: &Inputs<'_>) -> Prospect {
    once(at.slave.first_master_ready)
}

/// Prospect that requires a position of the master.
pub(super) const fn by_master_position(at: &Inputs<'_>) -> Prospect {
    once(at.slave.master.is_some() && at.slave.first_master_ready)
}

/// Prospect that requires a standstill of the slave.
pub(super) const fn by_standstill(at: &Inputs<'_>) -> Prospect {
    match at.slave.outlook {
        Outlook::ConstantVelocity(_) => Prospect::ByOrder,
        _ => Prospect::Spontaneous,
    }
}

/// Prospect that requires the result of a command.
pub(super) const fn by_result(at: &Inputs<'_>) -> Prospect {
    if at.is_busy {
        Prospect::Spontaneous
    } else {
        Prospect::Never
    }
}

/// Prospect that requires a plate to couple the slave; table 0: none.
pub(super) const fn by_plate(wanted: TableId, at: &Inputs<'_>) -> Prospect {
    match (wanted, at.slave.phase) {
        (0, Some(CouplingPhase::Releasing)) => Prospect::Spontaneous,
        (0, _) => Prospect::ByOrder,
        // A pending plate takes effect by the master's motion; a new one has to be commanded.
        _ if at.slave.queues(StateWord::CAM_TABLE_QUEUED) => by_master(at),
        _ => by_start(at),
    }
}

/// Prospect that requires a ready master.
const fn once(master_ready: bool) -> Prospect {
    if master_ready {
        Prospect::Spontaneous
    } else {
        Prospect::ByMaster
    }
}

/// Prospect that requires a coupling while none is engaged.
pub(super) const fn by_start(at: &Inputs<'_>) -> Prospect {
    if at.slave.starts_coupled {
        once(at.slave.first_master_ready)
    } else {
        Prospect::ByOrder
    }
}

/// Prospect that requires a motion; an endless one counts only if `leads_there`, by its velocity.
pub(super) fn by_motion(at: &Inputs<'_>, leads_there: fn(f64) -> bool) -> Prospect {
    match at.slave.outlook {
        Outlook::AtRest if at.slave.is_switching_on => Prospect::Spontaneous,
        Outlook::AtRest => by_start(at),
        Outlook::ConstantVelocity(velocity) if !leads_there(velocity) => Prospect::ByOrder,
        Outlook::ConstantVelocity(_) | Outlook::UnderWay | Outlook::Led => Prospect::Spontaneous,
    }
}

/// Prospect that requires another state of the slave. Only commands lead to most of them.
pub(super) fn by_state(wanted: AxisStatus, at: &Inputs<'_>) -> Prospect {
    use AxisStatus as S;
    let may_come = match (at.slave.status, wanted) {
        (_, S::ErrorStop) => true,
        (S::ErrorStop, _) => false,
        (S::Disabled, S::Standstill) => at.slave.is_switching_on,
        (S::Disabled, S::SynchronizedMotion) => return by_start(at),
        (S::Homing | S::DiscreteMotion | S::Stopping, S::Standstill) => true,
        // Without power it is stopped first.
        (S::Stopping, S::Disabled) => true,
        // A coupling can end by itself, at rest or in motion, or be rolled back.
        (S::SynchronizedMotion, S::Standstill | S::ContinuousMotion | S::DiscreteMotion) => true,
        _ => false,
    };
    if may_come {
        Prospect::Spontaneous
    } else {
        Prospect::ByOrder
    }
}
