//! Whether the condition of a step holds.

use coaxle_axis::AxisStatus;
use coaxle_clock::Seconds;
use coaxle_curve::profile::Kinematics;
use coaxle_slave::CouplingPhase;

use super::config::When;

/// What a condition can ask about: slave and master as they were after the last cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation {
    pub(crate) status: AxisStatus,
    pub(crate) phase: Option<CouplingPhase>,
    pub(crate) set: Kinematics,
    /// Position of the master; none without one.
    pub(crate) master: Option<f64>,
    /// The master is there, without error, and its clock is known.
    pub(crate) master_ready: bool,
}

/// What the program itself knows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passed {
    pub(super) since_start: Seconds,
    pub(super) since_step: Seconds,
    /// There is a mark to be used.
    pub(super) mark_seen: bool,
}

impl When {
    pub(super) fn holds(&self, now: &Situation, passed: &Passed) -> bool {
        let in_sync = now.phase == Some(CouplingPhase::InSync);
        let standstill = now.set.velocity == 0.0 && now.set.acceleration == 0.0;
        let master = now.master.unwrap_or(f64::NAN);
        let position = now.set.position;
        [
            self.time_s
                .is_none_or(|time| passed.since_start.0 >= time.get()),
            self.after_s
                .is_none_or(|time| passed.since_step.0 >= time.get()),
            self.mark_seen.is_none_or(|asked| passed.mark_seen == asked),
            self.in_sync.is_none_or(|asked| in_sync == asked),
            self.standstill.is_none_or(|asked| standstill == asked),
            self.master_ready
                .is_none_or(|asked| now.master_ready == asked),
            self.master_above.is_none_or(|limit| master > limit.get()),
            self.master_below.is_none_or(|limit| master < limit.get()),
            self.position_above
                .is_none_or(|limit| position > limit.get()),
            self.position_below
                .is_none_or(|limit| position < limit.get()),
            self.state.is_none_or(|state| now.status == state),
        ]
        .into_iter()
        .all(|holds| holds)
    }
}
