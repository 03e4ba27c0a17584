//! Scales: places of values along an axis.

use coaxle_lab::sweep::plot::is_logarithmic;

use crate::plotting::short;

/// Scale of an axis: the places of its values. A place is a number, too: drawings take places and label values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Linear: the places are the values.
    #[default]
    Linear,
    /// Largest value first, so that time still goes from left to right where a master goes backwards.
    Backwards,
    /// Logarithmic: the places are logarithms to the base of ten.
    Logarithmic,
    /// Words beside each other; the values are their numbers.
    Words(Vec<String>),
}

impl Scale {
    /// Returns a logarithmic scale where that suits the values, otherwise a linear one.
    #[must_use]
    pub fn suiting(values: impl Iterator<Item = f64>) -> Self {
        if is_logarithmic(values) {
            Self::Logarithmic
        } else {
            Self::Linear
        }
    }

    /// Returns the place of a value; not a number where it has no place.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        match self {
            Self::Linear | Self::Words(_) => value,
            Self::Backwards => -value,
            Self::Logarithmic if value > 0.0 => value.log10(),
            // Not finite, and thereby a gap: a count of zero has no place among decades.
            Self::Logarithmic => f64::NAN,
        }
    }

    /// Returns the value at a place.
    #[must_use]
    pub fn value(&self, place: f64) -> f64 {
        match self {
            Self::Linear | Self::Words(_) => place,
            Self::Backwards => -place,
            Self::Logarithmic => 10_f64.powf(place),
        }
    }

    /// Returns places to label between two places, about as many as requested, with their labels.
    pub(crate) fn ticks(&self, (from, to): (f64, f64), count: f64) -> Vec<(f64, String)> {
        match self {
            Self::Linear => {
                let marks = ticks((from, to), count).into_iter();
                marks.map(|mark| (mark, short(mark, 6))).collect()
            }
            Self::Backwards => {
                let marks = ticks((from, to), count).into_iter();
                marks.map(|mark| (mark, short(-mark, 6))).collect()
            }
            Self::Logarithmic => decades((from, to), count),
            Self::Words(words) => {
                // Every n-th word, as overlapping ones could not be read.
                let step = (words.len() as f64 / count.max(1.0)).ceil().max(1.0);
                let words = words.iter().enumerate().step_by(step as usize);
                let words = words.map(|(n, word)| (n as f64, word.clone()));
                words.filter(|(at, _)| (from..=to).contains(at)).collect()
            }
        }
    }

    /// Name in a page.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Backwards => "backwards",
            Self::Logarithmic => "logarithmic",
            Self::Words(_) => "words",
        }
    }

    /// Returns the words; none for a scale of numbers.
    pub(crate) fn words(&self) -> &[String] {
        match self {
            Self::Words(words) => words,
            Self::Linear | Self::Backwards | Self::Logarithmic => &[],
        }
    }
}

