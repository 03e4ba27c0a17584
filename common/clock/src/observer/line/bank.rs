//! Several filters side by side, each for another random walk of the drift; the better one predicts, the greater its
//! weight.

use super::bias::Bias;
use super::filter::Estimate;
use crate::numbers::NearLogarithm;
use crate::observer::noise::CorrelatedDelay;
use crate::tuning::tuning;

tuning! {
    /// Tuned constants of the bank.
    BankTuning {
        /// Random walks of the drift that are considered, ppm/√s, each three times the one before.
        // Where a walk is wrong by the factor s, the ripple of a filter grows by √((3·√s + 1/√s³)/4), 5 to 7 % at √3.
        random_walks_ppm: [f64; FILTERS] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0],
        /// Drift that each filter expects at first, as a part of the largest usual one.
        // Quartzes are mostly far better than their worst: together these are a prior with a sharp top and long tails, and the first tenths of a
        // second show which filter was right.
        expected_drifts: [f64; FILTERS] = [0.03, 0.1, 0.3, 1.0, 2.0, 5.0],
        /// Losses are forgotten with this time constant, s.
        // Some minutes, in which the temperature of a machine changes.
        loss_memory: f64 = 300.0,
        /// Blocks that the measurement variance is a mean over.
        // It is then known to 3 %, 1/√1050.
        variance_memory: f64 = 1_000.0,
        /// Blocks whose weight the promised variance has at first.
        first_variance_weight: f64 = 50.0,
        /// Least measurement variance that is believed, as a multiple of the promised one …
        least_variance: f64 = 0.3,
        /// … and the greatest.
        // Scatter beyond it is of the line, not of the messages.
        greatest_variance: f64 = 10.0,
        /// Standard deviations off a faster filter at which, after `contradicting_blocks`, a slow one is wrong.
        contradiction: f64 = 4.0,
        /// Blocks in a row for that, 32 messages.
        // A single block may be late as a whole.
        contradicting_blocks: u8 = 4,
        /// Measurements that the bias is a mean over.
        // 0.2 s at 1 ms.
        bias_memory: f64 = 24.0,
        /// Standard deviations of the bias below which it is chance.
        unbiased: f64 = 2.0,
        /// Memory of the lasting bias.
        // A mean over a second, at 1 ms, as the short one is beyond two standard deviations by chance every second.
        lasting_bias_memory: f64 = 96.0,
        /// Standard deviations of the lasting bias below which it is chance.
        lasting_unbiased: f64 = 3.0,
        /// Factor on the variance of the drift where a slow filter takes over the estimate of a faster one …
        // The faster filter itself still lags behind, in the drift more than in the offset.
        drift_doubt: f64 = 8.0,
        /// … and its covariance by this.
        // Below √8, so that the matrix stays positive.
        both_doubt: f64 = 2.0,
        /// Losses from before an event are kept this long, s.
        // Longer than it takes to notice one.
        snapshot_interval: f64 = 3.0,
        /// Excess of the loss from which a filter has no weight.
        // A weight of exp(−8) is 0.03 %.
        negligible: f64 = 8.0,
    }
}

const FILTERS: usize = 6;
const FASTEST: usize = FILTERS - 1;
const AGILE: usize = FASTEST;
/// The likeliest before anything is known.
const USUAL: usize = 1;

#[derive(Clone, Debug)]
pub(crate) struct Bank {
    filters: [Estimate; FILTERS],
    losses: [f64; FILTERS],
    /// Logarithms of the ratios of the innovations' variances to a measurement's.
    logarithms: [NearLogarithm; FILTERS],
    contradicting: [u8; FILTERS],
    /// Losses of up to two intervals ago: an event must not decide which filter is the best.
    snapshots: [[f64; FILTERS]; 2],
    since_snapshot: f64,
    /// The variance of a measurement as a multiple of the one that the jitter promises.
    excess: f64,
    blocks: f64,
    correlated: CorrelatedDelay,
    /// Bias of the latest measurements against their predictions.
    bias: Bias,
    lasting_bias: Bias,
    usual_variance: f64,
    combined: Estimate,
    chosen: usize,
}

impl Bank {
    /// Begins with a first measurement of the offset, and its variance.
    pub(crate) fn new(offset: f64, variance: f64, drift_variance: f64) -> Self {
        let estimate = Estimate {
            offset,
            drift: 0.0,
            offset_variance: variance,
            covariance: 0.0,
            drift_variance,
        };
        let filters = TUNING.expected_drifts.map(|part| Estimate {
            drift_variance: part * part * drift_variance,
            ..estimate
        });
        Self {
            // Each filter has its own prior of the drift, and the losses of the first blocks choose among them.
            filters,
            losses: PRIOR_LOSSES,
            logarithms: [NearLogarithm::ONE; FILTERS],
            contradicting: [0; FILTERS],
            snapshots: [PRIOR_LOSSES; 2],
            since_snapshot: 0.0,
            excess: 1.0,
            blocks: 0.0,
            correlated: CorrelatedDelay::new(),
            bias: Bias::over(TUNING.bias_memory),
            lasting_bias: Bias::over(TUNING.lasting_bias_memory),
            usual_variance: variance,
            combined: estimate,
            chosen: USUAL,
        }
    }

