//! Errors that name the place in the file.

use coaxle_node::config::ConfigError;
use coaxle_plate::CamError;

/// A cam file without a valid plate.
#[derive(Debug, thiserror::Error)]
pub enum CamFileError {
    /// The file, or the CSV file it names, cannot be read or has invalid contents.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Valid fields that together are not a valid plate.
    #[error("{place}: {error}")]
    Plate {
        /// The file, and the field or line.
        place: String,
        /// The wrong point or row, and the reason.
        error: CamError,
    },
}

impl CamFileError {
    /// The NC error code of this error, where it has one.
    #[must_use]
    pub fn code(&self) -> Option<u32> {
        match self {
            // A mistake in the text is found before there is anything that the NC could refuse.
            Self::Config(_) => None,
            Self::Plate { error, .. } => Some(error.code()),
        }
    }

    /// Adds the lines of the fields in the text of the file.
    pub(super) fn in_text(self, file: &str, text: &str) -> Self {
        match self {
            Self::Config(error) => Self::Config(error.in_text(file, text)),
            error => error,
        }
    }

    /// Counts points from 1, as everywhere but in TOML paths: `point[2].law` becomes `point 3, law`.
    pub(super) fn with_points(self) -> Self {
        // Errors of a plate count from 1 already: only paths of the parser count from 0.
        match self {
            Self::Config(error) => {
                // A field of another kind keeps its path.
                Self::Config(error.with_fields(|field| counted(&field).unwrap_or(field)))
            }
            error => error,
        }
    }
}

fn counted(field: &str) -> Option<String> {
    // Behind the bracket: a field of the file may be called point, too.
    let (row, rest) = field.strip_prefix("point[")?.split_once(']')?;
    let number = row.parse::<usize>().ok()? + 1;
    Some(format!("point {number}{}", rest.replacen('.', ", ", 1)))
}
