//! Reasons why a file was refused.

use std::fmt;

use coaxle_wire::one_line;

use super::place::{Place, Position};
use super::reworded::{is_missing, is_unknown, reworded};
use super::wrong::Wrong;
use crate::text_file::Unreadable;

/// Refusal of a config: each mistake with the file, the field and the reason, all on one line.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file could not be read.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// Invalid contents: at least one mistake, in the order of the file.
    #[error("{}", joined(.0))]
    Wrong(Vec<Mistake>),
}

/// A mistake in a file: `r.toml:12:8: far "belt".mode: received "pt2", expected …`, on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    file: String,
    position: Option<Position>,
    field: String,
    reason: String,
}

impl ConfigError {
    /// An error of one field, found by a separate check. `field` is its path:
    /// `receiver[1].slave[0].gear`.
    pub fn field(file: &str, field: impl AsRef<str>, reason: impl ToString) -> Self {
        Self::Wrong(vec![Mistake::new(file, field.as_ref(), reason)])
    }

    /// An error of the config as a whole, whose reason names the fields.
    pub fn whole(file: &str, reason: impl ToString) -> Self {
        Self::field(file, "", reason)
    }

    /// Several errors of one file.
    pub(crate) fn fields(file: &str, fields: impl IntoIterator<Item = Wrong>) -> Self {
        let mistakes = fields.into_iter();
        // In the order of the schema. `in_text` sorts them by their lines.
        let mistakes = mistakes.map(|Wrong { field, reason }| Mistake::new(file, &field, reason));
        Self::Wrong(mistakes.collect())
    }

    /// The error that serde reports, with all missing or unknown fields.
    pub(super) fn read(file: &str, field: &str, reason: &str, findings: Vec<Wrong>) -> Self {
        let by_serde = Mistake::new(file, field, reason);
        let findings = findings.into_iter();
        let mut mistakes: Vec<_> = findings
            .map(|Wrong { field, reason }| Mistake::new(file, &field, reason))
            .collect();
        // A field that is missing or unknown is among them, unless it is hidden from the schema.
        if mistakes.is_empty() || !(is_missing(reason) || is_unknown(reason)) {
            mistakes.push(by_serde);
        }
        Self::Wrong(mistakes)
    }

    /// An error of TOML syntax.
    pub(super) fn syntax(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let start = error.span().map(|span| span.start);
        let comma = start.and_then(|start| decimal_comma(text, start));
        let reason = format!(
            "is not valid TOML: {}{}{}",
            error.message(),
            twice(text, error).unwrap_or_default(),
            comma.unwrap_or_default()
        );
        let position = start.map(|start| Position::of(text, start));
        Self::Wrong(vec![Mistake {
            position,
            ..Mistake::new(file, "", reason)
        }])
    }

    /// Adds the line and the column of each field in `text`, the contents of `file`, and the names
    /// of numbered elements: `receiver "saw"` for `receiver[2]`.
    #[must_use]
    pub fn in_text(self, file: &str, text: &str) -> Self {
        let Self::Wrong(mut mistakes) = self else {
            return self;
        };
        let file = one_line(file);
        // A mistake of another file, such as a CSV, has its own lines.
        for mistake in mistakes.iter_mut().filter(|mistake| mistake.file == file) {
            mistake.locate(text);
        }
        // Sorted stably: mistakes without a place come first, in their order.
        mistakes.sort_by_key(|mistake| mistake.position);
        Self::Wrong(mistakes)
    }

    /// Adds the names of numbered elements where there is no text with lines: with some values
    /// overridden.
    #[must_use]
    pub fn in_table(self, file: &str, table: &toml::Table) -> Self {
        let mut named = self.in_text(file, &table.to_string());
        if let Self::Wrong(mistakes) = &mut named {
            // The text was made from the table, so that its lines say nothing to anybody.
            mistakes
                .iter_mut()
                .for_each(|mistake| mistake.position = None);
        }
        named
    }

