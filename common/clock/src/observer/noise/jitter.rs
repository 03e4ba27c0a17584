//! The jitter of the messages: a normal part (the sender's waking, both signs) plus an exponential
//! part (the network's, late only), with both widths measured while running.
//!
//! The density of the sum is log-concave, so the most likely location of a handful of residuals is
//! unique and a few Newton steps find it. Far to the late side its score is constant: a spike of a
//! millisecond weighs no more than a message that is a little late.

use super::correlated_delay::CorrelatedDelay;
use super::hazard::Hazard;
use super::information::{Information, InformationTable, Scores};
use super::misfit::{Misfit, TUNING as MISFIT};
use super::pull::Pull;
use super::resolution::Widths;
use crate::numbers::{NearLogarithm, together};
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the model of the jitter.
    JitterTuning {
        /// Least width of either part, s.
        // A clock is read within that.
        least_width: f64 = 50e-9,
        /// Least normal width, as a part of the exponential one …
        least_ratio: f64 = 0.02,
        /// … and beside a loaded network, where the sender's jitter may be less.
        // The table of information begins at 0.004.
        least_ratio_under_load: f64 = 0.005,
        /// Greatest normal width, as a multiple of the exponential one.
        // The table of information ends at 3.2.
        greatest_ratio: f64 = 3.0,
        /// Messages that the widths are averages over.
        memory: f64 = 131_072.0,
        /// Messages that make known widths.
        // They are then known to 1/√4096, 1.6 %.
        settled: f64 = 4_096.0,
        /// Messages that the pull is an average over.
        pull_memory: f64 = 8_192.0,
        /// Residuals later than this many exponential widths are spikes and say nothing of the width.
        spike: f64 = 8.0,
        /// The location stays where it was at most by this many normal widths.
        // A first guess that was far off is given up.
        greatest_move: f64 = 2.0,
        /// Least information of a cell about the location, as a part of the mean.
        least_information: f64 = 0.01,
        /// Least information of a cell about a width.
        least_information_of_widths: f64 = 0.002,
        /// First guess of the ratio of the widths, and the least normal width in cells as a part of the other.
        first_ratio: f64 = 0.25,
        /// Least exponential width, as a part of a cell.
        // 1/√12 of it.
        first_cell_part: f64 = 0.3,
        /// The doubt of the widths is 1 + `doubt_messages`/(n + `doubt_offset`) after n messages.
        // 5 at first, 1.1 after 5000.
        doubt_messages: f64 = 512.0,
        /// See `doubt_messages`; messages that the averages of the pull begin with, too.
        doubt_offset: f64 = 128.0,
        /// Gain of a learning step over that of a plain mean.
        // With 3 the lock at a ratio of 0.05 takes 1.1 s instead of 0.7, p90.
        gain: f64 = 2.0,
        /// Messages that the gain begins with.
        gain_offset: f64 = 64.0,
        /// Greatest relative change of a width by one block.
        largest_step: f64 = 0.2,
        /// Information about a width that there is at least, per message.
        // Near a pure exponential the normal width has none.
        information_floor: f64 = 0.02,
        /// Newton steps end below this part of the normal width.
        tolerance: f64 = 0.02,
    }
}

/// Greatest width of the exponential part, s.
// Not tuned: a bound. The longest cycle; messages that are later in the mean are no stream of positions any more.
const GREATEST_WIDTH: f64 = 0.1;

/// Messages that make the first one, and the first guess of the jitter.
pub(in crate::observer) const FIRST_BLOCK: usize = 16;

/// Widths of the jitter, and the functions of it that estimation needs. Seconds.
#[derive(Clone, Debug)]
pub(in crate::observer) struct Jitter {
    hazard: Hazard,
    table: InformationTable,
    normal: f64,
    exponential: f64,
    /// `normal / exponential`
    ratio: f64,
    ratio_logarithm: NearLogarithm,
    /// Information of a message at this ratio.
    information: Information,
    pull: Pull,
    /// Movement of the most likely location because the widths were learned better.
    moved: f64,
    messages: f64,
    misfit: Misfit,
    /// True while the location stays where it was: until the widths, once known, change.
    pinned: bool,
    /// The cell that arrivals are stamped to, s; 0 if it is so fine that it does not matter.
    cell: f64,
    /// With cells: mean information of a message about the location, 1/s².
    certainty: f64,
    /// Mean information about the logarithms of the two widths.
    said_of_widths: [f64; 2],
}

