//! Check that a far axis moves where its master can have moved, in every mode, by its own positions.

mod master_dynamics;

use crate::far_time::LARGEST_RATE_ERROR;
use master_dynamics::MasterDynamics;

/// Velocity that a mode may add to the master's while an axis rejoins, as a share of the greatest
/// velocity seen (`coaxle_remote`'s `Continuity`).
const REJOINING: f64 = 0.5;
/// Longest time of rejoining a master that has moved, and one that has not, s, by a curve with this ratio of the steepest to
/// the mean slope.
const LONGEST: f64 = 3_600.0;
const TO_A_RESTING_MASTER: f64 = 30.0;
const STEEPEST: f64 = 1.875;
/// Velocity gain of a quartic that takes an acceleration to rest in half a second: at most 4/27 of
/// acceleration · time, and no more than the greatest velocity of the master.
const BRAKING: f64 = 0.5 * 4.0 / 27.0;
/// Cycles after an event in which an axis that follows may still be in transition.
const LANDED: u8 = 3;
/// Rounding of the positions, relative.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Origin of the set values of a far axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FarAxisMode {
    /// As received, including beats.
    Bypass,
    /// Filtered.
    Pt1,
    /// Moved in time by the cycle indices, by the blocks of TS5066.
    Blocks,
    /// Moved in time by the phase observer.
    Observer,
}

/// Motion allowed to an axis in addition to its master's, by its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarMotionBounds {
    /// Cycle time of the receiver, s.
    pub cycle_time: f64,
    /// Time over which a change of mode is blended, s.
    pub blending_time: f64,
    /// Time constant of the PT1 filter, s.
    pub filter_time: f64,
    /// Greatest gain of the far time of TS5066's blocks over time, a share.
    pub pace_of_blocks: f64,
    /// Own velocity limit of the axis, u/s, with which it catches up; none without limits.
    pub own_velocity: Option<f64>,
    /// True for an axis made of increments, whose distance from the received position depends on
    /// the smoothing.
    pub is_smoothed: bool,
}

/// A far axis in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarMotion {
    /// Position, u.
    pub position: f64,
    /// Values of the newest frame.
    pub received: Received,
    /// The correction that moved it, s.
    pub correction: Option<f64>,
    /// Origin of the set values.
    pub mode: FarAxisMode,
    /// Velocity promised by the plan that it moves by, u/s, before the frames show it; none without a plan. Whether the
    /// promise is kept shows the position of the master.
    pub promised: Option<f64>,
    /// True if it is at the position of its mode: not braked, rejoining or held by limits.
    pub follows: bool,
    /// Own cycles since the cycle before.
    pub cycles: u32,
}

/// The master in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// Set position, u.
    pub position: f64,
    /// Set velocity, u/s.
    pub velocity: f64,
    /// Set acceleration, u/s².
    pub acceleration: f64,
    /// Time of its cycle: the count times its cycle time, s.
    pub at: f64,
    /// Cycle time, s.
    pub cycle_time: f64,
    /// Node and run: frames of different ones are not compared.
    pub run: [u64; 3],
}

/// A far axis whose motion no mode explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarMotionFault {
    /// Distance moved in a cycle, or distance from the received position, u.
    pub value: f64,
    /// Greatest allowed distance, u.
    pub limit: f64,
}

/// Monitors the positions of a far axis.
///
/// The master's dynamics are taken from its frames: the greatest velocity, the greatest
/// acceleration, stated or between two frames, and the mismatch of its positions and velocities, which
/// comes from increments, beats of upstream nodes and jumps.
///
/// Two bounds apply to every cycle:
///
/// * It moves no farther than the master's velocity allows, at the rate of the far time, plus
///   rejoining, blending and its own limits. `bypass` and `pt1` also show the step after a gap, and
///   so does a blend from them.
/// * While it follows without blending, its distance from the received position is at most that of
///   the correction, plus the lag of a filter.
#[derive(Clone, Copy, Debug)]
pub struct FarMotionCheck {
    bounds: FarMotionBounds,
    last: Option<FarMotion>,
    master: MasterDynamics,
    followed: u8,
    /// Greatest distance from the received position since it followed, u: the steepness of the
    /// return depends on it.
    farthest: f64,
    /// Time since the last change of its mode, s, and since the last mode that shows received values.
    unchanged_for: f64,
    shown_ago: f64,
}

