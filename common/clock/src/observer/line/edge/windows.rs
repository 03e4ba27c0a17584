//! The lowest phases of the last windows.

use super::Line;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the windows.
    EdgeWindowTuning {
        /// Length of a full window, s.
        // In 4 s with 8 points the edge of busy machines is known to 0.1 to 0.5 µs.
        longest: f64 = 0.512,
        /// Least number of messages of a window.
        fewest: u32 = 16,
        /// Factor by which the first windows are shorter, so that there is a line soon.
        shorter: u32 = 8,
        /// Messages of which one may be too early.
        // The fourth lowest of 512 is the point (with the lowest of 4096 the recording with SCHED_FIFO scatters by 2.5 µs, with the 17th lowest by
        // 0.1).
        messages_per_rank: u32 = 128,
        /// Scatter, s², from which windows are twice as long, and at each eight times of it again.
        // The drift that wanders over all points grows with the third power of the time.
        doubled_from: f64 = 1e-12,
    }
}

/// Windows kept.
pub(super) const KEPT: usize = 32;
/// The lowest of a window are kept: now and then a single message is earlier than it should.
const LOWEST: usize = 4;

/// A phase and when its message was due, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    pub(super) time: f64,
    pub(super) phase: f64,
}

#[derive(Clone, Copy, Debug)]
struct Window {
    /// In ascending order, as seen from the line.
    lowest: [Point; LOWEST],
    filled: u8,
    messages: u32,
    on_the_edge: bool,
}

impl Window {
    const EMPTY: Self = Self {
        lowest: [Point {
            time: 0.0,
            phase: 0.0,
        }; LOWEST],
        filled: 0,
        messages: 0,
        on_the_edge: false,
    };

    fn take(&mut self, point: Point, above: impl Fn(&Point) -> bool) {
        let filled = usize::from(self.filled);
        // Kept in order, as the rank that counts depends on the number of messages.
        let place = self.lowest[..filled]
            .iter()
            .position(above)
            .unwrap_or(filled);
        if place == LOWEST {
            return;
        }
        let last = filled.min(LOWEST - 1);
        self.lowest.copy_within(place..last, place + 1);
        self.lowest[place] = point;
        self.filled = (filled + 1).min(LOWEST) as u8;
    }

    fn point(&self) -> Point {
        // The first windows have few messages, and their lowest counts.
        let rank = (self.messages / TUNING.messages_per_rank).saturating_sub(1) as usize;
        self.lowest[rank.min(usize::from(self.filled.max(1)) - 1)]
    }
}

/// The lowest phases of the last windows, the oldest first.
#[derive(Clone, Debug)]
pub(super) struct Windows {
    kept: [Window; KEPT],
    len: usize,
    /// Messages of a window at present, and at last.
    length: u32,
    full: u32,
    open: Window,
    residuals: [f64; LOWEST],
    messages: u32,
}

impl Windows {
    pub(super) fn new(seconds_per_count: f64) -> Self {
        let full = (TUNING.longest / seconds_per_count) as u32;
        let full = full.max(TUNING.fewest);
        Self {
            kept: [Window::EMPTY; KEPT],
            len: 0,
            length: (full / TUNING.shorter).max(TUNING.fewest),
            full,
            open: Window::EMPTY,
            residuals: [f64::INFINITY; LOWEST],
            messages: 0,
        }
    }

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    /// Takes a message; returns whether the window is full.
    pub(super) fn take(&mut self, time: f64, phase: f64, residual: f64) -> bool {
        self.messages += 1;
        // Most messages are above all four and are done with here.
        if residual < self.residuals[LOWEST - 1] {
            let place = self.residuals.iter().position(|kept| residual < *kept);
            let place = place.unwrap_or(LOWEST - 1);
            self.residuals.copy_within(place..LOWEST - 1, place + 1);
            self.residuals[place] = residual;
            self.open.lowest.copy_within(place..LOWEST - 1, place + 1);
            self.open.lowest[place] = Point { time, phase };
            self.open.filled = (self.open.filled + 1).min(LOWEST as u8);
        }
        self.messages >= self.length
    }

    /// Closes the open window; returns its point.
    pub(super) fn close(&mut self, line: &Line, noise: f64) -> Point {
        let target = self.full * times(noise);
        if self.len == KEPT {
            // Merged in pairs, so that no point is lost while windows grow to their full length.
            if self.length * 2 <= target {
                self.merge_pairs(line);
                self.length *= 2;
            } else {
                // Once the scatter is smaller again, new windows are short, and the long ones leave with time.
                self.length = self.length.min(target);
                self.kept.copy_within(1.., 0);
                self.len -= 1;
            }
        }
        self.open.messages = self.messages;
        self.kept[self.len] = self.open;
        self.len += 1;
        self.open = Window::EMPTY;
        self.residuals = [f64::INFINITY; LOWEST];
        self.messages = 0;
        self.point(self.len - 1)
    }

    /// The point of a window.
    pub(super) fn point(&self, n: usize) -> Point {
        self.kept[n].point()
    }

