//! Long sequences of numbers as text.
//!
//! A sequence is scaled to whole numbers by a step of its own, a power of ten. Text has their differences, or the
//! differences of those where that is shorter (the first character says which, `1` or `2`), each with its sign as the lowest
//! bit, five bits a character, the lowest first, and 32 added to all but the last.

use serde_json::{Value, json};

/// Greatest deviation of regular times, s: these are encoded as the first, the distance and the count. Step of others.
// A hundredth of the shortest cycle, 100 µs (docs/LIMITS.md).
const TIME_STEP: f64 = 1e-6;

pub(super) fn times(times: Vec<f64>) -> Value {
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return json!([0, 0, 0]);
    };
    let distance = (last - first) / (times.len() - 1).max(1) as f64;
    // Multiples of the mean distance: sums of a rounded one would drift away over a long run.
    let expected = |n: usize| first + n as f64 * distance;
    let mut all = times.iter().enumerate();
    if all.all(|(n, t)| (t - expected(n)).abs() <= TIME_STEP) {
        // Picoseconds: 0.001 takes five characters, 0.0010000000000000002 twenty-one.
        let exact = |t: f64| (t * 1e12).round() / 1e12;
        return json!([exact(*first), exact(distance), times.len()]);
    }
    json!({ "step": TIME_STEP, "value": text(&times, TIME_STEP) })
}

/// Returns the step of values: of their range at best a millionth, at worst a four-thousandth, as fine as few characters allow.
pub(super) fn step_of(values: impl Iterator<Item = f64>, told: &[&[f64]]) -> f64 {
    // The coarsest, a four-thousandth, is less than a tenth of a pixel of a panel 320 high.
    const FINENESS: [f64; 4] = [1e-6, 1e-5, 6e-5, 2.5e-4];
    // Two characters hold ten bits, differences up to 511 with their sign. Three hold 16 383.
    const CHARACTERS: f64 = 2.4;
    let step = steps_of(values);
    let count: usize = told.iter().map(|values| values.len()).sum();
    let is_short = |step: &f64| {
        let length: usize = told.iter().map(|values| text(values, *step).len()).sum();
        length as f64 <= CHARACTERS * count as f64
    };
    let mut steps = FINENESS.into_iter().map(&step);
    let coarsest = step(FINENESS[FINENESS.len() - 1]);
    steps.find(is_short).unwrap_or(coarsest)
}

/// Returns a step that is at most this part of the range of a course: finer than the six digits in which values are shown.
pub(super) fn fine_step_of(values: impl Iterator<Item = f64>) -> f64 {
    // Six digits differ by 1e-6 of the largest number at least.
    const FINENESS: f64 = 1e-7;
    steps_of(values)(FINENESS)
}

/// Returns the step of the values, given as a part of their range.
fn steps_of(values: impl Iterator<Item = f64>) -> impl Fn(f64) -> f64 {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let largest = low.abs().max(high.abs());
    // A number of the browser has no more digits.
    let least = 1e-13 * largest;
    move |fineness: f64| {
        // Without values, or with zeros only, any step will do.
        if low > high || largest == 0.0 {
            return 1.0;
        }
        decade((fineness * (high - low)).max(least))
    }
}

/// Returns the greatest power of ten that is not above a value.
fn decade(value: f64) -> f64 {
    // As text, so that it is the very number.
    let exponent = value.log10().floor();
    format!("1e{exponent}").parse().unwrap_or(value)
}

/// Encodes values as text, in multiples of a step.
pub(super) fn text(values: &[f64], step: f64) -> String {
    let whole: Vec<i64> = values
        .iter()
        .map(|value| (value / step).round() as i64)
        .collect();
    let once = differences(&whole);
    // A slope has equal differences, and zeros behind these. Noise grows with each order.
    let twice = differences(&once);
    let (once, twice) = (told('1', &once), told('2', &twice));
    if twice.len() < once.len() {
        twice
    } else {
        once
    }
}

fn differences(values: &[i64]) -> Vec<i64> {
    let before = std::iter::once(0).chain(values.iter().copied());
    let pairs = values.iter().zip(before);
    pairs
        .map(|(value, before)| value.wrapping_sub(before))
        .collect()
}

fn told(order: char, values: &[i64]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(2 * values.len());
    text.push(order);
    for value in values {
        // Zigzag: 0, -1, 1, -2 become 0, 1, 2, 3, so that small numbers of either sign are short.
        let mut rest = ((value << 1) ^ (value >> 63)) as u64;
        loop {
            // Five bits and one that says whether more follow, as in LEB128 with its seven.
            let more = rest >= 32;
            let digit = (rest % 32) as usize + if more { 32 } else { 0 };
            text.push(char::from(DIGITS[digit]));
            rest /= 32;
            if !more {
                break;
            }
        }
    }
    text
}

/// Decodes a text as the page's script does.
#[cfg(test)]
pub(crate) fn untold(text: &str, step: f64) -> Vec<f64> {
    const DIGITS: &str = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (order, text) = text.split_at(1);
    let (mut value, mut scale) = (0_i64, 1_i64);
    let (mut last, mut slope) = (0_i64, 0_i64);
    let mut values = Vec::new();
    for c in text.chars() {
        let digit = DIGITS.find(c).expect("a digit") as i64;
        value += digit % 32 * scale;
        scale *= 32;
        if digit >= 32 {
            continue;
        }
        let difference = (value >> 1) ^ -(value & 1);
        slope = if order == "2" { slope } else { 0 } + difference;
        last += slope;
        values.push(last as f64 * step);
        (value, scale) = (0, 1);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_is_what_was() {
        let ramp: Vec<f64> = (0..700).map(|n| 1e6 + 0.5 * f64::from(n)).collect();
        let mut spike = vec![500.0; 700];
        spike[350] = -3.0e4;
        let noise: Vec<f64> = (0..700_u32)
            .map(|n| f64::from(n.wrapping_mul(2_654_435_761) >> 8))
            .collect();
        for values in [ramp, spike, noise, vec![0.0; 9], vec![-1e-9; 3], vec![]] {
            let step = step_of(values.iter().copied(), &[&values]);
            let again = untold(&text(&values, step), step);
            assert_eq!(again.len(), values.len());
            for (value, again) in values.iter().zip(again) {
                assert!(
                    (value - again).abs() <= 0.51 * step,
                    "{value} {again} {step}"
                );
            }
        }
    }

    #[test]
    fn what_is_smooth_is_short_and_fine() {
        let ramp: Vec<f64> = (0..1_000).map(|n| 0.5 * f64::from(n)).collect();
        let step = step_of(ramp.iter().copied(), &[&ramp]);
        assert!(step <= 1e-3, "{step}");
        assert!(text(&ramp, step).len() < 1_020);
    }

    #[test]
    fn regular_times_are_three_numbers() {
        let regular = (0..100).map(|n| 2.0 + 1e-3 * f64::from(n)).collect();
        assert_eq!(times(regular), json!([2.0, 0.001, 100]));
        let broken = times(vec![0.0, 0.001, 0.005]);
        let text = broken["value"].as_str().unwrap();
        assert_eq!(untold(text, 1.0), [0.0, 1_000.0, 5_000.0]);
    }
}