impl FarMotionCheck {
    /// Creates the check of an axis with these bounds.
    #[must_use]
    pub fn new(bounds: FarMotionBounds) -> Self {
        Self {
            bounds,
            last: None,
            master: MasterDynamics::new(),
            followed: 0,
            farthest: 0.0,
            unchanged_for: 0.0,
            shown_ago: 0.0,
        }
    }

    /// Restarts the check: another run of the receiver, or no axis shown.
    pub const fn restart(&mut self) {
        self.last = None;
        self.followed = 0;
    }

    /// Takes the axis in the next cycle.
    pub fn push(&mut self, now: &FarMotion) -> Option<FarMotionFault> {
        let passed = f64::from(now.cycles.max(1)) * self.bounds.cycle_time;
        self.master.learn(now, passed);
        self.followed = match now.follows {
            // Counts to just beyond the limit, so that u8 never overflows.
            true => (self.followed + 1).min(LANDED + 1),
            false => 0,
        };
        let last = self.last.replace(*now);
        self.learn_mode(now, last.as_ref(), passed);
        // A position that is no number makes every difference one that exceeds nothing; other checks report it.
        if !now.position.is_finite() {
            self.last = None;
        }
        // Bounds taken from too few frames are those of chance.
        if self.last.is_none() || !self.master.is_known() {
            return None;
        }
        let beside = (now.position - now.received.position).abs();
        self.farthest = match self.followed > LANDED {
            // Reset by settling, kept over an excursion: the return is as steep as its largest distance requires.
            true => beside,
            false => self.farthest.max(beside),
        };
        let largest = now.position.abs().max(now.received.position.abs());
        // Above 0 even at the position 0, where a relative tolerance vanishes.
        let rounding = ROUNDING * largest + f64::MIN_POSITIVE;
        let way = last.map(|last| FarMotionFault {
            value: (now.position - last.position).abs(),
            limit: self.way(now, passed),
        });
        let is_settled = self.followed > LANDED && !self.is_blending();
        // An axis made of increments is off by its smoothing, which the bounds do not contain.
        let beside = (is_settled && !self.bounds.is_smoothed).then(|| FarMotionFault {
            value: (now.position - now.received.position).abs(),
            limit: self.leaves(),
        });
        let is_beyond = |fault: &FarMotionFault| fault.value > fault.limit + rounding;
        // A jump explains the distance that follows from it, and is reported first.
        way.filter(is_beyond).or(beside.filter(is_beyond))
    }

    /// Notes the origin of the set values, and its duration.
    fn learn_mode(&mut self, now: &FarMotion, last: Option<&FarMotion>, passed: f64) {
        let is_same = last.is_some_and(|last| last.mode == now.mode);
        self.unchanged_for = if is_same {
            self.unchanged_for + passed
        } else {
            0.0
        };
        self.shown_ago = match now.mode {
            FarAxisMode::Bypass | FarAxisMode::Pt1 => 0.0,
            FarAxisMode::Blocks | FarAxisMode::Observer => self.shown_ago + passed,
        };
    }

    /// True if a change of mode may still be blended. Skipped cycles do not count for a blend.
    fn is_blending(&self) -> bool {
        self.unchanged_for <= self.blended_for()
    }

    /// Longest blending of a change of mode, s: it begins and ends within a cycle.
    fn blended_for(&self) -> f64 {
        self.bounds.blending_time + 2.0 * self.bounds.cycle_time
    }

