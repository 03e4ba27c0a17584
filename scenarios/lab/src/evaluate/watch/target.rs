//! A slave and its target: it is there in sync, approaches it when it can, and is there in the end.

use coaxle_axis::AxisStatus;
use coaxle_axis::set_value_guard::DistancePolicy;
use coaxle_clock::CycleTime;
use coaxle_curve::profile::Limits;
use coaxle_receiver::GuardState;
use coaxle_receiver::signals::SlaveSignals;
use coaxle_sim::ApproachCheck;
use coaxle_slave::{CouplingPhase, SlaveParameters};

use super::found::{Found, WatchedCycle};
use crate::invariants::Invariant;

/// Rounding error, relative to the position.
const ROUNDING: f64 = 1e-12;
/// Default of the guard's own window: the way of this time, s, at the highest velocity.
const GUARD_WINDOW: f64 = 0.1;

/// Watches the distance of a slave from the position that its coupling, or its motion, requires.
#[derive(Debug)]
pub(super) struct TargetWatch {
    /// Greatest distance in sync, u; absent for a slave that may keep a distance.
    in_sync: Option<f64>,
    /// Greatest distance at the end of the run, u; absent if it is not checked.
    at_end: Option<f64>,
    approach: ApproachCheck,
    set_anew: u32,
}

impl TargetWatch {
    /// Absent for a slave without a window: its parameters were refused.
    pub(super) fn new(
        parameters: &SlaveParameters,
        limits: &Limits,
        cycle_time: CycleTime,
    ) -> Option<Self> {
        // With `velo-sync` a slave keeps the velocity of its master, and any distance.
        let is_to_be_there = parameters.distance.policy != DistancePolicy::VeloSync;
        let window = parameters.distance.window;
        let window = window.unwrap_or(GUARD_WINDOW * limits.velocity());
        let in_sync = parameters.in_sync_window(cycle_time).ok()?;
        Some(Self {
            in_sync: is_to_be_there.then_some(in_sync),
            // A window of 0 switches the monitoring off.
            at_end: (is_to_be_there && window > 0.0).then_some(window),
            approach: ApproachCheck::new(limits, cycle_time.as_secs_f64()),
            set_anew: 0,
        })
    }

    pub(super) fn push(&mut self, cycle: &WatchedCycle, slave: &SlaveSignals, found: &mut Found) {
        let Some(position) = slave.position else {
            self.approach.restart();
            return;
        };
        let distance = slave.distance.abs();
        if let Some(window) = self.in_sync
            && slave.phase.is_some_and(CouplingPhase::is_in_sync)
            // The distance is a difference of positions, and has their rounding errors.
            && distance > window + ROUNDING * position.abs()
        {
            found.add(cycle, Invariant::InSync, distance, window);
        }
        let is_set_anew = std::mem::replace(&mut self.set_anew, slave.set_anew) != slave.set_anew;
        // Otherwise something stops it from approaching: an error stop, a skipped cycle, a position that was set.
        let is_on_its_way = slave.guard == GuardState::CatchingUp
            && slave.state != AxisStatus::ErrorStop
            && cycle.since == Some(1)
            && !is_set_anew;
        if !is_on_its_way {
            self.approach.restart();
        } else if let Some(away) = self.approach.push(position, slave.distance) {
            found.add(cycle, Invariant::Approach, away.distance, away.before);
        }
    }

    /// Ends the run, and checks the final state.
    pub(super) fn end(&self, cycle: &WatchedCycle, slave: &SlaveSignals, found: &mut Found) {
        if slave.state == AxisStatus::ErrorStop {
            found.add(cycle, Invariant::EndsWell, slave.error.into(), 0.0);
        }
        // A slave on a command of its own has no position by its coupling to be at.
        let is_coupled = slave.state == AxisStatus::SynchronizedMotion;
        if let Some(window) = self.at_end.filter(|_| is_coupled)
            && slave.distance.abs() > window
        {
            found.add(cycle, Invariant::EndsWell, slave.distance.abs(), window);
        }
    }
}
