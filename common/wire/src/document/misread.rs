//! Why a type could not be read, and where.

use std::fmt::{self, Write};

use serde::de;

/// A reason, with the path of the field that it is about.
///
/// Boxed: a reader returns it through every level of the document, beside values that are small.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Misread(Box<Contents>);

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Contents {
    reason: String,
    /// From the field outwards, as it is found.
    path: Vec<PathStep>,
}

/// A step of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum PathStep {
    Key(String),
    Element(usize),
}

impl Misread {
    /// Returns the reason, without the field.
    #[must_use]
    pub fn reason(&self) -> &str {
        &self.0.reason
    }

    /// Returns the path of the field, such as `far[2].mode`; a dot for the document as a whole.
    #[must_use]
    pub fn field(&self) -> String {
        if self.0.path.is_empty() {
            return ".".to_owned();
        }
        let mut field = String::new();
        for step in self.0.path.iter().rev() {
            // Writing to a text cannot fail.
            let _ = match step {
                PathStep::Element(index) => write!(field, "[{index}]"),
                PathStep::Key(key) if field.is_empty() => field.write_str(key),
                PathStep::Key(key) => write!(field, ".{key}"),
            };
        }
        field
    }

    /// An error without a reason, at the end of a path that begins with the outermost step.
    pub(super) fn at(mut path: Vec<PathStep>) -> Self {
        path.reverse();
        Self(Box::new(Contents {
            path,
            ..Contents::default()
        }))
    }

    /// Replaces the reason.
    pub(super) fn with_reason(mut self, reason: String) -> Self {
        self.0.reason = reason;
        self
    }

    #[cold]
    pub(super) fn within_key(mut self, key: &str) -> Self {
        self.0.path.push(PathStep::Key(key.to_owned()));
        self
    }

    #[cold]
    pub(super) fn within_element(mut self, index: usize) -> Self {
        self.0.path.push(PathStep::Element(index));
        self
    }
}

impl fmt::Display for Misread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.0.path.is_empty() {
            write!(f, "{}: ", self.field())?;
        }
        f.write_str(self.reason())
    }
}

impl std::error::Error for Misread {}

impl de::Error for Misread {
    fn custom<T: fmt::Display>(reason: T) -> Self {
        Self::default().with_reason(reason.to_string())
    }
}
