//! Why a file was refused.

use std::fmt;

use coaxle_wire::one_line;

use super::place::{Place, Position};
use super::reworded::{is_missing, is_unknown, reworded};
use super::schema::Finding;
use crate::text_file::Unreadable;

/// Why a config was refused: each mistake with the file, the field and what is wrong with it, all on one line.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file could not be read.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// It holds what it must not: at least one mistake, in the order of the file.
    #[error("{}", joined(.0))]
    Wrong(Vec<Mistake>),
}

/// Something that is wrong in a file: `r.toml:12:8: far "belt".mode: received "pt2", expected …`, on one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    file: String,
    position: Option<Position>,
    field: String,
    reason: String,
}

impl ConfigError {
    /// An error of one field, found by a check of its own. `field` is its path: `receiver[1].slave[0].gear`.
    pub fn field(file: &str, field: impl AsRef<str>, reason: impl ToString) -> Self {
        Self::Wrong(vec![Mistake::new(file, field.as_ref(), reason)])
    }

    /// An error of the config as a whole, which names its fields itself.
    pub fn whole(file: &str, reason: impl ToString) -> Self {
        Self::field(file, "", reason)
    }

    /// What serde refused, with all fields that are missing or unknown.
    pub(super) fn read(file: &str, field: &str, reason: &str, findings: Vec<Finding>) -> Self {
        let by_serde = Mistake::new(file, field, reason);
        let findings = findings.into_iter();
        let mut mistakes: Vec<_> = findings
            .map(|Finding { field, reason }| Mistake::new(file, &field, reason))
            .collect();
        // A field that is missing or unknown is among them, unless it is hidden from the schema.
        if mistakes.is_empty() || !(is_missing(reason) || is_unknown(reason)) {
            mistakes.push(by_serde);
        }
        Self::Wrong(mistakes)
    }

    /// The text is no TOML.
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

    /// The same with the line and the column of each field in `text`, which is what `file` holds, and with the names of
    /// what is numbered in it: `receiver "saw"` for `receiver[2]`.
    #[must_use]
    pub fn in_text(self, file: &str, text: &str) -> Self {
        let Self::Wrong(mut mistakes) = self else {
            return self;
        };
        let file = one_line(file);
        for mistake in mistakes.iter_mut().filter(|mistake| mistake.file == file) {
            mistake.be_placed(text);
        }
        mistakes.sort_by_key(|mistake| mistake.position);
        Self::Wrong(mistakes)
    }

    /// The same with the names of what is numbered, where there is no text with lines: with some values overridden.
    #[must_use]
    pub fn in_table(self, file: &str, table: &toml::Table) -> Self {
        let mut named = self.in_text(file, &table.to_string());
        if let Self::Wrong(mistakes) = &mut named {
            mistakes
                .iter_mut()
                .for_each(|mistake| mistake.position = None);
        }
        named
    }

    /// What is wrong, a line for each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::Unreadable(reason) => vec![reason.to_string()],
            Self::Wrong(mistakes) => mistakes.iter().map(ToString::to_string).collect(),
        }
    }

    /// The same with its fields called otherwise. What is the same then is told once.
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

/// Which key stands in the text twice, if that is what is wrong.
fn twice(text: &str, error: &toml::de::Error) -> Option<String> {
    let key = text.get(error.span()?)?;
    let is_so = error.message() == "duplicate key";
    is_so.then(|| format!(" {}, expected once", one_line(key)))
}

/// What may have been meant where the parser stumbles over a comma between two digits, or over what follows it.
fn decimal_comma(text: &str, start: usize) -> Option<String> {
    let line_start = text.get(..start)?.rfind('\n').map_or(0, |end| end + 1);
    let is_digit = |c: char| c.is_ascii_digit();
    let behind = text.get(start..)?.find(|c| !is_digit(c) && c != ',');
    let number_end = behind.map_or(text.len(), |length| start + length);
    let before = text.get(line_start..number_end)?;
    let (whole, part) = before.trim_end().rsplit_once(',')?;
    let (key, whole) = whole.rsplit_once('=')?;
    let whole = whole.trim();
    let are_digits = [whole, part]
        .iter()
        .all(|digits| !digits.is_empty() && digits.chars().all(is_digit));
    (are_digits && !key.is_empty()).then(|| format!("; did you mean {whole}.{part}?"))
}

fn joined(mistakes: &[Mistake]) -> String {
    match mistakes {
        [only] => only.to_string(),
        // Many are cut in the middle, as any other line is that is too long.
        many => {
            let lines: Vec<_> = many.iter().map(ToString::to_string).collect();
            one_line(&lines.join("; "))
        }
    }
}

impl Mistake {
    /// Of a field, or of the file as a whole where the field is empty.
    pub(super) fn new(file: &str, field: &str, reason: impl ToString) -> Self {
        Self {
            file: one_line(file),
            position: None,
            field: one_line(field),
            reason: one_line(&reworded(&reason.to_string())),
        }
    }

    /// Looks its field up in the text of its file. A reason that begins with a field of that field is told apart from it.
    fn be_placed(&mut self, text: &str) {
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
