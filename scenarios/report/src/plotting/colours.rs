//! Colours of curves: none twice in a figure.

/// Distinguishable with any colour vision, and on white as on black. The first belong to the modes.
pub const CHOSEN: [&str; 7] = [
    "#d9541e", "#d99a00", "#0b9c78", "#2f86d6", "#b06fa8", "#4fb0dc", "#8c7a5b",
];

/// Colour of curves that belong to no receiver: the drive, the truth.
pub const NEUTRAL: &str = "#8a8a8a";

/// Returns the n-th curve's colour, `#rrggbb`: the chosen ones, then others as far apart as can be.
pub fn colour(n: usize) -> String {
    match CHOSEN.get(n) {
        Some(chosen) => (*chosen).to_owned(),
        None => further(n - CHOSEN.len()),
    }
}

/// Returns the parts of a colour `#rrggbb`.
pub fn rgb(colour: &str) -> (u8, u8, u8) {
    let part = |at: usize| {
        let hex = colour.get(at..at + 2);
        hex.and_then(|hex| u8::from_str_radix(hex, 16).ok())
    };
    let [red, green, blue] = [1, 3, 5].map(|at| part(at).unwrap_or(0));
    (red, green, blue)
}

/// Returns hues by the golden angle, which never come back, in three lightnesses.
fn further(n: usize) -> String {
    // 360° / φ²: each hue falls into the largest gap that those before have left.
    const GOLDEN_ANGLE: f64 = 137.507_764;
    let hue = (100.0 + GOLDEN_ANGLE * n as f64) % 360.0;
    // Neighbours in the order differ in lightness, too: many hues alone are soon alike.
    let lightness = [0.46, 0.6, 0.36][n % 3];
    // HSL to RGB as CSS Color 4 has it, with a saturation of 0.6: l - s·min(l, 1-l)·max(-1, min(k-3, 9-k, 1)).
    let swing = 0.6 * f64::min(lightness, 1.0 - lightness);
    let part = |shift: f64| {
        let place = (shift + hue / 30.0) % 12.0;
        let value = lightness - swing * (place - 3.0).min(9.0 - place).clamp(-1.0, 1.0);
        (255.0 * value).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", part(0.0), part(8.0), part(4.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_colour_comes_twice() {
        let mut all: Vec<_> = (0..200).map(colour).collect();
        assert_eq!(all[0], "#d9541e");
        assert!(all.iter().all(|one| one.len() == 7 && one.starts_with('#')));
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 200);
    }

    #[test]
    fn a_colour_has_three_parts() {
        assert_eq!(rgb("#d9541e"), (0xd9, 0x54, 0x1e));
        assert_eq!(rgb(NEUTRAL), (0x8a, 0x8a, 0x8a));
    }
}
