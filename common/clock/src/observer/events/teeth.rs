//! Arrivals on a grid that is coarser than the jitter.
//!
//! Messages that are polled for every millisecond have phases that are level for as long as it takes the sender's clock to gain or
//! lose one, and then jump by one: teeth of a saw. A line through them is level, and jumps again and again; the clock's own
//! line goes through their lower corners, as no message is seen before it comes. So a tooth that returns is no shift of the
//! path. From then on only corners are measurements: between them nothing says where in a cell the line is.

use super::shift::Bounds;
use crate::numbers::rounded;
use crate::observer::LARGEST_DRIFT;
use crate::observer::line::Estimate;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the teeth.
    TeethTuning {
        /// Jumps within this part of one size are alike, and of a cell's size …
        alike_within: f64 = 0.05,
        /// … and the intervals between them are equal within this part.
        regular_within: f64 = 0.5,
        /// Greatest climb of phases between teeth, as a part of one.
        // A path that swings climbs by as much as it jumps.
        level: f64 = 0.1,
        /// Greatest number of cells of a cycle, each `coarser` times as wide as the jitter, between which phases are level.
        // On a finer grid cells are a jitter like any other, and all is well up to a tenth of a cycle.
        // A path that grows steadily is followed in steps that are as small and regular.
        most_cells: i64 = 5,
        /// See `most_cells`.
        coarser: f64 = 4.0,
        /// A level that differs from another one by a cell does so within this part of it.
        of_cell: f64 = 0.25,
        /// Corners that their scatter about the line is learnt from.
        memory: f64 = 32.0,
        /// Before, it is taken for the jitter, and for no less than this part of a cell …
        first: f64 = 0.02,
        /// … with the weight of this number of corners …
        prior: f64 = 4.0,
        /// … and one counts as this multiple of the usual square at most.
        outlier: f64 = 9.0,
        /// Standard deviations outside of a cell from which a jump is no tooth.
        beyond: f64 = 5.0,
        /// A drift that one tooth shows lies between none and twice the half of it …
        of_one: f64 = 0.5,
        /// … and one that several show within this part.
        of_several: f64 = 0.2,
    }
}

/// Least variance of a corner, s².
// Not tuned: a floor, so that corners that agree by chance do not make the next one infinitely unlikely. 0.1 µs, sharper than a
// poller wakes up.
const LEAST_VARIANCE: f64 = 1e-14;

/// Jumps of one size and sign, …
const ALIKE: usize = 3;

/// A jump of the phase: when, by how much, and where the phases are since, s.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::observer) struct Jump {
    pub(in crate::observer) time: f64,
    pub(in crate::observer) size: f64,
    pub(in crate::observer) level: f64,
}

/// The last jumps, and the level of the last block.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::observer) struct Teeth {
    /// The oldest first.
    jumps: [Jump; ALIKE],
    known: usize,
    /// The phase of the newest block, s.
    level: f64,
    /// The variance of a corner, s², a mean over this number of them.
    corner: f64,
    corners: f64,
}

/// The drift that teeth show beside the level line, and its standard deviation, s/s.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct ShownDrift {
    pub(in crate::observer) drift: f64,
    pub(in crate::observer) sigma: f64,
}

/// The cell whose tooth a jump of the phase would be, s; none where it cannot be one.
pub(in crate::observer) fn cell_of(jump: f64, cycle: f64, jitter: f64) -> Option<f64> {
    // Pollers run at the cycle time or at a whole fraction of it. Other jumps are of the path.
    let cells = rounded(cycle / jump.abs()).max(1);
    let cell = cycle / cells as f64;
    let is_cell =
        cells <= TUNING.most_cells && (jump.abs() / cell - 1.0).abs() < TUNING.alike_within;
    (is_cell && cell >= TUNING.coarser * jitter).then_some(cell)
}

/// The variance of an estimate after `dt` seconds; it knows at least in which cell it is.
pub(in crate::observer) fn within_cell(estimate: &Estimate, dt: f64, walk: f64, cell: f64) -> f64 {
    let variance = estimate.offset_variance_after(dt, walk);
    // Variance of a uniform distribution over the cell: 1/12 of its square.
    variance.min(cell * cell / 12.0)
}