    /// Iterates over the points, the oldest first.
    pub(super) fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.kept[..self.len].iter().map(Window::point)
    }

    /// Marks whether the newest point is on the edge.
    pub(super) const fn mark(&mut self, on_the_edge: bool) {
        self.kept[self.len - 1].on_the_edge = on_the_edge;
    }

    /// True if the point and those `lag` and twice `lag` windows before are on the edge.
    pub(super) fn are_on_the_edge(&self, end: usize, lag: usize) -> bool {
        [end, end - lag, end - 2 * lag]
            .iter()
            .all(|n| self.kept[*n].on_the_edge)
    }

    /// By how much the point in the middle misses the line through the other two, squared, as the
    /// variance of a single point, less what the drift does.
    pub(super) fn second_difference(&self, end: usize, lag: usize, drift_walk: f64) -> Option<f64> {
        let [first, middle, last] = [end - 2 * lag, end - lag, end].map(|n| self.point(n));
        let whole = last.time - first.time;
        if whole <= 0.0 {
            return None;
        }
        let part = (middle.time - first.time) / whole;
        let miss = middle.phase - first.phase - part * (last.phase - first.phase);
        // Taken off for the random walk of the drift, which grows with the third power of the time. Otherwise it would pass for noise.
        let by_drift = drift_walk * bend(whole, part);
        let weight = 1.0 + part * part + (1.0 - part) * (1.0 - part);
        Some(((miss * miss - by_drift) / weight).max(0.0))
    }

    /// Shifts all phases.
    pub(super) fn shift(&mut self, by: f64) {
        for window in self.kept[..self.len].iter_mut().chain([&mut self.open]) {
            for point in &mut window.lowest {
                point.phase += by;
            }
        }
    }

    /// Shifts the phases up to a time to a line. Windows merged since may hold others, too.
    pub(super) fn shift_until(&mut self, time: f64, by: f64, line: &Line) {
        let residual = |point: &Point| point.phase - line.offset_at(point.time);
        for window in &mut self.kept[..self.len] {
            let lowest = &mut window.lowest[..usize::from(window.filled)];
            for point in lowest.iter_mut().filter(|point| point.time <= time) {
                point.phase += by;
            }
            // Points of before and after the shift are in one window where windows were merged.
            lowest.sort_unstable_by(|a, b| residual(a).total_cmp(&residual(b)));
        }
    }

    /// Merges each two windows into one of double length.
    fn merge_pairs(&mut self, line: &Line) {
        let residual = |point: &Point| point.phase - line.offset_at(point.time);
        for pair in 0..KEPT / 2 {
            let (mut merged, other) = (self.kept[2 * pair], self.kept[2 * pair + 1]);
            for point in &other.lowest[..usize::from(other.filled)] {
                merged.take(*point, |kept| residual(point) < residual(kept));
            }
            merged.messages += other.messages;
            // The lowest of both is the point, and it is the one on the edge if either was.
            merged.on_the_edge |= other.on_the_edge;
            self.kept[pair] = merged;
        }
        self.len = KEPT / 2;
    }
}

/// Variance of the point that divides a time like this beside the line through its ends, s³, where the drift is a random walk of 1 s²/s³.
fn bend(whole: f64, part: f64) -> f64 {
    // A step of the drift after the time s moves the point by −(1−p)·s, and one that comes later than the point by −p·(T−s). The integral
    // of the squares is T³·p²·(1−p)²/3: T³/48 in the middle.
    let product = part * (1.0 - part);
    whole * whole * whole * product * product / 3.0
}

/// Factor on the length of windows whose points scatter so much that the drift, wandering over all that are kept,
/// does not matter.
fn times(noise: f64) -> u32 {
    match noise {
        noise if noise < TUNING.doubled_from => 1,
        noise if noise < 8.0 * TUNING.doubled_from => 2,
        noise if noise < 64.0 * TUNING.doubled_from => 4,
        _ => 8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal variables, as sums of twelve uniform ones (variance 1) of a linear congruential generator.
    fn normal(state: &mut u64) -> f64 {
        let uniform = |state: &mut u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(state)).sum::<f64>() - 6.0
    }

    #[test]
    fn a_drift_that_wanders_bends_the_phases_as_much_as_is_taken_off() {
        const STEPS: usize = 120;
        const RUNS: usize = 20_000;
        let (whole, mut state) = (6.0, 1);
        let step = whole / STEPS as f64;
        for middle in [STEPS / 2, STEPS / 3] {
            let part = middle as f64 / STEPS as f64;
            let mut sum = 0.0;
            for _ in 0..RUNS {
                let (mut drift, mut phase, mut at_middle) = (0.0, 0.0, 0.0);
                for n in 0..STEPS {
                    if n == middle {
                        at_middle = phase;
                    }
                    // The trapezoidal rule: the drift wanders within a step, too.
                    let before = drift;
                    drift += normal(&mut state) * libm::sqrt(step);
                    phase += 0.5 * (before + drift) * step;
                }
                let miss: f64 = at_middle - part * phase;
                sum += miss * miss;
            }
            let ratio = sum / RUNS as f64 / bend(whole, part);
            // The variance of 20 000 squares is known to √(2/20 000), 1 %.
            assert!((ratio - 1.0).abs() < 0.04, "{part}: {ratio}");
        }
        assert!((bend(2.0, 0.5) - 8.0 / 48.0).abs() < 1e-15);
    }
}
