//! The jitter of the messages: a normal part (the sender's waking, both signs) plus an exponential
//! part (the network's, late only), with both widths measured while running.
//!
//! The density of the sum is log-concave, so the most likely location of a handful of residuals is
//! unique and a few Newton steps find it. Far to the late side its score is constant: a spike of a
//! millisecond weighs no more than a message that is a little late.

use super::correlated_delay::CorrelatedDelay;
use super::hazard::Hazard;
use super::information::{Information, InformationTable, Scores};
use super::misfit::{LATE, Misfit};
use super::pull::Pull;
use super::resolution::Widths;
use crate::numbers::{NearLogarithm, together};

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

const LEAST_NORMAL: f64 = 50e-9;
const MOST: f64 = 0.1;
const LEAST_RATIO: f64 = 0.02;
/// Beside a loaded network the sender's jitter may be less.
const LEAST_RATIO_UNDER_LOAD: f64 = 0.005;
const MOST_RATIO: f64 = 3.0;
/// Messages that the widths are averages over.
const MEMORY: f64 = 131_072.0;
/// Messages that make known widths.
const SETTLED: f64 = 4_096.0;
/// Messages that the pull is an average over.
const PULL_MEMORY: f64 = 8_192.0;
/// Residuals later than this many exponential widths are spikes and say nothing of the width.
const SPIKE: f64 = 8.0;
/// The location stays where it was at most by this many normal widths: a first guess that was far
/// off is given up.
const MOST_MOVED: f64 = 2.0;
/// Least information of a cell, as a part of the mean.
const LEAST_SAID: f64 = 0.01;
const LEAST_SAID_OF_WIDTHS: f64 = 0.002;
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
        self.messages = 0.0;
        self.moved = 0.0;
        self.misfit = Misfit::default();
        self.pinned = true;
        self.set(0.25 * width, width);
        self.widen_to_cell();
        self.pull = Pull::beside(&self.information);
    }

    /// Widens the widths to the cell: far below it they are a guess from messages that all came in one cell.
    fn widen_to_cell(&mut self) {
        let width = self.exponential.max(0.3 * self.cell);
        self.set(self.normal.max(0.25 * 0.3 * self.cell), width);
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
        1.0 + 512.0 / (self.messages + 128.0)
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
        let mut location = 0.0_f64;
        let (mut score, mut curvature) = (0.0, 0.0);
        for _ in 0..STEPS {
            (score, curvature) = self.score(residuals, location);
            let step = (score - location * certainty) / (curvature + certainty);
            let next = (location + step).min(latest.max(0.0));
            let done = (next - location).abs() < 0.02 * self.normal;
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
            let z = (residual - location) * inverse - self.ratio;
            let h = self.hazard.at(z);
            scores += self.ratio - h;
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
            curvature + LEAST_SAID * residuals.len() as f64 * self.certainty,
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
            let of_normal = of_normal.clamp(-SPIKE, SPIKE);
            let of_exponential = of_exponential.clamp(-SPIKE, SPIKE);
            normal += of_normal;
            exponential += of_exponential;
            squares[0] += of_normal * of_normal;
            squares[1] += of_exponential * of_exponential;
            curvature += widths.cell(residual - location, self.cell).curvature;
        }
        let n = residuals.len() as f64;
        self.pinned = false;
        self.messages = (self.messages + n).min(MEMORY);
        let part = 1.0 / (self.messages + 128.0).min(PULL_MEMORY);
        self.certainty += part * (curvature - n * self.certainty);
        for (said, square) in self.said_of_widths.iter_mut().zip(squares) {
            *said += part * (square - n * *said);
        }
        let gain = 2.0 / (self.messages + 64.0);
        let step = |score: f64, said: f64| {
            (gain * score / said.max(LEAST_SAID_OF_WIDTHS)).clamp(-0.1, 0.1)
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
            normal += scores.normal.clamp(-SPIKE, SPIKE);
            exponential += scores.exponential.min(SPIKE);
            change += scores.exponential.min(LATE);
            pull.curvature += scores.slope;
            pull.normal += h - scores.slope * (z + 2.0 * self.ratio);
            pull.exponential += self.ratio * (scores.slope - 1.0);
        }
        let n = residuals.len() as f64;
        let i = self.information;
        // Without this block: its noise is in the steps below already.
        let known = self.pull;
        let part = 1.0 / (self.messages + 128.0).min(PULL_MEMORY);
        self.pull.approach(&pull, &i, n, part);
        self.notice_change(exponential, change, n, correlated);
        let (a, b, c) = (i.normal + 0.02, i.both, i.exponential + 0.02);
        let determinant = (a * c - b * b).max(0.1 * a * c);
        let gain = 2.0 / ((self.messages + 64.0) * determinant);
        let step = |x: f64| x.clamp(-0.2, 0.2);
        let normal_step = step(gain * (c * normal - b * exponential));
        let exponential_step = step(gain * (a * exponential - b * normal));
        // exp(x) to second order: the steps are small.
        let grown = |x: f64| 1.0 + x + 0.5 * x * x;
        let before = (self.normal, self.exponential);
        self.set(
            before.0 * grown(normal_step),
            before.1 * grown(exponential_step),
        );
        if !self.pinned {
            return;
        }
        let shift = known.shift(
            &i,
            self.normal / before.0 - 1.0,
            self.exponential / before.1 - 1.0,
        );
        let bound = MOST_MOVED * self.normal;
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
        let known = !self.pinned || self.messages >= SETTLED;
        let memory = self
            .misfit
            .take(score, clipped, messages, known, correlated);
        // A location that was right before fits a changed network too.
        self.pinned &= self.messages < SETTLED || memory.is_none();
        self.messages = (self.messages + messages).min(memory.unwrap_or(MEMORY));
    }

    /// True if the network seems to be changing, so that measurements had better wait a little.
    pub(in crate::observer) fn is_unfit(&self) -> bool {
        self.misfit.is_waited_for()
    }

    fn set(&mut self, normal: f64, exponential: f64) {
        self.exponential = exponential.clamp(LEAST_NORMAL, MOST);
        let least = if self.pinned {
            LEAST_RATIO
        } else {
            LEAST_RATIO_UNDER_LOAD
        };
        let bounds = (
            LEAST_NORMAL.max(least * self.exponential),
            MOST_RATIO * self.exponential,
        );
        self.normal = normal.clamp(bounds.0.min(bounds.1), bounds.1);
        self.ratio = self.normal / self.exponential;
        self.information = self.table.at(self.ratio_logarithm.of(self.ratio));
    }
}