/// Bounds of phases that lie within a cell above a line of this standard deviation.
pub(in crate::observer) fn bounds(cell: f64, sigma: f64) -> Bounds {
    let unsure = TUNING.beyond * sigma;
    Bounds {
        early: -unsure,
        late: cell + unsure,
        above: cell + unsure,
        level: 0.0,
        patience: 1.0,
    }
}

/// The mean of the values in the lowest cell of a block.
pub(in crate::observer) fn lowest_level<const N: usize>(values: &[f64; N], cell: f64) -> f64 {
    let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let low = values.iter().filter(|value| **value < lowest + 0.5 * cell);
    let (sum, count) = low.fold((0.0, 0.0), |(sum, count), low| (sum + low, count + 1.0));
    sum / count
}

impl Teeth {
    /// Notes a jump of the phase.
    pub(in crate::observer) fn take(&mut self, jump: Jump) {
        self.jumps.copy_within(1.., 0);
        self.jumps[ALIKE - 1] = jump;
        self.known = (self.known + 1).min(ALIKE);
    }

    /// True if there was any jump.
    pub(in crate::observer) const fn is_known(&self) -> bool {
        self.known > 0
    }

    /// The time of the oldest jump, s.
    pub(in crate::observer) const fn since(&self) -> f64 {
        self.jumps[0].time
    }

    /// True if the last jumps are alike and come at regular intervals, and phases were level in between.
    pub(in crate::observer) fn return_regularly(&self) -> bool {
        let [first, middle, last] = self.jumps;
        let is_alike = |jump: &Jump| (jump.size / last.size - 1.0).abs() < TUNING.alike_within;
        let intervals = [middle.time - first.time, last.time - middle.time];
        let is_regular = (intervals[0] / intervals[1] - 1.0).abs() < TUNING.regular_within;
        // Levels of before and after, without the jumps between them.
        let climbed = last.level - first.level - middle.size - last.size;
        let is_level = climbed.abs() < TUNING.level * last.size.abs();
        self.known == ALIKE && [first, middle].iter().all(is_alike) && is_regular && is_level
    }

    /// Begins to measure corners; phases are at `level`, and the jitter is this wide, s.
    pub(in crate::observer) fn begin(&mut self, level: f64, cell: f64, jitter: f64) {
        let first = (TUNING.first * cell).max(jitter);
        self.level = level;
        self.corner = first * first;
        self.corners = TUNING.prior;
    }

    /// The variance of a corner, s².
    pub(in crate::observer) const fn corner_variance(&self) -> f64 {
        self.corner
    }

    /// Returns the corner in a block whose lowest phases are at `level`, and whose phases spread over `spread`, s;
    /// none where nothing jumped.
    pub(in crate::observer) fn corner(
        &mut self,
        level: f64,
        spread: f64,
        cell: f64,
    ) -> Option<f64> {
        let is_cell = |jump: f64| (jump.abs() / cell - 1.0).abs() < TUNING.of_cell;
        let jump = level - self.level;
        self.level = level;
        if is_cell(jump) {
            // The line goes through the lower corner: upwards that is the end of the level before.
            Some(level - jump.max(0.0))
        } else {
            is_cell(spread).then_some(level)
        }
    }

    /// Border that a line has left its cell by, if it has: phases are at `level`, nothing jumped, and the line is expected at `expected` with
    /// the variance `known`.
    // A message is seen after it came, and no later than with the next cell. Where the first tooth comes soon after the start it shows a
    // drift that is too great by any factor; the line then left its cell, a path was thought to have jumped, and every corner after it
    // belonged to another line. It stays at the border instead until the tooth is there, which then shows that very drift.
    pub(in crate::observer) fn border_left(
        &self,
        expected: f64,
        known: f64,
        level: f64,
        cell: f64,
    ) -> Option<f64> {
        let beyond =
            TUNING.beyond * libm::sqrt(self.corner) + libm::sqrt(known).min(TUNING.level * cell);
        if expected > level + beyond {
            Some(level)
        } else if expected < level - cell - beyond {
            Some(level - cell)
        } else {
            None
        }
    }

