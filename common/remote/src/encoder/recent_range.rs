//! The range of the counts of a resting axis, without the old extremes of its vibration.
//!
//! Two extremes of a normal vibration, five standard deviations to either side, are together as wide as
//! the hysteresis. Among all samples of hours there are both; within a window they are not. A window
//! alone would miss a motion that is slower than it, so the means of the windows count as well: vibration
//! hardly moves them, and a drift does.

/// Samples of a window.
// Two samples of a normal vibration σ are 10 σ apart, 7.07 standard deviations of their difference, with a probability of
// 1.5e-12: with each of the 256 to 512 before it, once in 1.7e9 samples, 20 days at 1 kHz. Among all samples since the
// rest that was after 1.1e6, 19 minutes. Means of 256 deviate by σ/16 only.
const WINDOW: i64 = 256;

/// The range of the counts of the newest two windows, and of the means of all.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecentRange {
    previous: (i64, i64),
    current: (i64, i64),
    /// Lowest and highest mean of the windows before.
    means: Option<(i64, i64)>,
    /// First count of the current window, to which its sum is relative: a count of 64 bits would overflow it.
    origin: i64,
    sum: i64,
    samples: i64,
}

impl RecentRange {
    /// Makes the range of an axis that came to rest within these counts.
    pub(super) const fn of(range: (i64, i64)) -> Self {
        Self {
            previous: range,
            current: range,
            means: None,
            origin: range.0,
            sum: 0,
            samples: 0,
        }
    }

    /// Returns the lowest and the highest count.
    pub(super) fn ends(&self) -> (i64, i64) {
        let recent = union(self.previous, self.current);
        self.means.map_or(recent, |means| union(recent, means))
    }

    /// Adds the next count.
    pub(super) fn add(&mut self, count: i64) {
        if self.samples == WINDOW {
            self.close();
            (self.current, self.origin) = ((count, count), count);
            (self.sum, self.samples) = (0, 0);
        }
        self.current = union(self.current, (count, count));
        self.sum = self.sum.wrapping_add(count.wrapping_sub(self.origin));
        self.samples += 1;
    }

    /// Keeps the mean of the current window.
    fn close(&mut self) {
        self.previous = self.current;
        // Rounded outwards: a window in which the axis began to move keeps the count from which it did.
        let low = self.sum.div_euclid(self.samples);
        let high = low + i64::from(self.sum.rem_euclid(self.samples) > 0);
        let mean = (
            self.origin.wrapping_add(low),
            self.origin.wrapping_add(high),
        );
        self.means = Some(self.means.map_or(mean, |means| union(means, mean)));
    }
}

/// The range that has both.
fn union(one: (i64, i64), other: (i64, i64)) -> (i64, i64) {
    (one.0.min(other.0), one.1.max(other.1))
}
