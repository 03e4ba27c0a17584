//! Choice of the line to follow: that of all messages, or the lower edge.
//!
//! As long as delays are independent the line of all messages is the best there is. Where they are
//! correlated, the line that predicts itself better is followed.

use super::edge;
use super::filter::Estimate;
use super::steadiness::Steadiness;
use crate::numbers::together;
use crate::observer::noise::Correlation;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the choice of a line.
    ChoiceTuning {
        /// Least uncertainty of a line, as a part of its usual miss, which two thirds of its misses do not exceed.
        // A miss is the difference of two errors, 4 s apart: √2 times one of them, where they are independent.
        missed: f64 = 0.45,
        /// Factor on the standard deviation of the edge.
        // Points on the edge are never quite independent.
        edge_doubt: f64 = 2.0,
        /// Least uncertainty of an edge that jumped, as a part of the jump …
        // One of both lines was wrong (telegraph 98.4 → 98.7 % within 3σ).
        jumped: f64 = 0.45,
        /// … which decays by this factor from look to look …
        // To 1/e in 10 s.
        jump_kept: f64 = 0.95,
        /// … and in 2 s as long as the line is still being found.
        // With 10 s the reported uncertainty of recordings was 1.5 times as large.
        early_jump_kept: f64 = 0.8,
        /// Factor by which the other line must be surer, at `looks` in a row.
        surer: f64 = 1.5,
        /// Looks in a row, 4 s, after which the edge is followed.
        looks: u8 = 8,
        /// Looks in a row, 12 s, after which the edge is left.
        // In a calm spell the other line seems surer.
        looks_from_edge: u8 = 24,
        /// Scatter of means that is no proof of correlation, but a sign.
        somewhat: f64 = 2.0,
        /// Scatter of means at which correlation is as good as certain, for the uncertainty.
        // One run in a hundred of independent delays reaches it.
        probable: f64 = 4.0,
        /// Number of small jumps of the delay within about `shifts_forgotten_after` that is a sign of correlation.
        // Only the third jump in a row passes.
        many_shifts: f64 = 2.2,
        /// Time after which a small jump counts as one that nothing followed, s.
        shifts_forgotten_after: f64 = 30.0,
        /// As long as the misses of the lines are unknown, an edge that is less sure than this number of widths of the jitter is none.
        found: f64 = 4.0,
        /// Uncertainty of an edge that is good enough not to be left, s.
        good_enough: f64 = 0.3e-6,
        /// From this time on, s, the lines are known well enough to go on where the other one was.
        // In drift_table, levels of the path from 15 s on: with 20 s far time was 9 µs off for good; observer_table, busy with correlated delays: 6.3
        // and 5.2 µs.
        known_after: f64 = 12.0,
        /// A jump of the delay leads back to the level of before if it misses that by less than this part of itself.
        same_level: f64 = 0.3,
    }
}

/// Standard deviation of a uniform distribution between 0 and 1: 1/√12.
const UNIFORM: f64 = 0.288_675_134_594_812_9;

/// Chooses the line to follow.
#[derive(Clone, Debug)]
pub(in crate::observer) struct Choice {
    correlation: Correlation,
    all: Steadiness,
    edge: Steadiness,
    by_edge: bool,
    /// Looks in a row that favoured the other line.
    contrary: u8,
    /// Offset added to the line that is followed, s.
    carry: f64,
    /// Largest jump of the edge of late, s.
    edge_jump: f64,
    /// Standard deviation left open by arrivals on a grid that is not known yet, s.
    cells_unseen: f64,
    /// Number of small jumps of late, and time of the last one, s.
    small_shifts: f64,
    last_small_shift: f64,
    /// Sum of the small jumps: height of the level that the line of all messages is on above that before them, s.
    level: f64,
}

