//! A figure over several seeds.

use super::record::FigureRow;
use crate::figures::{SummaryFigure, number};
use crate::number::quantile;

/// Statistics of a point's figure over its seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Number of runs with a value.
    pub known: usize,
    /// The middle value, or the mean of the two middle ones.
    pub median: f64,
    /// 5 % quantile; interpolated linearly between two runs.
    pub low: f64,
    /// 95 % quantile, likewise.
    pub high: f64,
    /// The value farthest from zero; where more is better, the least.
    pub worst: f64,
}

impl Statistics {
    /// Statistics of corresponding rows with several seeds. None where no run has the figure, or it is a text.
    pub(super) fn of(figure: &SummaryFigure, rows: &[&FigureRow]) -> Option<Self> {
        let values = rows.iter().filter_map(|row| row.value(figure));
        let mut values: Vec<f64> = values.filter_map(|value| number(&value)).collect();
        values.sort_by(f64::total_cmp);
        let (first, last) = (*values.first()?, *values.last()?);
        // Values are sorted, so the farthest from zero is at one of the ends.
        let is_farther = last.abs() >= first.abs();
        Some(Self {
            known: values.len(),
            median: quantile(&values, 0.5),
            low: quantile(&values, 0.05),
            high: quantile(&values, 0.95),
            worst: if figure.more_is_better || !is_farther {
                first
            } else {
                last
            },
        })
    }
}
