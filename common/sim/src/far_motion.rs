//! Whether a far axis goes where its master can have gone, in every mode, by its own positions.

use crate::far_time::LARGEST_RATE_ERROR;

/// What a mode may add to the velocity of the master while it brings an axis back, as a share of the greatest velocity so far
/// (`coaxle_remote`'s `Continuity`).
const REJOINING: f64 = 0.5;
/// Seconds after which it is back however far away it was, by a curve whose steepest slope is this multiple of the mean.
const LONGEST: f64 = 30.0;
const STEEPEST: f64 = 1.875;
/// A quartic that takes an acceleration to rest in half a second goes faster on the way by at most 4/27 of that.
const BRAKING: f64 = 0.5 * 4.0 / 27.0;
/// How long what the master did unexpectedly is remembered, s: once and twice as long.
const MEMORY: f64 = 1.0;
/// Cycles after an event in which an axis that follows may still be on its way.
const LANDED: u8 = 3;
/// Frames are neighbours if they are less than this number of cycles of the master apart: some are always lost.
const NEXT: f64 = 4.5;
/// Frames after which it is known what the master can do.
const KNOWN: u8 = 16;
/// What the positions are rounded by, relative.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// How the set values of a far axis are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FarAxisMode {
    /// As they came, beats and all.
    Bypass,
    /// Filtered.
    Pt1,
    /// Moved in time by what the blocks of TS5066 make of the cycle indices.
    Blocks,
    /// Moved in time by what the phase observer says.
    Observer,
}

/// What an axis may do beside what its master does, by its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarMotionBounds {
    /// Of the receiver, s.
    pub cycle_time: f64,
    /// Over which a change of mode is blended, s.
    pub blending_time: f64,
    /// Time constant of the PT1 filter, s.
    pub filter_time: f64,
    /// By how much the far time of TS5066's blocks may pass faster than time: a share.
    pub pace_of_blocks: f64,
    /// The velocity that the axis may have of its own, u/s: one that has limits catches up with that. None that has none.
    pub own_velocity: Option<f64>,
    /// It is made of increments: where it is beside what was received is the smoothing's.
    pub is_smoothed: bool,
}

/// A far axis in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarMotion {
    /// Its position, u.
    pub position: f64,
    /// What the newest frame says.
    pub received: Received,
    /// The correction that moved it, s.
    pub correction: Option<f64>,
    /// How it was made.
    pub mode: FarAxisMode,
    /// Whether it is where its mode has it, and not braked, brought back or held by limits.
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
    /// Its cycle: the count times its cycle time, s.
    pub at: f64,
    /// Its cycle time, s.
    pub cycle_time: f64,
    /// Which node, and which run of it: frames of two say nothing of each other.
    pub run: [u64; 3],
}

/// A far axis that no mode explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarMotionFault {
    /// How far it went in a cycle, or how far it is from what was received, u.
    pub value: f64,
    /// How far it may, u.
    pub limit: f64,
}

/// Watches the positions of a far axis.
///
/// What the master can do is taken from its frames: the greatest velocity so far, the greatest acceleration between two frames, and
/// how far its positions and velocities are beside each other, which is what increments, beats of those before it and jumps leave.
///
/// Two things hold of every cycle:
///
/// * It goes no farther than the master's velocity has it, in the far time's pace, with what bringing it back, blending and its
///   own limits add. `bypass` and `pt1` also show what comes at once after a gap, and so does a blend from them.
/// * Where it follows, and no change of mode is blended over, it is no farther from what was received than the correction moves it,
///   with what a filter is behind.
#[derive(Clone, Copy, Debug)]
pub struct FarMotionCheck {
    bounds: FarMotionBounds,
    last: Option<FarMotion>,
    /// The frame of the master before the newest, and its acceleration there if the one before came, too.
    frame: Option<Received>,
    at_frame: Option<f64>,
    fastest: f64,
    acceleration: f64,
    corrections: Recent,
    /// By how much accelerations and velocities change from frame to frame, and positions beside what velocities say.
    acceleration_noise: Recent,
    velocity_noise: Recent,
    position_noise: Recent,
    /// Ways from frame to frame, as they are seen here.
    received_steps: Recent,
    followed: u8,
    frames: u8,
    /// How far it was from what was received at the most since it followed, u: the way back is as steep as that asks for.
    farthest: f64,
    /// For how long its mode has been the same, s, and how long ago it was one that shows what comes.
    unchanged_for: f64,
    shown_ago: f64,
}

