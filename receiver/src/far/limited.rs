//! The limits of a far axis that has some of its own.

use coaxle_axis::set_value_guard::{GuardState, SetValueGuard};
use coaxle_clock::{CycleTime, Seconds};
use coaxle_curve::profile::{Kinematics, Limits};

/// Keeps them by the differences of its positions, whatever happens to its node.
#[derive(Debug)]
pub(super) struct Limited {
    limits: Limits,
    cycle: Seconds,
    /// None before its first set values.
    guard: Option<SetValueGuard>,
    is_tracking: bool,
}

impl Limited {
    pub(super) fn new(limits: Limits, cycle: CycleTime) -> Self {
        Self {
            limits,
            cycle: Seconds(cycle.as_secs_f64()),
            guard: None,
            is_tracking: true,
        }
    }

    /// What the limits leave of set values, `elapsed` cycles after the last ones.
    pub(super) fn keep(&mut self, set: &Kinematics, elapsed: u32) -> Kinematics {
        let Some(guard) = &mut self.guard else {
            let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
            self.guard = SetValueGuard::new(&self.limits, min, max, self.cycle, set).ok();
            return *set;
        };
        let left = guard.update(set, elapsed);
        self.is_tracking = left.state == GuardState::Tracking;
        left.set
    }

    /// Whether the last set values were left as they were.
    pub(super) const fn is_tracking(&self) -> bool {
        self.is_tracking
    }
}