    /// Learns the variance of corners from one that was off by `off`, where the line has the variance `known`.
    pub(in crate::observer) fn learn(&mut self, off: f64, known: f64) {
        self.corners = (self.corners + 1.0).min(TUNING.memory);
        // Scatter about the line less what the line itself is unsure by. By chance that is negative.
        let sample = (off * off - known).clamp(0.0, TUNING.outlier * self.corner);
        self.corner += (sample - self.corner) / self.corners;
        self.corner = self.corner.max(LEAST_VARIANCE);
    }

    /// Drift shown by the teeth; the phases were level since the start, at 0, or since the jump before.
    pub(in crate::observer) fn shown_drift(&self) -> ShownDrift {
        let [_, before, last] = self.jumps;
        let one = last.size / (last.time - before.time);
        let (part, sigma) = match self.return_regularly() {
            // One tooth may have begun anywhere in its cell: half of the drift that it would show, and as much either way.
            true => (1.0, TUNING.of_several),
            false => (0.5, TUNING.of_one),
        };
        ShownDrift {
            drift: (part * one).clamp(-LARGEST_DRIFT, LARGEST_DRIFT),
            sigma: (sigma * one.abs()).min(LARGEST_DRIFT),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLE: f64 = 1e-3;
    const JITTER: f64 = 5e-6;

    #[test]
    fn a_jump_is_a_tooth_where_it_is_a_cell_of_a_poller() {
        let is_cell = |jump: f64| cell_of(jump, CYCLE, JITTER).is_some();
        // A poller takes a moment, so that a tooth is a little longer or shorter than its cell.
        assert!(is_cell(0.96e-3) && is_cell(-1.04e-3));
        assert!(!is_cell(0.94e-3) && !is_cell(1.06e-3));
        assert_eq!(cell_of(0.2e-3, CYCLE, JITTER), Some(0.2e-3));
        assert_eq!(cell_of(CYCLE / 6.0, CYCLE, JITTER), None);
    }

    #[test]
    fn in_wide_jitter_a_cell_is_no_level() {
        assert!(cell_of(1e-3, CYCLE, 0.22e-3).is_some());
        assert!(cell_of(1e-3, CYCLE, 0.30e-3).is_none());
    }

    /// Three jumps of a millisecond, the intervals between them and the climb of phases in the first one given, s.
    fn after_jumps(intervals: [f64; 2], climb: f64) -> Teeth {
        let mut teeth = Teeth::default();
        let times = [
            10.0,
            10.0 + intervals[0],
            10.0 + intervals[0] + intervals[1],
        ];
        for (n, time) in times.into_iter().enumerate() {
            let climbed = if n == 0 { 0.0 } else { climb };
            teeth.take(Jump {
                time,
                size: CYCLE,
                level: CYCLE * n as f64 + climbed,
            });
        }
        teeth
    }

    #[test]
    fn teeth_return_at_regular_intervals() {
        assert!(after_jumps([10.0, 10.0], 0.0).return_regularly());
        // A clock in a draught, and a path that jumps now and then.
        assert!(after_jumps([14.0, 10.0], 0.0).return_regularly());
        assert!(!after_jumps([16.0, 10.0], 0.0).return_regularly());
    }

    #[test]
    fn phases_are_level_between_teeth() {
        for sign in [1.0, -1.0] {
            assert!(after_jumps([10.0, 10.0], sign * 0.08e-3).return_regularly());
            // A path that swings climbs.
            assert!(!after_jumps([10.0, 10.0], sign * 0.12e-3).return_regularly());
        }
    }

    #[test]
    fn a_corner_is_where_the_level_changes_by_a_cell() {
        for (jump, is_corner) in [
            (0.8e-3, true),
            (0.7e-3, false),
            (1.2e-3, true),
            (1.3e-3, false),
        ] {
            let mut teeth = Teeth::default();
            teeth.begin(0.0, CYCLE, JITTER);
            assert_eq!(
                teeth.corner(jump, 0.0, CYCLE).is_some(),
                is_corner,
                "{jump}"
            );
            let mut teeth = Teeth::default();
            teeth.begin(0.0, CYCLE, JITTER);
            assert_eq!(
                teeth.corner(0.0, jump, CYCLE).is_some(),
                is_corner,
                "{jump}"
            );
        }
    }
}
