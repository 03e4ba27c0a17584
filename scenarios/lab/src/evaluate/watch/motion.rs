//! A far axis: its positions, against its master's possible motion.

use coaxle_receiver::config::{FarAxisConfig, FarConfig};
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals};
use coaxle_receiver::{ContinuityState, FilterMode, FilterState};
use coaxle_sim::{FarAxisMode, FarMotion, FarMotionBounds, FarMotionCheck, Received};

use super::found::{Found, WatchedCycle};
use crate::invariants::Invariant;
use crate::summary::World;

/// Assumed beat of a block that tolerates any.
const MOST_BEATS: f64 = 1_000.0;

/// Watches the positions of a far axis.
#[derive(Debug)]
pub(super) struct MotionWatch {
    check: FarMotionCheck,
    /// Cycle of its node that the axis's values are of, s, and the number of frames without the axis before.
    frame: Option<(f64, u64)>,
    /// True if it was in sync in this run of its receiver, and in its newest mode.
    was_synced: bool,
    /// True if sync that was there has to be there at the end.
    keeps_sync: bool,
}

impl MotionWatch {
    pub(super) fn new(
        far: &FarConfig,
        axis: &FarAxisConfig,
        cycle_time: f64,
        world: World,
    ) -> Self {
        let limits = axis.limits.map(|limits| limits.get().velocity());
        // An encoder master takes increments at up to 1½ times its highest speed, and refuses more.
        let of_encoder = axis.encoder.map(|encoder| 1.5 * encoder.max_speed);
        let bounds = FarMotionBounds {
            cycle_time,
            blending_time: far.sync.extrapolate.blending_time.0,
            // The factor counts receiver cycles.
            filter_time: far.sync.extrapolate.t1_factor_pos * cycle_time,
            pace_of_blocks: pace_of_blocks(far),
            own_velocity: limits.into_iter().chain(of_encoder).reduce(f64::max),
            is_smoothed: axis.encoder.is_some(),
        };
        Self {
            check: FarMotionCheck::new(bounds),
            frame: None,
            was_synced: false,
            // A busy machine may take sync away in the last second of processes: `synced_at_end` is there for expectations.
            keeps_sync: world == World::Virtual && far.mode.synchronises(&far.sync),
        }
    }

    /// The axis, and the node of this number that it is read from.
    pub(super) fn push(
        &mut self,
        cycle: &WatchedCycle,
        (node, far): (usize, &FarNodeSignals),
        axis: &FarAxisSignals,
        found: &mut Found,
    ) {
        // Another run of the receiver begins at any position.
        if cycle.since.is_none() {
            self.check.restart();
            self.was_synced = false;
        }
        // An order may have chosen another mode, or switched it off.
        let is_to_be = matches!(far.mode, FilterMode::Observer | FilterMode::Auto) && far.enabled;
        self.was_synced = is_to_be && (self.was_synced || axis.synced);
        let motion = self.received(node, far, axis).and_then(|received| {
            Some(FarMotion {
                position: axis.corrected_position?,
                received,
                correction: axis.correction_us.map(|correction| correction * 1e-6),
                mode: mode_of(axis.state?),
                promised: promised(axis),
                follows: axis.continuity == ContinuityState::Following,
                cycles: cycle.since.unwrap_or(1),
            })
        });
        let Some(motion) = motion else {
            self.check.restart();
            return;
        };
        if let Some(fault) = self.check.push(&motion) {
            found.add(cycle, Invariant::FarAxis, fault.value, fault.limit);
        }
    }

    fn received(
        &mut self,
        node: usize,
        far: &FarNodeSignals,
        axis: &FarAxisSignals,
    ) -> Option<Received> {
        let cycle_time = far.cycle_time_us? * 1e-6;
        // The master's own time: arrival times jitter, and would make accelerations of a steady master.
        let newest = far.count? as f64 * cycle_time;
        let at = match self.frame {
            // The newest frame lacks the axis.
            Some((at, missing)) if missing != axis.missing => at,
            _ => newest,
        };
        self.frame = Some((at, axis.missing));
        Some(Received {
            position: axis.received_position?,
            velocity: axis.received_velocity?,
            acceleration: axis.received_acceleration?,
            at,
            cycle_time,
            run: [node as u64, far.epoch?, far.restarts],
        })
    }

    /// Ends the run, and checks its final state.
    pub(super) fn end(&self, cycle: &WatchedCycle, axis: &FarAxisSignals, found: &mut Found) {
        // A braked axis has no master any more, in sync or not.
        let is_lost = axis.continuity == ContinuityState::Braking
            || (self.keeps_sync
                && self.was_synced
                && !axis.synced
                // An axis on its way back is not lost: the way takes as long as it is.
                && axis.continuity == ContinuityState::Following);
        if axis.error != 0 || is_lost {
            found.add(cycle, Invariant::EndsWell, axis.error.into(), 0.0);
        }
    }
}

/// Velocity of the plan that an axis moves by, or is brought to, u/s; none without a plan.
fn promised(axis: &FarAxisSignals) -> Option<f64> {
    let is_planned = axis.planned == Some(true);
    // The set values of the mode, before an axis on its way back is brought to them.
    let velocity = axis.received_velocity? - axis.velocity_diff?;
    is_planned.then_some(velocity)
}

/// Excess pace of the far time of TS5066's blocks: they follow their slopes, and remove the difference of a beat over their
/// blending cycles, at most the one that they tolerate.
fn pace_of_blocks(far: &FarConfig) -> f64 {
    let parameters = &far.sync.time_sync;
    let blending = parameters.time_mode_blending_cycles;
    // The faster of the two blends, and none of 0 cycles to divide by.
    let blending = blending.min(parameters.new_drift_bending_cycles).max(1);
    let beats = match parameters.max_cycle_index_difference {
        0.0 => MOST_BEATS,
        most => most,
    };
    let slope = parameters.slope1_numerator / parameters.slope1_denominator;
    (beats + slope) / f64::from(blending)
}

const fn mode_of(state: FilterState) -> FarAxisMode {
    match state {
        FilterState::Bypass => FarAxisMode::Bypass,
        FilterState::Pt1 => FarAxisMode::Pt1,
        FilterState::Sync | FilterState::Time => FarAxisMode::Blocks,
        FilterState::Observer => FarAxisMode::Observer,
    }
}
