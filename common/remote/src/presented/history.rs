//! The last frames of an axis, and its motion between them.

use coaxle_clock::{Seconds, Span};
use coaxle_curve::between::{Ends, between};
use coaxle_curve::profile::Kinematics;

/// Number of frames kept.
// 64 frames of a millisecond reach over every delay that a local network needs; 2.5 kB an axis.
const FRAMES: usize = 64;
/// Cycles that a presentation delay may take without a frame being left out: the rest are frames that are newer than
/// needed.
const FOR_DELAY: u64 = 60;

/// A frame of an axis.
#[derive(Clone, Copy, Debug)]
struct AxisFrame {
    count: u64,
    set: Kinematics,
    /// Time after its generation at which it is shown.
    delay: Span,
}

/// Set values of the last frames of an axis, by the count of their cycle.
///
/// Frames may come in any order. For a delay of more than 60 cycles, every second, fourth … frame is kept.
#[derive(Clone, Debug)]
pub struct FrameHistory {
    /// Cycle time of the sender, s.
    cycle: f64,
    /// Frames are kept whose count is a multiple of it, a power of two.
    // So a longer delay needs a part of those that are there, and a shorter one all of them: a delay that is slewed leaves no gap.
    stride: u64,
    /// A ring of frames in the order of their counts.
    frames: [AxisFrame; FRAMES],
    /// Place of the oldest one.
    first: usize,
    kept: usize,
    newest: Option<AxisFrame>,
}

/// Two neighbours in the history, and an instant between them.
struct FramesAround<'a> {
    before: &'a AxisFrame,
    after: &'a AxisFrame,
    /// Time between them, s, and the share of it that has passed at the instant.
    gap: f64,
    share: f64,
}

impl FrameHistory {
    /// Creates an empty history of a sender with this cycle time.
    #[must_use]
    pub fn new(cycle: Span) -> Self {
        Self {
            cycle: cycle.as_secs_f64(),
            stride: 1,
            frames: [AxisFrame {
                count: 0,
                set: Kinematics::at_rest(0.0),
                delay: Span::ZERO,
            }; FRAMES],
            first: 0,
            kept: 0,
            newest: None,
        }
    }

    /// Prepares it for a presentation delay and a cycle time of the sender. What it holds is kept, as far as it is needed; none of it with another cycle
    /// time.
    pub fn prepare(&mut self, delay: Span, cycle: Span) {
        let longest = cycle.as_nanos().max(1).unsigned_abs() * FOR_DELAY;
        // At most 4 s of cycles of 100 µs: 667, and so 1024.
        let delay = delay.as_nanos().max(0).unsigned_abs();
        let stride = delay.div_ceil(longest).max(1).next_power_of_two();
        let cycle = cycle.as_secs_f64();
        if cycle.to_bits() != self.cycle.to_bits() {
            self.cycle = cycle;
            self.clear();
        }
        if core::mem::replace(&mut self.stride, stride) < stride {
            self.thin_out();
        }
    }

    /// Leaves the frames whose counts are multiples of the stride.
    fn thin_out(&mut self) {
        let mut left = 0;
        for n in 0..self.kept {
            let frame = *self.frame(n);
            if frame.count.is_multiple_of(self.stride) {
                self.frames[(self.first + left) % FRAMES] = frame;
                left += 1;
            }
        }
        self.kept = left;
    }

    /// Forgets every frame: the next ones are unrelated to them.
    pub const fn clear(&mut self) {
        self.kept = 0;
        self.newest = None;
    }

    /// Takes the set values of a frame, and the time after its generation at which it is shown.
    pub fn take(&mut self, count: u64, set: &Kinematics, delay: Span) {
        let frame = AxisFrame {
            count,
            set: *set,
            delay,
        };
        if self.newest.is_none_or(|newest| count >= newest.count) {
            self.newest = Some(frame);
        }
        // Mostly all of them, and no division.
        if self.stride == 1 || count.is_multiple_of(self.stride) {
            self.insert(&frame);
        }
    }

    /// Replaces the delay of all frames: it is another one, not that of before slewed.
    pub fn restate(&mut self, delay: Span) {
        for frame in &mut self.frames {
            frame.delay = delay;
        }
        if let Some(newest) = &mut self.newest {
            newest.delay = delay;
        }
    }