impl Choice {
    pub(in crate::observer) fn new() -> Self {
        Self {
            correlation: Correlation::new(),
            all: Steadiness::new(),
            edge: Steadiness::new(),
            by_edge: false,
            contrary: 0,
            carry: 0.0,
            edge_jump: 0.0,
            cells_unseen: 0.0,
            small_shifts: 0.0,
            last_small_shift: 0.0,
            level: 0.0,
        }
    }

    /// Begins again with both lines. Known correlation of delays is kept.
    pub(in crate::observer) fn begin_anew(&mut self) {
        *self = Self {
            // The path is what it was, so whether its delays are correlated need not be learnt again.
            correlation: self.correlation.clone(),
            small_shifts: self.small_shifts,
            last_small_shift: self.last_small_shift,
            ..Self::new()
        };
    }

    /// True if the edge is followed.
    pub(in crate::observer) const fn is_edge(&self) -> bool {
        self.by_edge
    }

    /// True if the delays of consecutive messages are correlated.
    pub(in crate::observer) const fn is_correlated(&self) -> bool {
        self.correlation.is_correlated()
    }

    /// True if there is a sign of correlation, though no proof.
    pub(in crate::observer) fn may_be_correlated(&self) -> bool {
        self.correlation.ratio() > TUNING.somewhat
    }

    /// Probability that delays are correlated, 0 to 1.
    fn suspicion(&self) -> f64 {
        if self.is_correlated() {
            return 1.0;
        }
        ((self.correlation.ratio() - TUNING.somewhat) / (TUNING.probable - TUNING.somewhat))
            .clamp(0.0, 1.0)
    }

    /// Offset to be added to the line that is followed, s.
    pub(in crate::observer) const fn carry(&self) -> f64 {
        self.carry
    }

    /// Takes the residual of a message, s.
    pub(in crate::observer) fn observe(&mut self, residual: f64) {
        self.correlation.take(residual);
    }

    /// Takes delays to be correlated.
    #[cfg(test)]
    const fn assume_correlated(&mut self) {
        self.correlation.assume();
    }

    /// Takes a small jump of the delay at `time`, s: if delays seem to be somewhat correlated, or jumps come again and
    /// again, they are taken to be correlated.
    pub(in crate::observer) fn suspect_small_shift(&mut self, time: f64, by: f64) {
        let since = (time - self.last_small_shift).max(0.0);
        let forgotten = libm::exp(-since / TUNING.shifts_forgotten_after);
        let level = self.level_at(time) + by;
        // The level of before, as far as some messages show it.
        let is_same = libm::fabs(level) < TUNING.same_level * libm::fabs(by);
        self.level = if is_same { 0.0 } else { level };
        self.small_shifts = 1.0 + self.small_shifts * forgotten;
        self.last_small_shift = time;
        if self.correlation.ratio() > TUNING.somewhat || self.small_shifts > TUNING.many_shifts {
            self.correlation.assume();
        }
    }

    /// Level of the path that the line of all messages is on, s. A jump that nothing followed was for good.
    fn level_at(&self, time: f64) -> f64 {
        if time - self.last_small_shift < TUNING.shifts_forgotten_after {
            self.level
        } else {
            0.0
        }
    }

    /// Notes that the edge jumped to another line: one of both is wrong, and it is not known yet which.
    pub(in crate::observer) fn edge_jumped(&mut self, by: f64) {
        self.edge_jump = self.edge_jump.max(libm::fabs(by));
    }

    /// Follows the line of all messages, moved by a jump of the clock or of the path.
    pub(in crate::observer) fn shift_all(&mut self, by: f64) {
        self.all.shift(by);
    }

    /// Follows the edge, likewise.
    pub(in crate::observer) fn shift_edge(&mut self, by: f64) {
        self.edge.shift(by);
    }

    /// Notes that something other than the sender decides when messages are seen: within `cell`, s, after they came, as they are
    /// polled at least that often. Any time in it is as likely.
    pub(in crate::observer) fn cells_unseen(&mut self, cell: f64) {
        self.cells_unseen = cell * UNIFORM;
    }