    /// The mistakes, a line for each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::Unreadable(reason) => vec![reason.to_string()],
            Self::Wrong(mistakes) => mistakes.iter().map(ToString::to_string).collect(),
        }
    }

    /// Renames the fields. Mistakes that are equal then are kept once.
    #[must_use]
    pub fn with_fields(self, called: impl Fn(String) -> String) -> Self {
        let Self::Wrong(mistakes) = self else {
            return self;
        };
        let called = |mistake: Mistake| Mistake {
            field: called(mistake.field),
            ..mistake
        };
        let mut renamed: Vec<Mistake> = Vec::new();
        for mistake in mistakes.into_iter().map(called) {
            if !renamed.contains(&mistake) {
                renamed.push(mistake);
            }
        }
        Self::Wrong(renamed)
    }
}

// Here and not beside the type, which this module builds on.
impl Wrong {
    /// The error of a file with this field.
    #[must_use]
    pub fn in_file(self, file: &str) -> ConfigError {
        ConfigError::field(file, self.field, self.reason)
    }
}

/// Text on the duplicate key, if that is the error.
fn twice(text: &str, error: &toml::de::Error) -> Option<String> {
    let key = text.get(error.span()?)?;
    // The parser of TOML has no codes: its message is all that tells the kind.
    let is_so = error.message() == "duplicate key";
    is_so.then(|| format!(" {}, expected once", one_line(key)))
}

/// Suggestion for a decimal comma where the parser fails at a comma between two digits, or behind it.
fn decimal_comma(text: &str, start: usize) -> Option<String> {
    let line_start = text.get(..start)?.rfind('\n').map_or(0, |end| end + 1);
    let is_digit = |c: char| c.is_ascii_digit();
    let behind = text.get(start..)?.find(|c| !is_digit(c) && c != ',');
    let number_end = behind.map_or(text.len(), |length| start + length);
    let before = text.get(line_start..number_end)?;
    let (whole, part) = before.trim_end().rsplit_once(',')?;
    let (key, whole) = whole.rsplit_once('=')?;
    let whole = whole.trim();
    // `[1` of a list is not all digits.
    let are_digits = [whole, part]
        .iter()
        .all(|digits| !digits.is_empty() && digits.chars().all(is_digit));
    (are_digits && !key.is_empty()).then(|| format!("; did you mean {whole}.{part}?"))
}

fn joined(mistakes: &[Mistake]) -> String {
    match mistakes {
        [only] => only.to_string(),
        // Many mistakes are cut in the middle, as any line that is too long.
        many => {
            let lines: Vec<_> = many.iter().map(ToString::to_string).collect();
            one_line(&lines.join("; "))
        }
    }
}

impl Mistake {
    /// A mistake in a field, or in the file as a whole where the field is empty.
    pub(super) fn new(file: &str, field: &str, reason: impl ToString) -> Self {
        Self {
            file: one_line(file),
            position: None,
            field: one_line(field),
            // In this order: rewording looks at the beginning, which shortening keeps.
            reason: one_line(&reworded(&reason.to_string())),
        }
    }

    /// Looks its field up in the text of its file. A subfield at the beginning of the reason is
    /// moved to the field.
    fn locate(&mut self, text: &str) {
        // A syntax error has its place from the parser.
        if self.position.is_some() {
            return;
        }
        let Some(place) = Place::find(text, &self.field, &self.reason) else {
            return;
        };
        self.position = place.position;
        self.field = one_line(&place.field);
        self.reason = place.reason;
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(position) = self.position {
            write!(f, ":{position}")?;
        }
        if !self.field.is_empty() {
            write!(f, ": {}", self.field)?;
        }
        write!(f, ": {}", self.reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_wire::MOST_CHARACTERS;

    #[test]
    fn many_mistakes_are_one_line_that_is_not_too_long_or_a_line_for_each() {
        let mistake = Mistake::new("t.toml", "field", "received 1, expected 2");
        let error = ConfigError::Wrong(vec![mistake; 500]);
        let line = error.to_string();
        assert!(line.chars().count() < 2 * MOST_CHARACTERS, "{line}");
        assert_eq!(error.lines().len(), 500);
        assert_eq!(error.lines()[7], "t.toml: field: received 1, expected 2");
    }
}
