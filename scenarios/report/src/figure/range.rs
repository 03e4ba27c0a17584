//! Ranges around values.

/// Returns the least and the largest of the values that can be drawn; none if none can.
pub(super) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let values = values.filter(|value| is_drawable(*value));
    values.fold(None, |range, value| {
        let (low, high) = range.unwrap_or((value, value));
        Some((f64::min(low, value), f64::max(high, value)))
    })
}

/// Reports whether a value can be drawn: beyond this a range from one side to the other would not be a number.
fn is_drawable(value: f64) -> bool {
    // A range from -1e300 to 1e300 is finite with any margin: an f64 goes to 1.8e308.
    const LARGEST: f64 = 1e300;
    value.abs() < LARGEST
}

/// Returns a range around the values with a share of it at each end; none without values. Constant values have a range, too.
pub fn around(values: impl Iterator<Item = f64>, share: f64) -> Option<(f64, f64)> {
    let (low, high) = extent(values)?;
    let largest = low.abs().max(high.abs());
    let margin = match share * (high - low) {
        // Wide enough for the numbers beside it to differ.
        // Below a billionth of the numbers, labels of six digits are all alike. Half a percent at either side is seen.
        margin if margin <= 1e-9 * largest => 5e-3 * largest,
        margin => margin,
    };
    // Zeros have no size to take a share of, and a range of no height divides by zero.
    let margin = if margin > 0.0 { margin } else { 1.0 };
    Some((low - margin, high + margin))
}

/// Returns a range that shows all of the values, except rare ones far beyond the others: a single jump at the start must not
/// flatten everything else. A beat's spike is not that far away.
pub(super) fn usual(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.filter(|value| is_drawable(*value)).collect();
    if values.is_empty() {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    // Up to 2 % at either end count as rare: one beat in hundreds of cycles, and a lock-in of a long run.
    let usual_low = values[last / 50];
    let usual_high = values[last - last / 50];
    // A beat's spike is at 0 or at 2·v, one velocity from the usual v, and so within reach.
    let reach = 2.0 * usual_low.abs().max(usual_high.abs());
    // Usual values of zero give no size that a rare one could be far from.
    let (low, high) = if reach > 0.0 {
        (
            values[0].max(usual_low - reach),
            values[last].min(usual_high + reach),
        )
    } else {
        (values[0], values[last])
    };
    // Constant values must not look wild.
    let margin = (0.08 * (high - low)).max(5e-3 * high.abs()).max(1e-9);
    Some((low - margin, high + margin))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_shows_beats_but_not_a_leap() {
        let mut values = vec![500.0; 998];
        values.push(0.0);
        values.push(1e9);
        let (low, high) = usual(values.into_iter()).unwrap();
        assert!(low < 0.0 && low > -200.0, "{low}");
        // 500 + 2 · 500, and the margin.
        assert!(high > 1000.0 && high < 2000.0, "{high}");
        assert_eq!(usual([f64::NAN].into_iter()), None);
    }

    #[test]
    fn a_range_has_all_values_and_room_at_both_ends() {
        let range = |values: &[f64]| around(values.iter().copied(), 0.1);
        assert_eq!(range(&[]), None);
        assert_eq!(range(&[f64::NAN, f64::INFINITY, -f64::MAX]), None);
        assert_eq!(range(&[0.0, f64::NAN, 10.0]), Some((-1.0, 11.0)));
        assert_eq!(range(&[0.0]), Some((-1.0, 1.0)));
        let (low, high) = range(&[500.0, 500.0]).unwrap();
        assert!(low < 500.0 && high > 500.0 && high - low < 10.0);
        let (low, high) = range(&[-1e-9; 3]).unwrap();
        assert!(low < -1e-9 && high > -1e-9);
    }
}
