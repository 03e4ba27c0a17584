//! Numbers of messages.

use core::fmt::{self, Write as _};

/// A number of a message, in at most six significant digits.
///
/// ```
/// use coaxle_curve::figure::Rounded;
///
/// assert_eq!(Rounded(0.1 + 0.2).to_string(), "0.3");
/// assert_eq!(Rounded(-57_735.026_918_962).to_string(), "-57735");
/// assert_eq!(Rounded(2.5e-9).to_string(), "2.5e-9");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded(pub f64);

/// A number beside a limit that it is beyond, in as many digits as tell both apart, six at least.
///
/// ```
/// use coaxle_curve::figure::Beyond;
///
/// let received = Beyond { value: 2_000.002, limit: 2_000.0 };
/// assert_eq!(received.to_string(), "2000.002");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// The number.
    pub value: f64,
    /// The limit, shown [`Rounded`].
    pub limit: f64,
}

/// A number in at most six significant digits that is no greater than it is: what is permitted up to it is permitted up to what is shown.
///
/// ```
/// use coaxle_curve::figure::UpTo;
///
/// assert_eq!(UpTo(19.622_848).to_string(), "19.6228");
/// assert_eq!(UpTo(19.622_888).to_string(), "19.6228");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpTo(pub f64);

/// Digits of a number that is shown.
const DIGITS: usize = 6;
/// Digits that tell any two numbers apart.
const MOST_DIGITS: usize = 17;
/// Magnitudes from which on, and below which, powers of ten are shown.
const LARGE: f64 = 1e9;
const SMALL: f64 = 1e-4;

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write(f, rounded(self.0, DIGITS))
    }
}

impl fmt::Display for Beyond {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limit = rounded(self.limit, DIGITS);
        let digits = (DIGITS..MOST_DIGITS).find(|digits| rounded(self.value, *digits) != limit);
        write(f, rounded(self.value, digits.unwrap_or(MOST_DIGITS)))
    }
}

impl fmt::Display for UpTo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write(f, cut(self.0))
    }
}

fn write(f: &mut fmt::Formatter<'_>, value: f64) -> fmt::Result {
    // The shortest text that is read as this number has no more digits than it was rounded to.
    if value == 0.0 || !value.is_finite() || (SMALL..LARGE).contains(&value.abs()) {
        write!(f, "{value}")
    } else {
        write!(f, "{value:e}")
    }
}

/// Returns the nearest number with this count of significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    let text = DigitsText::of(value, digits);
    text.read().parse().unwrap_or(value)
}

/// Returns the number without the digits after the sixth.
fn cut(value: f64) -> f64 {
    let text = DigitsText::of(value, MOST_DIGITS);
    let text = text.read();
    let Some((digits, exponent)) = text.split_once('e') else {
        return value;
    };
    // The digits have a point among them, and maybe a sign before.
    let kept = DIGITS + 1 + usize::from(value < 0.0);
    let mut short = DigitsText::default();
    let written = write!(short, "{}e{exponent}", &digits[..kept.min(digits.len())]);
    written
        .ok()
        .and_then(|()| short.read().parse().ok())
        .unwrap_or(value)
}

/// Text on the stack: a sign, 17 digits with a point, and an exponent.
#[derive(Default)]
struct DigitsText {
    bytes: [u8; 32],
    length: usize,
}

impl DigitsText {
    /// Writes a number with a digit before the point. One that has no room is no text, which is no number.
    fn of(value: f64, digits: usize) -> Self {
        let mut text = Self::default();
        let written = write!(text, "{value:.*e}", digits - 1);
        written.map_or_else(|_| Self::default(), |()| text)
    }

    fn read(&self) -> &str {
        core::str::from_utf8(&self.bytes[..self.length]).unwrap_or_default()
    }
}

impl fmt::Write for DigitsText {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = self.length + text.len();
        let room = self.bytes.get_mut(self.length..end).ok_or(fmt::Error)?;
        room.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString as _;

    #[test]
    fn a_number_has_six_digits_at_most() {
        for (value, text) in [
            (0.0, "0"),
            (-0.1, "-0.1"),
            (1.0 / 3.0, "0.333333"),
            (123_456_789.0, "123457000"),
            (1.234_567_8e12, "1.23457e12"),
            (9.999_999e-5, "0.0001"),
            (1.0 / 3e6, "3.33333e-7"),
            (f64::MAX, "1.79769e308"),
            (f64::MIN_POSITIVE, "2.22507e-308"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Rounded(value).to_string(), text);
        }
    }

    #[test]
    fn what_is_permitted_is_never_shown_as_more() {
        for (value, text) in [
            (19.622_888, "19.6228"),
            (0.999_999_9, "0.999999"),
            (-2.0 / 3.0, "-0.666666"),
            (123_456_789.0, "123456000"),
            (5.0, "5"),
            (0.0, "0"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(UpTo(value).to_string(), text);
        }
    }

    #[test]
    fn a_number_just_beyond_its_limit_is_not_shown_as_the_limit() {
        for (value, limit, text) in [
            (57_735.026_918, 20_000.0, "57735"),
            (0.300_000_04, 0.3, "0.30000004"),
            (2.0f64.next_up(), 2.0, "2.0000000000000004"),
        ] {
            assert_eq!(Beyond { value, limit }.to_string(), text);
        }
    }
}