    /// Greatest distance to move in this cycle, u.
    fn way(&self, now: &FarMotion, passed: f64) -> f64 {
        let FarMotionBounds {
            blending_time,
            filter_time,
            pace_of_blocks,
            own_velocity,
            cycle_time,
            ..
        } = self.bounds;
        let correction = self.master.corrections.largest();
        // An extrapolation over the correction adds the acceleration to the velocity for that time.
        let velocity = self.master.fastest + self.master.acceleration * correction;
        // Largest difference between two modes: correction, lag of the filter, and cycles in which each reads its
        // data.
        let blended = velocity * (correction + filter_time + 3.0 * cycle_time);
        let pace = match now.mode {
            FarAxisMode::Bypass | FarAxisMode::Pt1 => 0.0,
            FarAxisMode::Blocks => pace_of_blocks,
            FarAxisMode::Observer => LARGEST_RATE_ERROR,
        };
        let longest = if self.master.fastest > 0.0 {
            LONGEST
        } else {
            TO_A_RESTING_MASTER
        };
        let velocity = velocity * (1.0 + pace + REJOINING)
            + (BRAKING * self.master.acceleration).min(self.master.fastest)
            + STEEPEST * self.farthest / longest
            // Slope of a straight blend. A blending time of 0 is a step within one cycle.
            + blended / blending_time.max(cycle_time);
        // A limited axis catches up with its own velocity, whatever its master does.
        let velocity = velocity.max(own_velocity.unwrap_or(0.0));
        // A blend from a mode that shows received values still contains a part of them.
        let at_once = if self.shown_ago <= self.blended_for() {
            self.master.received_steps.largest()
        } else {
            0.0
        };
        velocity * passed + self.master.noise() + at_once
    }