/// Location of a block of messages.
#[derive(Clone, Copy, Debug)]
pub(in crate::observer) struct Location {
    /// The most likely location, given the residuals and what was known before.
    pub(in crate::observer) most_likely: f64,
    /// Location measured by the residuals alone, linearised there.
    pub(in crate::observer) measured: f64,
    /// Variance of `measured`.
    pub(in crate::observer) variance: f64,
}

const GUESS: f64 = 0.669;
const STEPS: usize = 6;

impl Jitter {
    pub(in crate::observer) fn new() -> Self {
        let hazard = Hazard::new();
        let table = InformationTable::new(&hazard);
        let mut jitter = Self {
            hazard,
            table,
            normal: 0.0,
            exponential: 0.0,
            ratio: 0.0,
            ratio_logarithm: NearLogarithm::ONE,
            information: Information::default(),
            pull: Pull::default(),
            moved: 0.0,
            messages: 0.0,
            misfit: Misfit::default(),
            pinned: true,
            cell: 0.0,
            certainty: 0.0,
            said_of_widths: [0.3; 2],
        };
        jitter.set(5e-6, 20e-6);
        jitter
    }

    /// A first guess from a few residuals.
    pub(in crate::observer) fn guess(&mut self, residuals: &[f64; FIRST_BLOCK]) {
        let mut sorted = *residuals;
        sorted.sort_unstable_by(f64::total_cmp);
        // Without the latest two, lest a spike be taken for the rule: their mean is above the least
        // by 0.67 of the exponential width, if that were all there is.
        let kept = &sorted[..residuals.len() - 2];
        let mean = kept.iter().sum::<f64>() / kept.len() as f64;
        let width = (mean - sorted[0]) / GUESS;
        // The widths are a guess again, and the next messages may change them by much.
        self.messages = 0.0;
        self.moved = 0.0;
        self.misfit = Misfit::default();
        self.pinned = true;
        self.set(TUNING.first_ratio * width, width);
        self.widen_to_cell();
        self.pull = Pull::beside(&self.information);
    }

    /// Widens the widths to the cell: far below it they are a guess from messages that all came in one cell.
    fn widen_to_cell(&mut self) {
        let width = self.exponential.max(TUNING.first_cell_part * self.cell);
        self.set(
            self.normal
                .max(TUNING.first_ratio * TUNING.first_cell_part * self.cell),
            width,
        );
        self.certainty = 1.0 / (self.fine_variance() + self.cell * self.cell / 12.0);
    }

    pub(in crate::observer) const fn normal(&self) -> f64 {
        self.normal
    }

    pub(in crate::observer) const fn exponential(&self) -> f64 {
        self.exponential
    }

    /// The standard deviation of the jitter.
    pub(in crate::observer) fn width(&self) -> f64 {
        together(self.normal, self.exponential)
    }

    /// Factor by which the widths may still be wrong: approaches 1.
    pub(in crate::observer) fn doubt(&self) -> f64 {
        1.0 + TUNING.doubt_messages / (self.messages + TUNING.doubt_offset)
    }

    /// Returns the movement of the most likely location so far, s, by what was learned of the widths. Taking it away
    /// leaves a location that stays where it was.
    pub(in crate::observer) const fn moved(&self) -> f64 {
        self.moved
    }

    /// Sets the cell that arrivals are stamped to, s; 0 if it does not matter.
    pub(in crate::observer) fn set_cell(&mut self, cell: f64) {
        let was_fine = self.cell == 0.0;
        self.cell = cell;
        if was_fine && cell > 0.0 {
            self.widen_to_cell();
        }
    }

    pub(in crate::observer) const fn cell(&self) -> f64 {
        self.cell
    }

    /// The variance of a location measured by a single message.
    pub(in crate::observer) fn variance(&self) -> f64 {
        if self.cell > 0.0 {
            1.0 / self.certainty
        } else {
            self.fine_variance()
        }
    }

    fn fine_variance(&self) -> f64 {
        self.normal * self.normal / self.information.curvature
    }

    const fn widths(&self) -> Widths {
        Widths {
            normal: self.normal,
            exponential: self.exponential,
        }
    }