    /// Standard deviation of the line that is followed, if its filter has this variance, s.
    pub(in crate::observer) fn sigma(&self, offset_variance: f64) -> f64 {
        let (steadiness, doubt) = if self.by_edge {
            (&self.edge, TUNING.edge_doubt)
        } else {
            (&self.all, 1.0)
        };
        let sigma = doubt * libm::sqrt(offset_variance);
        let missed = TUNING.missed * self.suspicion() * steadiness.usual_miss().unwrap_or(0.0);
        let jumped = if self.by_edge {
            TUNING.jumped * self.edge_jump
        } else {
            0.0
        };
        // The greatest of the three, as a jump of the edge is a miss, too, and would count twice.
        together(sigma, missed.max(jumped).max(self.cells_unseen))
    }

    /// Looks at both lines as they are at `time`, `age` seconds after the start. Returns the jump of the line that is
    /// followed, s: where the other one is chosen early, or is off by more than the `width` of the jitter.
    pub(in crate::observer) fn judge(
        &mut self,
        time: f64,
        age: f64,
        all: &Estimate,
        edge: &edge::Line,
        width: f64,
    ) -> f64 {
        let edge_offset = edge.offset_at(time);
        // Both lines are looked at whichever is followed, or the other one could never be chosen.
        let looked = self.all.look(time, all.offset, all.drift);
        if self.edge.look(time, edge_offset, edge.estimate.drift) {
            self.edge_jump *= if age > TUNING.known_after {
                TUNING.jump_kept
            } else {
                TUNING.early_jump_kept
            };
        }
        let by_edge = self.wants_edge(all, edge, width);
        if by_edge == self.by_edge {
            self.contrary = 0;
            return 0.0;
        }
        // Only at looks: blocks come a hundred times a second, and judge one and the same state of the lines.
        self.contrary += u8::from(looked);
        // Without correlation the line of all messages is at the bound, and waiting gains nothing.
        let hesitates = self.correlation.is_correlated() && self.edge.usual_miss().is_some();
        let looks = if self.by_edge {
            TUNING.looks_from_edge
        } else {
            TUNING.looks
        };
        if hesitates && self.contrary < looks {
            return 0.0;
        }
        self.contrary = 0;
        self.by_edge = by_edge;
        // Height of the line to follow above the one that was followed.
        let raw = if by_edge {
            edge_offset - all.offset
        } else {
            all.offset - edge_offset
        };
        // The edge is the path's lowest level, and far time was on it before the jumps between levels began.
        let level = if by_edge { self.level_at(time) } else { 0.0 };
        let difference = raw + level - self.carry;
        if age > TUNING.known_after && libm::fabs(difference) < width {
            self.carry = -difference;
            -level
        } else {
            self.carry = 0.0;
            difference - level
        }
    }

    fn wants_edge(&self, all: &Estimate, edge: &edge::Line, width: f64) -> bool {
        if !self.correlation.is_correlated() {
            return false;
        }
        // To leave the edge the worst misses count, to enter it the latest: correlated delays return after a calm spell.
        let all_miss = if self.by_edge {
            self.all.lasting_miss()
        } else {
            self.all.usual_miss()
        };
        let (Some(all_miss), Some(edge_miss)) = (all_miss, self.edge.usual_miss()) else {
            let [all, edge] = [all, &edge.estimate].map(|line| libm::sqrt(line.offset_variance));
            return edge < TUNING.found * width.max(all);
        };
        let all = libm::sqrt(all.offset_variance).max(TUNING.missed * all_miss);
        let edge = libm::sqrt(edge.estimate.offset_variance).max(TUNING.missed * edge_miss);
        if self.by_edge {
            // In a calm spell the other line may seem surer, until the next storm.
            edge < TUNING.surer * all.max(TUNING.good_enough)
        } else {
            // Both directions need this factor, or lines that are equally good would be changed at every look.
            TUNING.surer * edge < all
        }
    }
}

#[cfg(test)]
mod tests;
