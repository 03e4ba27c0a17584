//! Numbers as people read and write them.

/// A number with this many significant digits, in plain notation where that stays short.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let precision = (digits - 1).max(0) as usize;
    let scientific = format!("{value:.precision$e}");
    // Of the rounded value: 99.96 becomes 100, not 100.0.
    let magnitude = scientific.split_once('e').and_then(|(_, m)| m.parse().ok());
    let magnitude: i32 = magnitude.unwrap_or(0);
    // Plain numbers up to nine digits, and up to six places behind the point.
    if !(-6..9).contains(&magnitude) {
        return scientific;
    }
    let decimals = (digits - 1 - magnitude).max(0) as usize;
    format!("{value:.decimals$}")
}

/// Smallest value that at least this share of sorted values does not exceed; interpolated linearly between two. Needs at
/// least one value.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    // A whole place has itself on both sides.
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