    /// The location of a block, knowing beforehand that it is 0 with the given variance.
    pub(in crate::observer) fn locate(&self, residuals: &[f64], prior_variance: f64) -> Location {
        let n = residuals.len() as f64;
        let least = residuals.iter().copied().fold(f64::INFINITY, f64::min);
        // At this point the earliest message alone outweighs all others.
        let latest = least + self.cell + (n + 1.0) * self.normal * self.ratio;
        let certainty = 1.0 / prior_variance;
        // Newton steps on the log-posterior, which is concave: no step leads away for good.
        let mut location = 0.0_f64;
        let (mut score, mut curvature) = (0.0, 0.0);
        for _ in 0..STEPS {
            (score, curvature) = self.score(residuals, location);
            // Prior and likelihood: their slopes and curvatures add.
            let step = (score - location * certainty) / (curvature + certainty);
            // Far on the late side the curvature vanishes, and a step would lead to infinity.
            let next = (location + step).min(latest.max(0.0));
            let done = (next - location).abs() < TUNING.tolerance * self.normal;
            // Score at the new location to first order, which saves a pass over the residuals.
            score -= curvature * (next - location);
            location = next;
            if done {
                break;
            }
        }
        // The information of independent messages is known; a cell has much or little, depending on where in it the
        // location is.
        let variance = if self.cell > 0.0 {
            1.0 / curvature
        } else {
            self.variance() / n
        };
        Location {
            most_likely: location,
            // The estimate that residuals alone would give, as the filter weighs it against its own prior again.
            measured: location + score * variance,
            variance,
        }
    }

    /// The score of a location, and its negative slope there.
    fn score(&self, residuals: &[f64], location: f64) -> (f64, f64) {
        if self.cell > 0.0 {
            return self.cell_score(residuals, location);
        }
        let inverse = 1.0 / self.normal;
        let (mut scores, mut curvatures) = (0.0, 0.0);
        for residual in residuals {
            // Normal plus exponential: log f = −e/τ + log Φ(e/σ − σ/τ) but for constants, so its slope is the hazard φ/Φ less σ/τ.
            let z = (residual - location) * inverse - self.ratio;
            let h = self.hazard.at(z);
            scores += self.ratio - h;
            // Derivative of the hazard: −h·(z + h), which is between −1 and 0.
            curvatures += h * (z + h);
        }
        (scores * inverse, curvatures * inverse * inverse)
    }

    fn cell_score(&self, residuals: &[f64], location: f64) -> (f64, f64) {
        let widths = self.widths();
        let (mut score, mut curvature) = (0.0, 0.0);
        for residual in residuals {
            let cell = widths.cell(residual - location, self.cell);
            score += cell.location;
            curvature += cell.curvature;
        }
        (
            score,
            curvature + TUNING.least_information * residuals.len() as f64 * self.certainty,
        )
    }

    /// Learns from cells whose location is known, as [`learn`](Self::learn) does from residuals. The
    /// location is not kept where it was.
    fn learn_from_cells(&mut self, residuals: &[f64], location: f64) {
        let widths = self.widths();
        let (mut normal, mut exponential, mut curvature) = (0.0, 0.0, 0.0);
        let mut squares = [0.0; 2];
        for residual in residuals {
            let (of_normal, of_exponential) = widths.cell_widths(residual - location, self.cell);
            let of_normal = of_normal.clamp(-TUNING.spike, TUNING.spike);
            let of_exponential = of_exponential.clamp(-TUNING.spike, TUNING.spike);
            normal += of_normal;
            exponential += of_exponential;
            squares[0] += of_normal * of_normal;
            squares[1] += of_exponential * of_exponential;
            curvature += widths.cell(residual - location, self.cell).curvature;
        }
        let n = residuals.len() as f64;
        // Movement of the location by the widths is known for the exact likelihood alone.
        self.pinned = false;
        self.messages = (self.messages + n).min(TUNING.memory);
        let part = 1.0 / (self.messages + TUNING.doubt_offset).min(TUNING.pull_memory);
        self.certainty += part * (curvature - n * self.certainty);
        for (said, square) in self.said_of_widths.iter_mut().zip(squares) {
            *said += part * (square - n * *said);
        }
        let gain = TUNING.gain / (self.messages + TUNING.gain_offset);
        let step = |score: f64, said: f64| {
            (gain * score / said.max(TUNING.least_information_of_widths))
                .clamp(-0.5 * TUNING.largest_step, 0.5 * TUNING.largest_step)
        };
        let normal = step(normal, self.said_of_widths[0]);
        let exponential = step(exponential, self.said_of_widths[1]);
        self.set(
            self.normal * libm::exp(normal),
            self.exponential * libm::exp(exponential),
        );
    }

