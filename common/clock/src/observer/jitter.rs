//! The jitter of the messages: a normal part (the sender's waking, both signs) plus an exponential
//! part (the network's, late only), with both widths measured while running.
//!
//! The density of the sum is log-concave, so the most likely location of a handful of residuals is
//! unique and a few Newton steps find it. Far to the late side its score is constant: a spike of a
//! millisecond weighs no more than a message that is a little late.

use super::FIRST_BLOCK;
use super::hazard::Hazard;

/// Widths of the jitter, and the functions of it that estimation needs. Seconds.
#[derive(Clone, Debug)]
pub(super) struct Jitter {
    hazard: Hazard,
    normal: f64,
    exponential: f64,
    /// `normal / exponential`
    ratio: f64,
    /// Mean curvature of the log-likelihood, made dimensionless by both widths.
    curvature: f64,
    /// The information about the logarithms of both widths.
    information: Information,
    /// What a change of the logarithm of each width does to the mean score, times the exponential
    /// width.
    pull: Pull,
    /// By how much the most likely location moved because the widths were learned better.
    moved: f64,
    messages: f64,
    /// Mean score of the exponential width over the last messages: near 0 while it is right.
    misfit: f64,
}

#[derive(Clone, Copy, Debug)]
struct Pull {
    normal: f64,
    exponential: f64,
}

#[derive(Clone, Copy, Debug)]
struct Information {
    normal: f64,
    both: f64,
    exponential: f64,
}

/// What a block of messages says about its location.
#[derive(Clone, Copy, Debug)]
pub(super) struct Location {
    /// The most likely location, given the residuals and what was known before.
    pub(super) most_likely: f64,
    /// What the residuals alone measure, linearised there.
    pub(super) measured: f64,
}

const LEAST_NORMAL: f64 = 50e-9;
const MOST: f64 = 0.1;
const LEAST_RATIO: f64 = 0.02;
const MOST_RATIO: f64 = 3.0;
/// The widths are averages over the last so many messages.
const MEMORY: f64 = 131_072.0;
/// So many messages tell whether the width still fits; a mean score beyond this says no, and only so
/// many of the messages before still count.
const MISFIT_MEMORY: f64 = 256.0;
const MISFIT: f64 = 0.6;
const MEMORY_AFTER_CHANGE: f64 = 512.0;
const CURVATURE_MEMORY: f64 = 8_192.0;
/// Residuals later than this many exponential widths are spikes and say nothing of the width.
const SPIKE: f64 = 8.0;
/// The location stays where it was at most by this many normal widths: a first guess that was far
/// off is given up.
const MOST_MOVED: f64 = 2.0;
const GUESS: f64 = 0.669;
const STEPS: usize = 6;

impl Jitter {
    pub(super) fn new() -> Self {
        Self {
            hazard: Hazard::new(),
            normal: 5e-6,
            exponential: 20e-6,
            ratio: 0.25,
            curvature: 0.9,
            information: Information {
                normal: 0.3,
                both: 0.0,
                exponential: 0.9,
            },
            pull: Pull {
                normal: 0.0,
                exponential: 0.0,
            },
            moved: 0.0,
            messages: 0.0,
            misfit: 0.0,
        }
    }

    /// A first guess from a few residuals.
    pub(super) fn guess(&mut self, residuals: &[f64; FIRST_BLOCK]) {
        let mut sorted = *residuals;
        sorted.sort_unstable_by(f64::total_cmp);
        // Without the latest two, lest a spike be taken for the rule: their mean is above the least
        // by 0.67 of the exponential width, if that were all there is.
        let kept = &sorted[..residuals.len() - 2];
        let mean = kept.iter().sum::<f64>() / kept.len() as f64;
        let width = (mean - sorted[0]) / GUESS;
        self.messages = 0.0;
        self.moved = 0.0;
        self.set(0.25 * width, width);
    }

    pub(super) const fn normal(&self) -> f64 {
        self.normal
    }

    pub(super) const fn exponential(&self) -> f64 {
        self.exponential
    }

    /// By what factor the widths may still be wrong: little by little 1.
    pub(super) fn doubt(&self) -> f64 {
        1.0 + 512.0 / (self.messages + 128.0)
    }

