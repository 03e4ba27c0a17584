//! Greatest error of a position between two frames.

use std::collections::VecDeque;

use crate::row::Row;

/// Hermite's quintic between two frames a time T apart is off by at most Δj·T³/768, where the jerk changes by Δj in
/// between: that much at a change in the middle (`coaxle_remote`'s `FrameHistory` has a test of it). Several changes add
/// up, by Peano's kernel.
const SHARE: f64 = 1.0 / 768.0;
/// Changes of the jerk in a ramp, in jerks: from 0 up, back, to the other end, and back.
const WHOLE_RAMP: f64 = 4.0;
/// Cycles of a sender that a receiver keeps the frames of one by one; of longer delays it leaves out some.
const KEPT: f64 = 60.0;
/// Time for which a gap between frames may be shown, s: longer than any delay.
const SHOWN_FOR: f64 = 5.0;

/// Error of an axis that is shown later: between two frames, of which some are lost.
#[derive(Debug)]
pub(super) struct InterpolationError {
    /// The master's greatest jerk, u/s³; unknown for a recorded motion.
    jerk: Option<f64>,
    /// Count of the newest frame.
    count: Option<u64>,
    /// Times of gaps, s, and their lengths in cycles of the sender: the longest ones since.
    gaps: VecDeque<(f64, u64)>,
}

impl InterpolationError {
    pub(super) fn new(jerk: Option<f64>) -> Self {
        Self {
            jerk,
            count: None,
            gaps: VecDeque::new(),
        }
    }

    /// Notes the newest frame of a cycle.
    pub(super) fn note(&mut self, row: &Row) {
        let Some(count) = row.record.far.count else {
            return;
        };
        let before = self.count.replace(count);
        let gap = before.and_then(|before| count.checked_sub(before));
        let Some(gap) = gap.filter(|gap| *gap > 0) else {
            return;
        };
        while (self.gaps.back()).is_some_and(|(_, shorter)| *shorter <= gap) {
            self.gaps.pop_back();
        }
        self.gaps.push_back((row.t_s, gap));
        while (self.gaps.front()).is_some_and(|(at, _)| *at < row.t_s - SHOWN_FOR) {
            self.gaps.pop_front();
        }
    }

    /// Greatest error in a cycle, u: none of an axis that is shown now.
    pub(super) fn most(&self, row: &Row) -> f64 {
        if row.record.axis.interpolated != Some(true) {
            return 0.0;
        }
        let (Some(jerk), Some(cycle_us)) = (self.jerk, row.record.far.cycle_time_us) else {
            return f64::INFINITY;
        };
        let cycle = cycle_us * 1e-6;
        let later = row.record.far.present_after_us.unwrap_or_default() * 1e-6;
        let left_out = ((later / (KEPT * cycle)).ceil() as u64).next_power_of_two() as f64;
        let lost = self.gaps.front().map_or(1, |(_, gap)| *gap);
        let gap = (left_out + lost as f64) * cycle;
        WHOLE_RAMP * jerk * gap * gap * gap * SHARE
    }
}
