//! Numbers and names for people.

use serde::Serialize;

/// Quantities of a slave's motion, in the order of columns and charts.
pub const QUANTITIES: [&str; 4] = ["position", "velocity", "acceleration", "jerk"];

/// Formats a number in at most ten digits, for people.
pub fn shown(value: f64) -> String {
    // Digits beyond the tenth are the rounding of calculations: 0.1 + 0.2 is 0.3.
    shown_to(value, 10)
}

/// Formats a number in at most this number of digits, 1 to 10, for people.
pub fn shown_to(value: f64, digits: usize) -> String {
    let behind = digits - 1;
    let rounded: f64 = format!("{value:.behind$e}").parse().unwrap_or(value);
    if rounded == 0.0 {
        "0".to_owned()
    // Ten digits need no exponent in this range.
    } else if (1e-5..1e10).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// Returns a value's name in files.
pub fn name(value: &impl Serialize) -> String {
    let name = serde_json::to_value(value).ok();
    name.and_then(|name| name.as_str().map(str::to_owned))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (360.0, "360"),
            (0.1 + 0.2, "0.3"),
            (-1.0 / 3.0, "-0.3333333333"),
            (1.5e-9, "1.5e-9"),
            (-2.5e12, "-2.5e12"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(shown(value), expected);
        }
    }
}
