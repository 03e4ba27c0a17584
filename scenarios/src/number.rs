//! Numbers as people read and write them.

use clap::builder::RangedU64ValueParser;

/// A seed on the command line: one that a scenario file can hold.
pub(crate) fn seed() -> RangedU64ValueParser {
    clap::value_parser!(u64).range(..=i64::MAX as u64)
}

/// So many significant digits, in plain notation where that stays short.
pub(crate) fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let precision = (digits - 1).max(0) as usize;
    let scientific = format!("{value:.precision$e}");
    // Of the rounded value: 99.96 becomes 100, not 100.0.
    let magnitude = scientific.split_once('e').and_then(|(_, m)| m.parse().ok());
    let magnitude: i32 = magnitude.unwrap_or(0);
    if !(-6..9).contains(&magnitude) {
        return scientific;
    }
    let decimals = (digits - 1 - magnitude).max(0) as usize;
    format!("{value:.decimals$}")
}