impl FarMotionCheck {
    /// The check of an axis with these bounds.
    #[must_use]
    pub fn new(bounds: FarMotionBounds) -> Self {
        Self {
            bounds,
            last: None,
            frame: None,
            at_frame: None,
            fastest: 0.0,
            acceleration: 0.0,
            corrections: Recent::default(),
            acceleration_noise: Recent::default(),
            velocity_noise: Recent::default(),
            position_noise: Recent::default(),
            received_steps: Recent::default(),
            followed: 0,
            frames: 0,
            farthest: 0.0,
            unchanged_for: 0.0,
            shown_ago: 0.0,
        }
    }

    /// What comes next is of another run of the receiver, or nothing was shown.
    pub const fn restart(&mut self) {
        self.last = None;
        self.followed = 0;
    }

    /// The axis in the next cycle.
    pub fn push(&mut self, now: &FarMotion) -> Option<FarMotionFault> {
        let passed = f64::from(now.cycles.max(1)) * self.bounds.cycle_time;
        self.learn(now, passed);
        self.followed = match now.follows {
            true => (self.followed + 1).min(LANDED + 1),
            false => 0,
        };
        let last = self.last.replace(*now);
        self.learn_mode(now, last.as_ref(), passed);
        if !now.position.is_finite() {
            self.last = None;
        }
        if self.last.is_none() || self.frames < KNOWN {
            return None;
        }
        let beside = (now.position - now.received.position).abs();
        self.farthest = match self.followed > LANDED {
            true => beside,
            false => self.farthest.max(beside),
        };
        let largest = now.position.abs().max(now.received.position.abs());
        let rounding = ROUNDING * largest + f64::MIN_POSITIVE;
        let way = last.map(|last| FarMotionFault {
            value: (now.position - last.position).abs(),
            limit: self.way(now, passed),
        });
        let is_settled = self.followed > LANDED && !self.is_blending();
        let beside = (is_settled && !self.bounds.is_smoothed).then(|| FarMotionFault {
            value: (now.position - now.received.position).abs(),
            limit: self.leaves(),
        });
        let is_beyond = |fault: &FarMotionFault| fault.value > fault.limit + rounding;
        way.filter(is_beyond).or(beside.filter(is_beyond))
    }

    /// How it is made, and since when.
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

    /// Whether a change of mode may still be blended over. Skipped cycles are none of a blend.
    fn is_blending(&self) -> bool {
        self.unchanged_for <= self.blended_for()
    }

    /// For how long a change of mode is blended over, s: it begins and ends within a cycle.
    fn blended_for(&self) -> f64 {
        self.bounds.blending_time + 2.0 * self.bounds.cycle_time
    }

