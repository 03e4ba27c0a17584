//! Common parts of plots, wherever they are drawn: colours, numbers, and the script for axes in a browser.

mod colours;

pub use colours::{CHOSEN, NEUTRAL, colour, rgb};

/// Ticks, numbers, axes and cursors, for any page that draws on a canvas.
pub const AXES_JS: &str = include_str!("axes.js");

/// Formats a value in `digits` significant digits, without the zeros behind them.
pub fn short(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1))
        .parse()
        .unwrap_or(value);
    // Six digits stand without an exponent below a million. A number from 1e-4 on has three zeros behind its point at most.
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        return format!("{rounded:e}");
    }
    // Zero has no sign.
    format!("{}", rounded + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, expected) in [
            (0.0, "0"),
            (-0.0, "0"),
            (20.0, "20"),
            (0.1 + 0.2, "0.3"),
            (123_456.0, "123000"),
            (-1.5e-7, "-1.5e-7"),
        ] {
            assert_eq!(short(value, 3), expected);
        }
    }
}
