//! A value that a user wrote and that cannot be used.

use std::fmt;

/// A wrong value: the path of its field, the value received and the one expected, with the error code of the manuals where they
/// have one.
///
/// ```
/// use coaxle_node::config::Wrong;
///
/// let wrong = Wrong::of("limits.velocity", 0, "above 0 u/s").within("far[2]");
/// assert_eq!(wrong.to_string(), "far[2].limits.velocity: received 0, expected above 0 u/s");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    pub(super) field: String,
    pub(super) reason: String,
}

impl Wrong {
    /// A wrong field.
    pub fn of(
        field: impl Into<String>,
        received: impl fmt::Display,
        expected: impl fmt::Display,
    ) -> Self {
        Self::with_reason(
            field,
            format_args!("received {received}, expected {expected}"),
        )
    }

    /// A wrong value whose field only its reader knows.
    pub fn value(received: impl fmt::Display, expected: impl fmt::Display) -> Self {
        Self::of("", received, expected)
    }

    /// A field with an error of another room, whose text says what was received and what is expected.
    pub fn with_reason(field: impl Into<String>, reason: impl ToString) -> Self {
        Self {
            field: field.into(),
            reason: reason.to_string(),
        }
    }

    /// Adds the error code of the manuals.
    #[must_use]
    pub fn with_code(self, code: u32) -> Self {
        Self {
            reason: format!("{code:#06x}: {}", self.reason),
            ..self
        }
    }

    /// Adds the place of the table that the field is in: `far[2]`.
    #[must_use]
    pub fn within(self, place: impl fmt::Display) -> Self {
        // A wrong value without a field is the whole of its place.
        let point = if self.field.is_empty() { "" } else { "." };
        Self {
            field: format!("{place}{point}{}", self.field),
            ..self
        }
    }

    /// The field, as a path; empty for a value without one.
    #[must_use]
    pub fn field(&self) -> &str {
        &self.field
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.field.is_empty() {
            write!(f, "{}: ", self.field)?;
        }
        f.write_str(&self.reason)
    }
}

impl std::error::Error for Wrong {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_comes_first_then_the_code_then_received_and_expected() {
        let value = Wrong::value(7, "1 to 3");
        assert_eq!(value.to_string(), "received 7, expected 1 to 3");
        let field = value.with_code(0x4b32).within("table").within("cams[1]");
        let text = "cams[1].table: 0x4b32: received 7, expected 1 to 3";
        assert_eq!(
            (field.field(), field.to_string()),
            ("cams[1].table", text.to_owned())
        );
        assert_eq!(
            field.in_file("c.toml").to_string(),
            format!("c.toml: {text}")
        );
    }
}
