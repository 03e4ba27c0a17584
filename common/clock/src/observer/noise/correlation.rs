//! Correlation of the delays of consecutive messages.
//!
//! The mean of n independent delays scatters by 1/√n of what a single one does, whatever their distribution; where
//! they are correlated it scatters more. Scatter is measured by second differences of consecutive means, in which a
//! drift does not show (D. W. Allan, Proc. IEEE 54, 1966), and of scores between −1 and 1, in which no message counts
//! for more than another.

use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the test for correlation.
    CorrelationTuning {
        /// Squares that the usual ones of means are over.
        memory: f64 = 24.0,
        /// Squares that the usual one of single messages is over.
        // Those of the longest mean.
        single_memory: f64 = 2_048.0,
        /// Before there are any, messages are taken to be independent, with the weight of this number.
        prior: f64 = 6.0,
        /// Greatest single square, as a multiple of the one of independent messages.
        outlier: f64 = 16.0,
        /// The spread of the residuals is followed this fast …
        step: f64 = 0.01,
        /// … and their middle slowly, within two seconds, or a delay that has levels for seconds would not show in the scores
        /// (telegraph of 13 µs beside 20 µs: 67 → 95 % within 3σ); but as fast when nearly all scores are on one side.
        middle_step: f64 = 0.0005,
        /// Mean of the scores that is nearly all on one side.
        one_sided: f64 = 0.8,
        /// Least spread that matters, s.
        // Below it the rest of finding the line and of rounding is correlated.
        least_spread: f64 = 1e-7,
        /// Scatter, as a multiple of the one of independent messages, that is no chance any more …
        // With 4 one run in a hundred of independent delays passes.
        correlated: f64 = 6.0,
        /// … and the scatter that may be chance; after `independent_for` messages with it they are independent again.
        independent: f64 = 2.0,
        /// Messages with such a scatter after which delays are independent again.
        // A minute at 1 ms. Calm spells of a busy machine are shorter.
        independent_for: u32 = 60_000,
    }
}

/// Messages per mean of the shortest scale; each of the others takes `LONGER` means of the one before: 128, 512 and
/// 2048 messages.
const SHORTEST: u16 = 32;
const LONGER: u16 = 4;
const SCALES: usize = 4;

/// Watches the residuals of messages for correlation.
#[derive(Clone, Debug)]
pub(in crate::observer) struct Correlation {
    middle: f64,
    spread: f64,
    /// Mean of the last scores.
    lean: f64,
    last: [f64; 2],
    messages: u32,
    /// Mean square of second differences of single messages.
    single: f64,
    scales: [Scale; SCALES],
    /// The largest scatter of means, as a multiple of the one of independent messages.
    ratio: f64,
    independent_for: u32,
    correlated: bool,
}

#[derive(Clone, Copy, Debug)]
struct Scale {
    /// Messages of a mean, and the number of sums that they come in.
    length: u16,
    parts: u16,
    sum: f64,
    summed: u16,
    means: [f64; 2],
    known: u8,
    /// Mean square of second differences, as a multiple of the one of independent messages.
    ratio: f64,
    count: f64,
}

impl Correlation {
    pub(in crate::observer) fn new() -> Self {
        Self {
            middle: 0.0,
            spread: 0.0,
            lean: 0.0,
            last: [0.0; 2],
            messages: 0,
            single: 0.5,
            scales: Scale::all(),
            ratio: 1.0,
            independent_for: 0,
            correlated: false,
        }
    }

    /// True if delays are correlated. Once they were, it takes long until they are taken to be independent.
    pub(in crate::observer) const fn is_correlated(&self) -> bool {
        self.correlated
    }

    /// Takes delays to be correlated, as something else showed.
    pub(in crate::observer) const fn assume(&mut self) {
        self.correlated = true;
        self.independent_for = 0;
    }