    /// Learns from residuals whose location is known: one step of Fisher scoring in the logarithms
    /// of both widths.
    pub(in crate::observer) fn learn(
        &mut self,
        residuals: &[f64],
        location: f64,
        correlated: &CorrelatedDelay,
    ) {
        if self.cell > 0.0 {
            self.learn_from_cells(residuals, location);
            return;
        }
        let inverse = 1.0 / self.normal;
        let (mut normal, mut exponential, mut change) = (0.0, 0.0, 0.0);
        let mut pull = Pull::default();
        for residual in residuals {
            let z = (residual - location) * inverse - self.ratio;
            let h = self.hazard.at(z);
            let scores = Scores::new(self.ratio, z, h);
            // A message that is far early or late says that it is a spike, not that the sender jitters more.
            normal += scores.normal.clamp(-TUNING.spike, TUNING.spike);
            exponential += scores.exponential.min(TUNING.spike);
            change += scores.exponential.min(MISFIT.late);
            pull.curvature += scores.slope;
            pull.normal += h - scores.slope * (z + 2.0 * self.ratio);
            pull.exponential += self.ratio * (scores.slope - 1.0);
        }
        let n = residuals.len() as f64;
        let i = self.information;
        // Without this block: its noise is in the steps below already.
        let known = self.pull;
        let part = 1.0 / (self.messages + TUNING.doubt_offset).min(TUNING.pull_memory);
        self.pull.approach(&pull, &i, n, part);
        self.notice_change(exponential, change, n, correlated);
        let (a, b, c) = (
            i.normal + TUNING.information_floor,
            i.both,
            i.exponential + TUNING.information_floor,
        );
        // Near the ends of the table both scores are nearly one, and the matrix nearly singular.
        let determinant = (a * c - b * b).max(0.1 * a * c);
        let gain = TUNING.gain / ((self.messages + TUNING.gain_offset) * determinant);
        let step = |x: f64| x.clamp(-TUNING.largest_step, TUNING.largest_step);
        let normal_step = step(gain * (c * normal - b * exponential));
        let exponential_step = step(gain * (a * exponential - b * normal));
        // exp(x) to second order: the steps are small.
        let grown = |x: f64| 1.0 + x + 0.5 * x * x;
        let before = (self.normal, self.exponential);
        self.set(
            before.0 * grown(normal_step),
            before.1 * grown(exponential_step),
        );
        // After the widths are set, as those change in any case.
        if !self.pinned {
            return;
        }
        let shift = known.shift(
            &i,
            self.normal / before.0 - 1.0,
            self.exponential / before.1 - 1.0,
        );
        let bound = TUNING.greatest_move * self.normal;
        self.moved = (self.moved + before.0 * shift).clamp(-bound, bound);
    }

    /// Counts the messages that make the widths: only few, once they no longer fit.
    fn notice_change(
        &mut self,
        score: f64,
        clipped: f64,
        messages: f64,
        correlated: &CorrelatedDelay,
    ) {
        let known = !self.pinned || self.messages >= TUNING.settled;
        let memory = self
            .misfit
            .take(score, clipped, messages, known, correlated);
        // A location that was right before fits a changed network too.
        self.pinned &= self.messages < TUNING.settled || memory.is_none();
        // Fewer messages make larger steps: the widths are learnt again within as many as have shown the change.
        self.messages = (self.messages + messages).min(memory.unwrap_or(TUNING.memory));
    }

    /// True if the network seems to be changing, so that measurements had better wait a little.
    pub(in crate::observer) fn is_unfit(&self) -> bool {
        self.misfit.is_waited_for()
    }

    fn set(&mut self, normal: f64, exponential: f64) {
        self.exponential = exponential.clamp(TUNING.least_width, GREATEST_WIDTH);
        let least = if self.pinned {
            TUNING.least_ratio
        } else {
            TUNING.least_ratio_under_load
        };
        let bounds = (
            TUNING.least_width.max(least * self.exponential),
            TUNING.greatest_ratio * self.exponential,
        );
        // The lower one is below the upper one, as the exponential width is at least `least_width` and the greatest ratio is above 1. With
        // constants perturbed by more (feature `perturb`) they could cross, and `clamp` would panic.
        self.normal = normal.clamp(bounds.0.min(bounds.1), bounds.1);
        self.ratio = self.normal / self.exponential;
        self.information = self.table.at(self.ratio_logarithm.of(self.ratio));
    }
}
