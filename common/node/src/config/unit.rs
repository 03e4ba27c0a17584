//! The unit of an axis.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::wrong::Wrong;

/// Unit of the positions of an axis, for display: `mm`, `°`, `rev`. No values are converted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(inline, extend("minLength" = 1, "maxLength" = LONGEST))]
pub struct Unit(String);

/// Characters of the longest unit.
const LONGEST: usize = 16;

impl Unit {
    /// # Errors
    /// [`Wrong`]: empty, too long, or with a space or a control character in it.
    pub fn new(unit: impl Into<String>) -> Result<Self, Wrong> {
        let unit = unit.into();
        let is_plain = |c: char| !c.is_whitespace() && !c.is_control();
        // Characters, not bytes: `µm/°` is four.
        if (1..=LONGEST).contains(&unit.chars().count()) && unit.chars().all(is_plain) {
            Ok(Self(unit))
        } else {
            let expected = "1 to 16 characters without spaces, such as \"mm\"";
            Err(Wrong::value(format_args!("{unit:?}"), expected))
        }
    }

    /// The unit's text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Replaces the `u` of a unit by that of the axis: `u/s²` becomes `mm/s²`, `ppm` stays.
    #[must_use]
    pub fn in_place_of_u(&self, unit: &str) -> String {
        match unit.strip_prefix('u') {
            // `unit` or `us` begin with a `u`, and are no unit of an axis.
            Some(rest) if rest.is_empty() || rest.starts_with('/') => format!("{self}{rest}"),
            _ => unit.to_owned(),
        }
    }
}

/// Default unit `u`, any unit.
impl Default for Unit {
    fn default() -> Self {
        Self("u".to_owned())
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl TryFrom<String> for Unit {
    type Error = Wrong;
    fn try_from(unit: String) -> Result<Self, Wrong> {
        Self::new(unit)
    }
}

impl From<Unit> for String {
    fn from(unit: Unit) -> Self {
        unit.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u_stands_for_the_unit_and_nothing_else_does() {
        let mm = Unit::new("mm").unwrap();
        for (unit, expected) in [
            ("u", "mm"),
            ("u/s", "mm/s"),
            ("u/s²", "mm/s²"),
            ("µs", "µs"),
            ("unit", "unit"),
            ("", ""),
        ] {
            assert_eq!(mm.in_place_of_u(unit), expected);
        }
    }

    #[test]
    fn what_is_no_unit_is_refused() {
        for wrong in ["", " ", "m m", "mm\n", "a unit of seventeen"] {
            let error = Unit::new(wrong).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("received {wrong:?}, expected 1 to 16")),
                "{error}"
            );
        }
        assert!(Unit::new("°").is_ok());
    }
}