    /// Greatest distance from the received position, u.
    fn leaves(&self) -> f64 {
        let correction = self.master.corrections.largest();
        let velocity = self.master.fastest + self.master.acceleration * correction;
        let FarMotionBounds {
            filter_time,
            cycle_time,
            ..
        } = self.bounds;
        // Twice the filter: the axis lags behind, and the newest frame itself may be late by as much.
        velocity * (correction + 2.0 * filter_time + 3.0 * cycle_time)
            + self.master.noise()
            + 2.0 * self.master.received_steps.largest()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: f64 = 1e-3;

    fn bounds() -> FarMotionBounds {
        FarMotionBounds {
            cycle_time: T,
            blending_time: 0.06,
            filter_time: 3.0 * T,
            pace_of_blocks: 0.6,
            own_velocity: None,
            is_smoothed: false,
        }
    }

    /// A master at 500 u/s, received two cycles late.
    fn following(cycle: u32, mode: FarAxisMode) -> FarMotion {
        let at = f64::from(cycle) * T;
        let received = Received {
            position: 500.0 * at,
            velocity: 500.0,
            acceleration: 0.0,
            at,
            cycle_time: T,
            run: [1, 7, 0],
        };
        let correction =
            matches!(mode, FarAxisMode::Blocks | FarAxisMode::Observer).then_some(2.0 * T);
        let moved = 500.0 * correction.unwrap_or(0.0);
        FarMotion {
            position: received.position + moved,
            received,
            correction,
            mode,
            promised: None,
            follows: true,
            cycles: 1,
        }
    }

    /// Cycles with a fault, for motions that are changed in some cycles.
    fn found(mode: FarAxisMode, change: impl Fn(u32, &mut FarMotion)) -> Vec<u32> {
        let mut check = FarMotionCheck::new(bounds());
        let is_found = |cycle: &u32| {
            let mut motion = following(*cycle, mode);
            change(*cycle, &mut motion);
            check.push(&motion).is_some()
        };
        (0..2_000).filter(is_found).collect()
    }

    const MODES: [FarAxisMode; 4] = [
        FarAxisMode::Bypass,
        FarAxisMode::Pt1,
        FarAxisMode::Blocks,
        FarAxisMode::Observer,
    ];

    #[test]
    fn what_goes_as_its_master_passes() {
        for mode in MODES {
            assert_eq!(found(mode, |_, _| {}), [0; 0]);
        }
    }

    /// Swarm schedule 484: the first frame of a motion stated an acceleration and no velocity, and the axis was moved on by it.
    #[test]
    fn a_stated_acceleration_explains_what_it_moves_within_the_correction_and_no_more() {
        let (first, acceleration) = (1_000, -440.0);
        let begins = |share: f64| {
            found(FarAxisMode::Observer, |cycle, motion| {
                let begun = cycle >= first;
                motion.received.position = 0.0;
                motion.received.velocity = 0.0;
                motion.received.acceleration = if begun { acceleration } else { 0.0 };
                let moved = 0.5 * acceleration * (2.0 * T) * (2.0 * T);
                motion.position = if begun { share * moved } else { 0.0 };
            })
        };
        assert_eq!(begins(1.0), [0; 0]);
        assert_eq!(begins(20.0)[0], first);
    }

    #[test]
    fn a_step_that_no_mode_explains_is_found() {
        for mode in MODES {
            let stepped = found(mode, |cycle, motion| {
                motion.position += if cycle == 1_000 { 8.4 } else { 0.0 };
            });
            assert_eq!(stepped, [1_000, 1_001], "{mode:?}");
        }
    }

    #[test]
    fn an_axis_that_leaves_what_was_received_is_found_however_slowly() {
        for mode in MODES {
            let left = found(mode, |cycle, motion| {
                motion.position += 0.1 * f64::from(cycle.saturating_sub(1_000));
            });
            assert!(!left.is_empty() && left[0] < 1_120, "{mode:?}");
            assert_eq!(left.last(), Some(&1_999));
        }
    }

    #[test]
    fn one_that_is_brought_back_may_be_elsewhere_but_not_go_there_in_a_step() {
        let far = |cycle: u32, motion: &mut FarMotion| {
            motion.follows = false;
            let left = f64::from(1_000_u32.saturating_sub(cycle)) / 1_000.0;
            motion.position -= 200.0 * left;
        };
        assert_eq!(found(FarAxisMode::Observer, far), [0; 0]);
        let stepped = found(FarAxisMode::Observer, |cycle, motion| {
            far(cycle, motion);
            if cycle >= 500 {
                motion.position += 90.0;
            }
        });
        assert_eq!(stepped, [500]);
    }

    #[test]
    fn after_a_gap_bypass_shows_what_comes_at_once_and_nothing_beyond_it() {
        let gap = |cycle: u32, motion: &mut FarMotion| {
            if (1_000..1_050).contains(&cycle) {
                let ahead = motion.position - motion.received.position;
                motion.received = following(999, motion.mode).received;
                motion.position = motion.received.position + ahead;
            }
        };
        assert_eq!(found(FarAxisMode::Bypass, gap), [0; 0]);
        assert_eq!(found(FarAxisMode::Observer, gap), [1_050]);
        let beyond = found(FarAxisMode::Bypass, |cycle, motion| {
            gap(cycle, motion);
            motion.position += if cycle == 1_050 { 60.0 } else { 0.0 };
        });
        assert_eq!(beyond, [1_050, 1_051]);
    }

    #[test]
    fn increments_and_jumps_of_the_master_are_its_own() {
        for mode in MODES {
            let coarse = found(mode, |_, motion| {
                let ahead = motion.position - motion.received.position;
                motion.received.position = (motion.received.position / 40.0).floor() * 40.0;
                motion.position = motion.received.position + ahead;
            });
            assert_eq!(coarse, [0; 0], "{mode:?}");
            let jumped = found(mode, |cycle, motion| {
                let jump = if cycle >= 1_000 { 5_000.0 } else { 0.0 };
                motion.received.position += jump;
                motion.position += jump;
            });
            assert_eq!(jumped, [0; 0], "{mode:?}");
        }
    }
}