    /// Combined estimate of all filters.
    pub(crate) const fn combined(&self) -> &Estimate {
        &self.combined
    }

    /// Offset that the most agile filter expects after `dt` seconds, and its variance.
    pub(crate) fn agile(&self, dt: f64) -> (f64, f64) {
        let mut estimate = self.filters[AGILE];
        // The location of a block is found beside this: a slow filter that is wrong would lead to the tail of its likelihood.
        estimate.predict(dt, walks()[AGILE]);
        (estimate.offset, estimate.offset_variance)
    }

    /// The random walk that predicts best, ppm/√s.
    pub(in crate::observer) fn random_walk_ppm(&self) -> f64 {
        TUNING.random_walks_ppm[self.chosen]
    }

    /// Random walk that predicts best, as the variance per second of the drift.
    pub(crate) fn drift_walk(&self) -> f64 {
        walks()[self.chosen]
    }

    /// Monitor of correlated delays.
    pub(in crate::observer) const fn correlated(&self) -> &CorrelatedDelay {
        &self.correlated
    }

    /// Shifts all filters by a jump of the offset; they keep what they know of the drift.
    pub(in crate::observer) fn shift(&mut self, by: f64, variance: f64) {
        // A jump of the path says nothing of the clock, so drifts and their covariances stay.
        for filter in self.filters.iter_mut().chain([&mut self.combined]) {
            filter.offset += by;
            filter.offset_variance += variance;
        }
        self.correlated.jumped();
        self.bias.forget();
        self.lasting_bias.forget();
        self.forget_event();
    }

    /// Restarts all filters from `estimate` after the drift changed at once.
    pub(in crate::observer) fn begin_anew(&mut self, estimate: &Estimate) {
        // The drift is another one, so whatever a single filter had learnt is of the past.
        self.filters = [*estimate; FILTERS];
        self.combined = *estimate;
        self.correlated.jumped();
        self.bias.forget();
        self.lasting_bias.forget();
        self.forget_event();
    }

    /// Moves on without a measurement, as when many messages were lost.
    pub(in crate::observer) fn predict(&mut self, dt: f64) {
        for (filter, walk) in self.filters.iter_mut().zip(walks()) {
            filter.predict(dt, walk);
        }
    }

    /// Takes the measurement of one block, `dt` seconds after the previous one. `expected` is the
    /// variance that the jitter model promises for it.
    pub(crate) fn observe(&mut self, dt: f64, measured: f64, expected: f64) {
        // Before the filters are corrected: the bias is that of their prediction.
        self.notice_bias(dt, measured, expected);
        self.predict(dt);
        // Clamped, as after a silence of many minutes the factor would be negative.
        let forget = 1.0 - (dt / TUNING.loss_memory).min(1.0);
        self.notice_correlation(dt, measured, expected);
        let factor = self.correlated.factor();
        let variance = self.excess.max(factor) * expected;
        let mut fastest = 0.0;
        let mut predicted = 0.0;
        for (i, filter) in self.filters.iter_mut().enumerate() {
            predicted = filter.offset_variance;
            let innovation = filter.correct(measured, variance);
            fastest = innovation.value * innovation.value;
            let spread = self.logarithms[i].of(innovation.variance / variance);
            // Twice the negative log-likelihood of the innovation, without the part that all filters share.
            let loss = fastest / innovation.variance + spread;
            self.losses[i] =
                forget * self.losses[i] + (1.0 - forget) * PRIOR_LOSSES[i] + 0.5 * loss;
        }
        // While the offset is hardly known its innovations say nothing of the messages.
        if predicted < variance {
            self.learn_excess((fastest - predicted / factor) / expected);
        }
        self.reseed_contradicted();
        self.snapshot(dt);
        self.combine();
    }

    /// Square of the estimate's bias, as far as the last measurements show it: it lags behind a drift that changes.
    pub(crate) fn bias_variance(&self) -> f64 {
        self.bias.variance_beyond(TUNING.unbiased)
    }

    /// Square of the bias over some more measurements, and beyond chance.
    pub(in crate::observer) fn lasting_bias_variance(&self) -> f64 {
        self.lasting_bias.variance_beyond(TUNING.lasting_unbiased)
    }

    fn notice_bias(&mut self, dt: f64, measured: f64, expected: f64) {
        let before = &self.combined;
        // A block that says little for once says little of the bias, too.
        self.usual_variance +=
            (expected.min(2.0 * self.usual_variance) - self.usual_variance) / TUNING.bias_memory;
        let weight = self.usual_variance / expected;
        let innovation = measured - before.offset - before.drift * dt;
        let scatter = before.offset_variance + expected * self.excess.max(self.correlated.factor());
        self.bias.take(innovation, scatter, weight);
        // Where means of many measurements scatter, the cause may be the path as well as the clock.
        let independent = before.offset_variance + expected * self.excess;
        self.lasting_bias.take(innovation, independent, weight);
    }

