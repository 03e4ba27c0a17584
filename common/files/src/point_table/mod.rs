//! The points of a plate in other programs' formats: tables as CSV, arrays of a PLC's structured text.
//!
//! | PLC name | here |
//! |--|--|
//! | `ARRAY OF MC_MotionFunctionPoint` | [`PointTable::Points`] |
//! | `ARRAY[.., 0..1] OF LREAL`, the positions of an `MC_CAM_REF` | [`PointTable::Positions`] |
//!
//! A table contains no course, units or interpolation; these are in a [cam file](crate::cam).
//! `docs/CAMS.md` shows both formats.

mod columns;
mod csv;
mod field;
mod structured_text;
#[cfg(test)]
mod tests;

use std::path::Path;

use coaxle_node::config::{ConfigError, Wrong};
use coaxle_node::text_file;
use coaxle_node::two_columns::Source;
use coaxle_plate::{PlateSource, SourceRows, WrittenPoint};

/// Greatest size of a file with points, bytes.
// A million rows of 64 bytes.
const MOST_BYTES: u64 = 64 << 20;
/// Greatest number of points or rows in it.
const MOST_ROWS: usize = 1_000_000;

/// Contents of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum PointTable {
    /// Points of a motion function, each with the law that leads to the next.
    Points(Vec<WrittenPoint>),
    /// Rows of a position table: master, x, and slave, u.
    Positions(Vec<(f64, f64)>),
}

/// Text format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Columns with separators.
    Csv,
    /// A declaration with initial values, or assignments, in structured text.
    StructuredText,
}

impl PointTable {
    /// Reads a table. In a program in structured text, reads the array of this name; without a
    /// name, the only one.
    ///
    /// # Errors
    /// [`ConfigError`], naming the file, the line and the field.
    pub fn load(path: &Path, format: Format, array: Option<&str>) -> Result<Self, ConfigError> {
        let file = path.display().to_string();
        match format {
            // As a table, since its lines are bounded in length.
            Format::Csv => Self::from_csv(&file, &text_file::read_table(path, MOST_BYTES)?),
            Format::StructuredText => {
                let text = text_file::read(path, MOST_BYTES)?;
                Self::from_structured_text(&file, &text, array)
            }
        }
    }

    /// Reads a table as CSV: with a column `law`, points; otherwise two columns, master and slave.
    /// `file` is its name in errors.
    ///
    /// # Errors
    /// [`ConfigError`], naming the line and the column.
    pub fn from_csv(file: &str, text: &str) -> Result<Self, ConfigError> {
        csv::read(file, text)
    }

    /// Reads an array of structured text. `file` is its name in errors.
    ///
    /// # Errors
    /// [`ConfigError`], naming the line and the field; if there is no such array, or more than one,
    /// the existing ones.
    pub fn from_structured_text(
        file: &str,
        text: &str,
        array: Option<&str>,
    ) -> Result<Self, ConfigError> {
        structured_text::read(file, text, array)
    }

    /// The table as CSV, with a header.
    #[must_use]
    pub fn to_csv(&self) -> String {
        csv::write(self)
    }

    /// The declaration of an array with initial values.
    #[must_use]
    pub fn to_structured_text(&self, array: &str) -> String {
        structured_text::write(self, array)
    }
}

/// Reads the points of a motion function from a CSV file, with their lines.
///
/// # Errors
/// [`ConfigError`], naming the line and the column; also where the file has positions and no laws.
pub(crate) fn load_points(path: &Path) -> Result<(Vec<WrittenPoint>, Source), ConfigError> {
    let file = path.display().to_string();
    let text = text_file::read_table(path, MOST_BYTES)?;
    let (points, lines) = csv::read_points(&file, &text)?;
    Ok((points, Source { file, lines }))
}

impl From<&PlateSource> for PointTable {
    fn from(source: &PlateSource) -> Self {
        match &source.rows {
            SourceRows::Points(points) => {
                Self::Points(points.iter().map(WrittenPoint::from).collect())
            }
            // The interpolation is no part of a table: the cam file has it.
            SourceRows::Positions { rows, .. } => Self::Positions(rows.clone()),
        }
    }
}

fn too_many(file: &str) -> ConfigError {
    let received = format!("more than {MOST_ROWS} rows");
    Wrong::value(received, "at most that many").in_file(file)
}