    /// The largest scatter of means, as a multiple of the one of independent messages.
    pub(in crate::observer) const fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Takes a residual, s.
    pub(in crate::observer) fn take(&mut self, residual: f64) {
        let deviation = residual - self.middle;
        let size = libm::fabs(deviation);
        // A plain mean at first: with the usual step the spread would take a hundred messages.
        let early = 1.0 / (f64::from(self.messages) + 1.0);
        let step = TUNING.step.max(early);
        if self.spread == 0.0 {
            self.spread = size;
        }
        let score = if self.spread > TUNING.least_spread {
            // Scores and not residuals: 1/√n holds for any distribution whose values are bounded alike.
            (deviation / self.spread).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        self.lean += step * (score - self.lean);
        let middle_step = if libm::fabs(self.lean) > TUNING.one_sided {
            step
        } else {
            TUNING.middle_step.max(early)
        };
        // Steps by the sign and size of the score, as a median does: spikes of milliseconds count for one.
        self.middle += middle_step * score * self.spread;
        self.spread += step * (size.min(4.0 * self.spread) - self.spread);
        // A second difference, as the residual of a line that is still wrong has a slope.
        let second = score - 2.0 * self.last[1] + self.last[0];
        self.last = [self.last[1], score];
        self.messages = self.messages.saturating_add(1);
        // Before, its two predecessors are blanks.
        if self.messages > 2 {
            let part = 1.0 / (f64::from(self.messages) + 30.0).min(TUNING.single_memory);
            self.single += part * (second * second - self.single);
        }
        self.sum_up(score);
        self.judge();
    }

    fn sum_up(&mut self, score: f64) {
        let mut part = score;
        let mut is_known = false;
        for scale in &mut self.scales {
            // A longer mean is made of shorter ones, so a message costs one addition on most of the scales.
            let Some(sum) = scale.take(part, self.single) else {
                break;
            };
            part = sum;
            is_known = true;
        }
        if is_known {
            let ratios = self.scales.iter().map(|scale| scale.ratio);
            self.ratio = ratios.fold(0.0, f64::max);
        }
    }

    fn judge(&mut self) {
        self.independent_for = if self.ratio < TUNING.independent {
            self.independent_for.saturating_add(1)
        } else {
            0
        };
        if self.ratio > TUNING.correlated {
            self.correlated = true;
        // Hysteresis in level and in time: correlated delays are calm for half a minute now and then.
        } else if self.independent_for > TUNING.independent_for {
            self.correlated = false;
        }
    }
}

impl Scale {
    fn all() -> [Self; SCALES] {
        let mut scales = [Self {
            length: SHORTEST,
            parts: SHORTEST,
            sum: 0.0,
            summed: 0,
            means: [0.0; 2],
            known: 0,
            ratio: 1.0,
            count: TUNING.prior,
        }; SCALES];
        let mut i = 1;
        while i < SCALES {
            scales[i].length = LONGER * scales[i - 1].length;
            scales[i].parts = LONGER;
            i += 1;
        }
        scales
    }

    /// Takes one part of a mean. Returns the sum of all scores of the mean, if this was its last part.
    fn take(&mut self, part: f64, single: f64) -> Option<f64> {
        self.sum += part;
        self.summed += 1;
        if self.summed < self.parts {
            return None;
        }
        let n = f64::from(self.length);
        let sum = core::mem::take(&mut self.sum);
        let mean = sum / n;
        self.summed = 0;
        if self.known == 2 && single > 0.0 {
            let second = mean - 2.0 * self.means[1] + self.means[0];
            // A mean of n independent scores scatters by 1/√n: the ratio is 1 then, whatever the jitter is.
            let sample = (second * second * n / single).min(TUNING.outlier);
            self.count = (self.count + 1.0).min(TUNING.memory);
            self.ratio += (sample - self.ratio) / self.count;
        }
        self.known = (self.known + 1).min(2);
        self.means = [self.means[1], mean];
        Some(sum)
    }
}

#[cfg(test)]
mod tests;