    /// Notices when the delay turns out to be correlated: then less is known than was believed, also of which filter
    /// is the best.
    fn notice_correlation(&mut self, dt: f64, measured: f64, expected: f64) {
        let before = self.correlated.factor();
        self.correlated.take(dt, measured, expected);
        // Only growth counts: as the factor falls, later measurements make the variances small again.
        let grown = self.correlated.factor() / before;
        if grown > 1.0 {
            for filter in &mut self.filters {
                filter.offset_variance *= grown;
                filter.covariance *= grown;
                filter.drift_variance *= grown;
            }
            for (loss, prior) in self.losses.iter_mut().zip(PRIOR_LOSSES) {
                // Losses are sums of squares over variances, which were too small by this factor.
                *loss = prior + (*loss - prior) / grown;
            }
        }
    }

    fn learn_excess(&mut self, sample: f64) {
        self.blocks = (self.blocks + 1.0).min(TUNING.variance_memory);
        self.excess += (sample - self.excess) / (self.blocks + TUNING.first_variance_weight);
        self.excess = self
            .excess
            .clamp(TUNING.least_variance, TUNING.greatest_variance);
    }

    fn reseed_contradicted(&mut self) {
        for slow in 0..FASTEST {
            let contradicting = (slow + 1..FILTERS).rev().find(|fast| {
                // The fastest filter first: it follows whatever happens, so a filter that is off it is wrong.
                let difference = self.filters[*fast].offset - self.filters[slow].offset;
                let bound = self.filters[*fast].offset_variance;
                difference * difference > TUNING.contradiction * TUNING.contradiction * bound
            });
            let Some(fast) = contradicting else {
                self.contradicting[slow] = 0;
                continue;
            };
            self.contradicting[slow] += 1;
            if self.contradicting[slow] < TUNING.contradicting_blocks {
                continue;
            }
            let seed = Estimate {
                covariance: TUNING.both_doubt * self.filters[fast].covariance,
                drift_variance: TUNING.drift_doubt * self.filters[fast].drift_variance,
                ..self.filters[fast]
            };
            self.filters[slow] = seed;
            self.forget_event();
        }
    }

    /// Keeps the choice of before the event.
    fn forget_event(&mut self) {
        self.losses = self.snapshots[1];
        self.snapshots[0] = self.losses;
        self.since_snapshot = 0.0;
        self.contradicting = [0; FILTERS];
    }

    fn snapshot(&mut self, dt: f64) {
        self.since_snapshot += dt;
        if self.since_snapshot > TUNING.snapshot_interval {
            self.since_snapshot = 0.0;
            self.snapshots = [self.losses, self.snapshots[0]];
        }
    }

    /// The mean of all filters, weighted by their likelihood.
    fn combine(&mut self) {
        let mut best = 0;
        // The least loss is taken away before the exponential, or all weights could underflow.
        for i in 1..FILTERS {
            if self.losses[i] < self.losses[best] {
                best = i;
            }
        }
        let least = self.losses[best];
        let mut total = 0.0;
        let mut sum = Estimate {
            offset: 0.0,
            drift: 0.0,
            offset_variance: 0.0,
            covariance: 0.0,
            drift_variance: 0.0,
        };
        let reference = self.filters[best];
        for (filter, loss) in self.filters.iter().zip(self.losses) {
            let loss = loss - least;
            if loss > TUNING.negligible {
                continue;
            }
            let weight = libm::exp(-loss);
            // Relative to the best filter, as the offsets alike would cancel the digits of their differences.
            let offset = filter.offset - reference.offset;
            let drift = filter.drift - reference.drift;
            total += weight;
            sum.offset += weight * offset;
            sum.drift += weight * drift;
            // Variance of a mixture: that of each part, and the spread between their means.
            sum.offset_variance += weight * (filter.offset_variance + offset * offset);
            sum.covariance += weight * (filter.covariance + offset * drift);
            sum.drift_variance += weight * (filter.drift_variance + drift * drift);
        }
        let part = 1.0 / total;
        self.chosen = best;
        self.combined = Estimate {
            offset: reference.offset + sum.offset * part,
            drift: reference.drift + sum.drift * part,
            offset_variance: sum.offset_variance * part,
            covariance: sum.covariance * part,
            drift_variance: sum.drift_variance * part,
        };
    }
}

/// Variance that the drift gains per second at each of the random walks.
fn walks() -> [f64; FILTERS] {
    TUNING.random_walks_ppm.map(|ppm| {
        let walk = ppm * 1e-6;
        walk * walk
    })
}

const PRIOR_LOSSES: [f64; FILTERS] = {
    let mut losses = [0.0; FILTERS];
    let mut i = 0;
    while i < FILTERS {
        // A normal prior over the index of the walk, with a standard deviation of one step.
        let distance = i as f64 - USUAL as f64;
        losses[i] = 0.5 * distance * distance;
        i += 1;
    }
    losses
};
