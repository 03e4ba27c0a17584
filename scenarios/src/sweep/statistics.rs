//! A figure over several seeds.

use super::record::FigureRow;
use crate::figures::{Figure, number};

/// What a figure of a point was, over its seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Statistics {
    /// In how many runs there was one.
    pub(super) known: usize,
    /// The middle one, or the mean of the two middle ones.
    pub(super) median: f64,
    /// What one in twenty is below; between two runs as on a straight line from one to the other.
    pub(super) low: f64,
    /// What one in twenty is above, likewise.
    pub(super) high: f64,
    /// The one farthest from zero; where more is better, the least.
    pub(super) worst: f64,
}

impl Statistics {
    /// Of the same row with several seeds. None where no run has the figure, or it is a text.
    pub(super) fn of(figure: &Figure, rows: &[&FigureRow]) -> Option<Self> {
        let values = rows.iter().filter_map(|row| row.value(figure));
        let mut values: Vec<f64> = values.filter_map(|value| number(&value)).collect();
        values.sort_by(f64::total_cmp);
        let (first, last) = (*values.first()?, *values.last()?);
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

/// Of sorted values, at least one.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place as usize], sorted[place.ceil() as usize]);
    if below == above {
        // Without rounding.
        return below;
    }
    below + place.fract() * (above - below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_on_lines_between_the_values() {
        let values: Vec<f64> = (0..=20).map(f64::from).collect();
        assert_eq!(quantile(&values, 0.05), 1.0);
        assert_eq!(quantile(&values, 0.95), 19.0);
        assert_eq!(quantile(&[1.0, 2.0], 0.5), 1.5);
        assert_eq!(quantile(&[1.0, 2.0], 0.95), 1.95);
        assert_eq!(quantile(&[0.1], 0.95), 0.1);
    }
}