    /// What is learned of the widths moves the most likely location. This is by how much it moved so
    /// far, s; who takes it away has a location that stays where it was.
    pub(super) const fn moved(&self) -> f64 {
        self.moved
    }

    /// The variance of a location measured by a single message.
    pub(super) fn variance(&self) -> f64 {
        self.normal * self.exponential / self.curvature
    }

    /// The location of a block, knowing beforehand that it is 0 with the given variance.
    pub(super) fn locate(&self, residuals: &[f64], prior_variance: f64) -> Location {
        let n = residuals.len() as f64;
        let least = residuals.iter().copied().fold(f64::INFINITY, f64::min);
        // At this point the earliest message alone outweighs all others.
        let latest = least + (n + 1.0) * self.normal * self.ratio;
        let certainty = 1.0 / prior_variance;
        let mut location = 0.0_f64;
        let mut score = 0.0;
        for _ in 0..STEPS {
            let (sum, curvature) = self.score(residuals, location);
            score = sum;
            let step = (score - location * certainty) / (curvature + certainty);
            let next = (location + step).min(latest.max(0.0));
            let done = (next - location).abs() < 0.02 * self.normal;
            score -= curvature * (next - location);
            location = next;
            if done {
                break;
            }
        }
        Location {
            most_likely: location,
            measured: location + score * self.variance() / n,
        }
    }

    /// The score of a location, and its negative slope there.
    fn score(&self, residuals: &[f64], location: f64) -> (f64, f64) {
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

    /// Learns from residuals whose location is known: one step of Fisher scoring in the logarithms
    /// of both widths.
    pub(super) fn learn(&mut self, residuals: &[f64], location: f64) {
        let inverse = 1.0 / self.normal;
        let (mut normal, mut exponential) = (0.0, 0.0);
        let (mut nn, mut ne, mut ee, mut curvature) = (0.0, 0.0, 0.0, 0.0);
        let (mut pull_n, mut pull_e) = (0.0, 0.0);
        for residual in residuals {
            let z = (residual - location) * inverse - self.ratio;
            let h = self.hazard.at(z);
            let slope = h * (z + h);
            let n = ((self.ratio - h) * (self.ratio - h) - slope).clamp(-SPIKE, SPIKE);
            let e = (self.ratio * (z + h)).min(SPIKE) - 1.0;
            normal += n;
            exponential += e;
            nn += n * n;
            ne += n * e;
            ee += e * e;
            curvature += slope;
            pull_n += h - slope * (z + 2.0 * self.ratio);
            pull_e += self.ratio * (slope - 1.0);
        }
        let n = residuals.len() as f64;
        self.messages = (self.messages + n).min(MEMORY);
        self.misfit += (exponential - n * self.misfit) / MISFIT_MEMORY;
        if self.misfit.abs() > MISFIT {
            // The network itself has changed.
            self.messages = self.messages.min(MEMORY_AFTER_CHANGE);
        }
        let part = 1.0 / (self.messages + 512.0).min(CURVATURE_MEMORY);
        self.curvature += part * (curvature / self.ratio - n * self.curvature);
        self.curvature = self.curvature.clamp(0.05, 4.0);
        self.pull.normal += part * (pull_n / self.ratio - n * self.pull.normal);
        self.pull.exponential += part * (pull_e / self.ratio - n * self.pull.exponential);
        let i = &mut self.information;
        i.normal += part * (nn - n * i.normal);
        i.both += part * (ne - n * i.both);
        i.exponential += part * (ee - n * i.exponential);
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
        let pull = self.pull.normal * (self.normal / before.0 - 1.0)
            + self.pull.exponential * (self.exponential / before.1 - 1.0);
        let bound = MOST_MOVED * self.normal;
        self.moved = (self.moved + before.0 * pull / self.curvature).clamp(-bound, bound);
    }

    fn set(&mut self, normal: f64, exponential: f64) {
        self.exponential = exponential.clamp(LEAST_NORMAL, MOST);
        let bounds = (
            LEAST_NORMAL.max(LEAST_RATIO * self.exponential),
            MOST_RATIO * self.exponential,
        );
        self.normal = normal.clamp(bounds.0.min(bounds.1), bounds.1);
        self.ratio = self.normal / self.exponential;
    }
}