    /// What the newest frame says of the master.
    fn learn(&mut self, now: &FarMotion, passed: f64) {
        self.corrections
            .push(now.correction.unwrap_or(0.0).abs(), passed);
        let frame = now.received;
        self.fastest = self.fastest.max(frame.velocity.abs());
        let mut seen = [0.0; 4];
        if let Some(before) = self.frame.replace(frame)
            && before.run == frame.run
            && frame.at > before.at
        {
            let time = frame.at - before.at;
            let rate = (frame.velocity - before.velocity) / time;
            let changed = rate.abs() * time;
            let way = frame.position - before.position;
            let mean = 0.5 * (frame.velocity + before.velocity);
            self.acceleration = self.acceleration.max(rate.abs());
            // What velocities between these two can make of it is at most that (the trapezoidal rule); the rest is a jump.
            let explained = 0.25 * self.acceleration * time * time;
            let beside = ((way - mean * time).abs() - explained).max(0.0);
            // Over a gap it may change its velocity as it likes.
            let is_next = time < NEXT * frame.cycle_time;
            self.frames = KNOWN.min(self.frames + 1);
            let at_frame = is_next.then_some(rate);
            let turned = match (self.at_frame, at_frame) {
                (Some(before), Some(now)) => (now - before).abs(),
                _ => 0.0,
            };
            self.at_frame = at_frame;
            seen = [
                turned,
                if is_next { changed } else { 0.0 },
                beside,
                way.abs(),
            ];
        }
        let [turned, changed, beside, step] = seen;
        self.acceleration_noise.push(turned, passed);
        self.velocity_noise.push(changed, passed);
        self.position_noise.push(beside, passed);
        self.received_steps.push(step, passed);
    }

    /// How far it may go in this cycle, u.
    fn way(&self, now: &FarMotion, passed: f64) -> f64 {
        let FarMotionBounds {
            blending_time,
            filter_time,
            pace_of_blocks,
            own_velocity,
            cycle_time,
            ..
        } = self.bounds;
        let correction = self.corrections.largest();
        let velocity = self.fastest + self.acceleration * correction;
        let blended = velocity * (correction + filter_time + 3.0 * cycle_time);
        let pace = match now.mode {
            FarAxisMode::Bypass | FarAxisMode::Pt1 => 0.0,
            FarAxisMode::Blocks => pace_of_blocks,
            FarAxisMode::Observer => LARGEST_RATE_ERROR,
        };
        let velocity = velocity * (1.0 + pace + REJOINING)
            + BRAKING * self.acceleration
            + STEEPEST * self.farthest / LONGEST
            + blended / blending_time.max(cycle_time);
        let velocity = velocity.max(own_velocity.unwrap_or(0.0));
        // A blend from a mode that shows what comes still shows a part of that.
        let at_once = if self.shown_ago <= self.blended_for() {
            self.received_steps.largest()
        } else {
            0.0
        };
        velocity * passed + self.noise() + at_once
    }

    /// How far it may be from what was received, u.
    fn leaves(&self) -> f64 {
        let correction = self.corrections.largest();
        let velocity = self.fastest + self.acceleration * correction;
        let FarMotionBounds {
            filter_time,
            cycle_time,
            ..
        } = self.bounds;
        velocity * (correction + 2.0 * filter_time + 3.0 * cycle_time)
            + self.noise()
            + 2.0 * self.received_steps.largest()
    }

    /// What of its frames no motion explains, moved by the correction, u.
    fn noise(&self) -> f64 {
        let correction = self.corrections.largest();
        2.0 * self.position_noise.largest()
            + self.velocity_noise.largest() * correction
            + self.acceleration_noise.largest() * correction * correction
    }
}

/// The largest of the last one or two seconds.
#[derive(Clone, Copy, Debug, Default)]
struct Recent {
    now: f64,
    before: f64,
    since: f64,
}

impl Recent {
    fn push(&mut self, value: f64, passed: f64) {
        self.since += passed;
        if self.since >= MEMORY {
            (self.before, self.now, self.since) = (self.now, 0.0, 0.0);
        }
        self.now = self.now.max(value);
    }

    const fn largest(&self) -> f64 {
        self.now.max(self.before)
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

    /// A master that goes 500 u/s, received two cycles late.
    fn following(cycle: u32, mode: FarAxisMode) -> FarMotion {
        let at = f64::from(cycle) * T;
        let received = Received {
            position: 500.0 * at,
            velocity: 500.0,
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
            follows: true,
            cycles: 1,
        }
    }

    /// What is found, of motions that are changed in some cycles.
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
