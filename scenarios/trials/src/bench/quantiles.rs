//! Usual, rare and worst values.

use coaxle_lab::number::quantile;
use serde::{Deserialize, Serialize};

/// Quantiles of times, µs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TimeQuantiles {
    /// Number of times.
    pub(super) count: usize,
    /// Half of the times are at most this.
    pub(super) p50_us: f64,
    /// 99 of 100 times are at most this.
    pub(super) p99_us: f64,
    /// The longest time.
    pub(super) max_us: f64,
}

impl TimeQuantiles {
    /// Quantiles of times in ns; none without any.
    pub(super) fn of(nanos: impl IntoIterator<Item = i64>) -> Option<Self> {
        let mut micros: Vec<f64> = nanos.into_iter().map(|ns| ns as f64 / 1e3).collect();
        micros.sort_by(f64::total_cmp);
        Some(Self {
            count: micros.len(),
            // An empty list returns here, before its quantiles.
            max_us: *micros.last()?,
            p50_us: quantile(&micros, 0.5),
            p99_us: quantile(&micros, 0.99),
        })
    }
}

/// Ratio of two medians.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct MedianRatio {
    /// Ratio of the medians of all rounds together.
    pub(super) p50: f64,
    /// Least ratio of a single round.
    pub(super) least: f64,
    /// Greatest ratio of a single round.
    pub(super) most: f64,
}

impl MedianRatio {
    /// Ratios over rounds in which both were measured; none if no round can be compared.
    pub(super) fn of(ours: &[Vec<i64>], theirs: &[Vec<i64>]) -> Option<Self> {
        let rounds = ours.iter().zip(theirs);
        let ratios: Vec<f64> = rounds
            .filter_map(|(ours, theirs)| Self::of_medians(ours, theirs))
            .collect();
        // Over all samples, as rounds of few samples would weigh as much as long ones in a mean of ratios.
        let all = |rounds: &[Vec<i64>]| rounds.concat();
        Some(Self {
            p50: Self::of_medians(&all(ours), &all(theirs))?,
            least: ratios.iter().copied().reduce(f64::min)?,
            most: ratios.iter().copied().reduce(f64::max)?,
        })
    }

    fn of_medians(ours: &[i64], theirs: &[i64]) -> Option<f64> {
        let median = |nanos: &[i64]| TimeQuantiles::of(nanos.iter().copied()).map(|q| q.p50_us);
        // A median of 0 ns, below the resolution of the clock, has no ratio.
        Some(median(ours)? / median(theirs).filter(|median| *median > 0.0)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_in_microseconds() {
        let q = TimeQuantiles::of((0..=100).rev().map(|k| k * 1_000)).unwrap();
        assert_eq!(
            (q.count, q.p50_us, q.p99_us, q.max_us),
            (101, 50.0, 99.0, 100.0)
        );
        assert_eq!(TimeQuantiles::of([]), None);
    }

    #[test]
    fn a_ratio_is_of_all_rounds_and_shows_what_single_rounds_scatter() {
        let ours = [vec![2_000; 3], vec![3_000; 3], vec![3_000; 3]];
        let theirs = [vec![2_000; 3], vec![2_000; 3], vec![2_500; 3]];
        let ratio = MedianRatio::of(&ours, &theirs).unwrap();
        // Medians of all are 3 and 2; the rounds alone have 2/2, 3/2 and 3/2.5.
        assert_eq!((ratio.p50, ratio.least, ratio.most), (1.5, 1.0, 1.5));
        assert_eq!(MedianRatio::of(&ours, &[Vec::new()]), None);
        assert_eq!(MedianRatio::of(&ours, &[vec![0]]), None);
    }
}