    /// Returns the set values `behind` seconds before those of the newest frame; none if they lie before all frames, or
    /// after the newest.
    ///
    /// Without `by_acceleration` the accelerations of the frames are not used, as those of a measured axis are noise:
    /// the motion is then a cubic through position and velocity.
    #[must_use]
    pub fn at(&self, behind: f64, by_acceleration: bool) -> Option<Kinematics> {
        let at = self.around(behind)?;
        // The newest one itself: nothing lies between.
        if at.gap == 0.0 {
            return Some(at.after.set);
        }
        let ends = match by_acceleration {
            true => Ends::WithAccelerations,
            false => Ends::WithoutAccelerations,
        };
        Some(between(
            &at.before.set,
            &at.after.set,
            at.gap,
            at.share,
            ends,
        ))
    }

    /// True if a frame beside that instant is missing: lost, or not arrived.
    #[must_use]
    pub fn is_missing(&self, behind: f64) -> bool {
        let kept = self.stride as f64 * self.cycle;
        // Half a cycle more, as a gap is a whole number of cycles.
        (self.around(behind)).is_none_or(|at| at.gap > kept + 0.5 * self.cycle)
    }

    /// Returns the delay of the frames at that instant. Where it is slewed, it is not yet that of the newest frame.
    #[must_use]
    pub fn delay_at(&self, behind: f64) -> Option<Seconds> {
        let at = self.around(behind)?;
        let [before, after] = [at.before, at.after].map(|frame| frame.delay.as_secs_f64());
        Some(Seconds(before + (after - before) * at.share))
    }

    /// The neighbours of an instant `behind` seconds before the newest frame.
    fn around(&self, behind: f64) -> Option<FramesAround<'_>> {
        let newest = self.newest.as_ref()?;
        let back = behind / self.cycle;
        // Of NaN, too, there is none.
        if !(0.0..=LONGEST).contains(&back) {
            return None;
        }
        let whole = back as u64;
        let cycles = whole + u64::from(whole as f64 != back);
        if cycles == 0 {
            return Some(FramesAround {
                before: newest,
                after: newest,
                gap: 0.0,
                share: 0.0,
            });
        }
        let before = self.at_or_before(newest.count.checked_sub(cycles)?)?;
        let after = match before + 1 < self.kept {
            true => self.frame(before + 1),
            false => newest,
        };
        let before = self.frame(before);
        let gap = (after.count - before.count) as f64;
        // Over so long a gap nothing is known, nor over a count that makes no sense.
        if gap > LONGEST {
            return None;
        }
        Some(FramesAround {
            before,
            after,
            gap: gap * self.cycle,
            share: ((newest.count - before.count) as f64 - back) / gap,
        })
    }

    /// The n-th frame, from the oldest one on.
    const fn frame(&self, n: usize) -> &AxisFrame {
        &self.frames[(self.first + n) % FRAMES]
    }

    /// Number of the last frame up to this count.
    fn at_or_before(&self, count: u64) -> Option<usize> {
        let last = self.kept.checked_sub(1)?;
        let newest = self.frame(last).count;
        let ahead = match self.stride {
            1 => newest.saturating_sub(count),
            stride => newest.saturating_sub(count).div_ceil(stride),
        };
        // Counts differ by the stride at least: the frame that many places before the last one is not later.
        let mut n = last - usize::try_from(ahead).unwrap_or(last).min(last);
        if self.frame(n).count > count {
            return None;
        }
        // Frames that were lost since make it an earlier one.
        while n < last && self.frame(n + 1).count <= count {
            n += 1;
        }
        Some(n)
    }

    /// Inserts a frame behind those with lower counts: mostly it is the last one.
    fn insert(&mut self, frame: &AxisFrame) {
        let count = frame.count;
        let mut n = self.kept;
        while n > 0 && self.frame(n - 1).count > count {
            n -= 1;
        }
        if n > 0 && self.frame(n - 1).count == count {
            self.frames[(self.first + n - 1) % FRAMES] = *frame;
            return;
        }
        if self.kept == FRAMES {
            // Older than all of them: the one that is needed least.
            let Some(place) = n.checked_sub(1) else {
                return;
            };
            self.first = (self.first + 1) % FRAMES;
            self.kept -= 1;
            n = place;
        }
        for later in (n..self.kept).rev() {
            self.frames[(self.first + later + 1) % FRAMES] =
                self.frames[(self.first + later) % FRAMES];
        }
        self.frames[(self.first + n) % FRAMES] = *frame;
        self.kept += 1;
    }
}

/// Beyond this number of cycles there is no history: the longest delay and a silence of a second, in the shortest cycles.
const LONGEST: f64 = 50_000.0;

#[cfg(test)]
mod tests;
