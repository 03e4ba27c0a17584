//! Numbers along a line.

use std::ops::Range;

use coaxle_lab::sweep::plot::is_logarithmic;

use crate::plotting::short;

/// Numbers along a line, by themselves or by their logarithms.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    is_logarithmic: bool,
}

impl Scale {
    /// By their logarithms where that suits these.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Self {
        let is_logarithmic = is_logarithmic(values);
        Self { is_logarithmic }
    }

    /// Where a value lies.
    pub(super) fn place(self, value: f64) -> f64 {
        if self.is_logarithmic {
            value.log10()
        } else {
            value
        }
    }

    /// The value that lies there.
    pub(super) fn label(self, place: f64) -> String {
        match self.is_logarithmic {
            true => short(10_f64.powf(place), 3),
            false => short(place, 6),
        }
    }

    /// How many labels suit a range: one for each decade.
    pub(super) fn labels(self, range: &Range<f64>) -> usize {
        match self.is_logarithmic {
            true => (range.end - range.start).ceil() as usize + 1,
            false => 10,
        }
    }

    /// Around all of these, with a share of it at each end.
    pub(super) fn range(self, values: impl Iterator<Item = f64>, share: f64) -> Range<f64> {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(ends, |(low, high), value| {
            let place = self.place(value);
            (low.min(place), high.max(place))
        });
        // What is constant has a range, too.
        let least = 1e-6 * low.abs().max(high.abs()).max(1e-9);
        let margin = (share * (high - low)).max(least);
        low - margin..high + margin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_labelled_by_what_they_are_of() {
        let scale = Scale::of([1.0, 1000.0].into_iter());
        assert_eq!(scale.label(scale.place(100.0)), "100");
        let range = scale.range([1.0, 1000.0].into_iter(), 0.0);
        assert_eq!(scale.labels(&range), 5);
        let constant = scale.range([10.0].into_iter(), 0.1);
        assert!(constant.start < 1.0 && constant.end > 1.0);
    }
}