/// Returns multiples of 1, 2 or 5 times a power of ten, at most about `count` of them: steps that people read without
/// computing. None where the range is none.
fn ticks((from, to): (f64, f64), count: f64) -> Vec<f64> {
    // A panel narrower than a label has room for less than one.
    let raw = (to - from) / count.max(1.0);
    // A range that is finer than its own numbers has nothing to label.
    // Neighbouring f64 are 2e-16 of their size apart: a step of 1e-13 is hundreds of them.
    let finest = 1e-13 * from.abs().max(to.abs());
    if !(raw.is_finite() && raw > finest) {
        return Vec::new();
    }
    let power = 10_f64.powf(raw.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    // A sum of floating-point numbers may be above a step by its last bit.
    let reaches = |step: &f64| *step >= raw * (1.0 - 1e-9);
    let step = steps.into_iter().find(reaches).unwrap_or(raw);
    // At most 1e13 by the check above, which an i64 holds.
    // Multiples of the step, not sums of it: these add up their rounding errors.
    let (first, last) = ((from / step).ceil() as i64, (to / step).floor() as i64);
    (first..=last).map(|n| n as f64 * step).collect()
}

/// Returns powers of ten, with their doubles and fivefolds where the decades are few; within one decade, places as on a linear
/// scale.
fn decades((from, to): (f64, f64), count: f64) -> Vec<(f64, String)> {
    if !(from.is_finite() && to.is_finite() && from < to) {
        return Vec::new();
    }
    // Within a decade there may be no power of ten at all.
    if to - from < 1.0 {
        let marks = ticks((10_f64.powf(from), 10_f64.powf(to)), count).into_iter();
        return marks
            .map(|value| (value.log10(), short(value, 6)))
            .collect();
    }
    // Three labels a decade, where they fit.
    let factors: &[f64] = if 3.0 * (to - from) <= count {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let every = ((to - from) / count.max(1.0)).ceil().max(1.0) as i32;
    // Whole decades around the range: doubles and fivefolds of the one below its beginning may be within.
    let (first, last) = (from.floor() as i32, to.ceil() as i32);
    // Multiples of the distance, with negative decades, too: labels keep their values while a plot is moved.
    let marks = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
    let marks = marks.flat_map(|decade| {
        let of = |factor: &f64| factor * 10_f64.powi(decade);
        factors.iter().map(of).collect::<Vec<_>>()
    });
    let marks = marks.map(|value| (value.log10(), short(value, 3)));
    // The logarithm of a power of ten may miss the end of the range by its last bit.
    let is_seen = |(place, _): &(f64, String)| (from - 1e-9..=to + 1e-9).contains(place);
    marks.filter(is_seen).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_one_two_or_five_times_a_power_of_ten() {
        for (range, count, expected) in [
            (
                (0.0, 10.0),
                10.0,
                vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0],
            ),
            ((0.0, 10.0), 6.0, vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0]),
            ((-7.0, 12.0), 4.0, vec![-5.0, 0.0, 5.0, 10.0]),
            ((0.31, 0.49), 4.0, vec![0.35, 0.4, 0.45]),
            ((1e6, 1e6 + 0.4), 2.0, vec![1e6, 1e6 + 0.2, 1e6 + 0.4]),
        ] {
            let marks = ticks(range, count);
            assert_eq!(marks.len(), expected.len(), "{range:?}: {marks:?}");
            for (mark, expected) in marks.iter().zip(expected) {
                assert!((mark - expected).abs() < 1e-9, "{range:?}: {marks:?}");
            }
        }
    }

    #[test]
    fn a_range_that_is_none_has_no_ticks() {
        for range in [
            (1.0, 1.0),
            (f64::NAN, 1.0),
            (0.0, f64::INFINITY),
            (f64::MIN, f64::MAX),
            (2.0, 1.0),
            // Neighbouring f64: the range has two numbers.
            (1e17, 1e17 + 16.0),
        ] {
            assert!(ticks(range, 10.0).is_empty(), "{range:?}");
        }
        assert!(Scale::Logarithmic.ticks((f64::NAN, 1.0), 5.0).is_empty());
    }

    #[test]
    fn decades_are_labelled_by_what_they_are_of() {
        let labels = |range, count| -> Vec<String> {
            let ticks = Scale::Logarithmic.ticks(range, count).into_iter();
            ticks.map(|(_, label)| label).collect()
        };
        assert_eq!(labels((0.0, 3.0), 5.0), ["1", "10", "100", "1000"]);
        assert_eq!(labels((0.0, 1.0), 5.0), ["1", "2", "5", "10"]);
        assert_eq!(labels((0.4, 0.7), 5.0), ["3", "3.5", "4", "4.5", "5"]);
        assert_eq!(
            labels((-8.0, 8.0), 4.0),
            ["1e-8", "0.0001", "1", "10000", "1e8"]
        );
        assert!(Scale::Logarithmic.place(0.0).is_nan());
        assert_eq!(Scale::Logarithmic.place(1000.0), 3.0);
    }

    #[test]
    fn what_goes_backwards_has_its_own_values_as_labels() {
        let ticks = Scale::Backwards.ticks((-10.0, 0.0), 2.0);
        let labels: Vec<_> = ticks.iter().map(|(_, label)| label.as_str()).collect();
        assert_eq!(labels, ["10", "5", "0"]);
    }

    #[test]
    fn of_many_words_only_those_that_fit_are_there() {
        let words = Scale::Words(["a", "b", "c", "d"].map(str::to_owned).into());
        let labels = |count| -> Vec<String> {
            let ticks = words.ticks((-0.5, 3.5), count).into_iter();
            ticks.map(|(_, label)| label).collect()
        };
        assert_eq!(labels(9.0), ["a", "b", "c", "d"]);
        assert_eq!(labels(2.0), ["a", "c"]);
        assert_eq!(labels(0.0), ["a"]);
    }
}
