//! Cam plates from files: motion functions and position tables as TOML, tables also as CSV.
//!
//! | PLC name | in the file |
//! |--|--|
//! | `MC_MotionFunctionPoint` | `[[point]]`, or a row of the CSV file of `[points]` |
//! | `MC_MotionFunctionType` | `law` |
//! | `MC_MotionPointType` | `type` |
//! | `MC_CAM_REF` of a position table | `[table]` |
//! | `MC_TableType` | `[[point]]`, or `[table]` with `equidistant` true or false |
//! | `MC_InterpolationType` | `interpolation` |
//! | `Periodic` of `MC_CamTableSelect` | `course = "cyclic"` |
//! | `MC_CAM_ID` | `table-id` |
//!
//! `docs/CAMS.md` describes the format with examples.

mod error;
mod text;

use std::borrow::Cow;
use std::ops::Deref;
use std::path::Path;

use coaxle_node::config::{ConfigError, Position, Wrong, elements_of, from_table, parse_table};
use coaxle_node::text_file;
use coaxle_node::two_columns::Source;
use coaxle_plate::{CamError, Course, Interpolation, MotionPoint, Plate, PlateSource, SourceRows};
use schemars::{JsonSchema, Schema, SchemaGenerator};

pub use error::CamFileError;
pub use text::TableId;

/// Greatest size of a cam file, bytes: longer tables are in CSV files.
// Some 40 000 points of 100 bytes: a file that people still edit.
pub const MOST_BYTES: u64 = 4 << 20;

/// A cam file: read, but its course not yet calculated.
#[derive(Clone, Debug, PartialEq)]
pub struct CamFile {
    /// A title of one line.
    pub title: String,
    /// Number by which couplings refer to the plate.
    pub table_id: Option<TableId>,
    /// Unit of the master positions, for people.
    pub master_unit: String,
    /// Unit of the slave positions, for people.
    pub slave_unit: String,
    /// Behaviour beyond the first and the last master position.
    pub course: Course,
    /// Points or table of the plate.
    pub shape: Shape,
    /// Name of the file in errors.
    file: String,
    /// Positions of its points or rows in the file; empty for a part of another file.
    elements: Vec<Position>,
}

/// Definition of a plate's shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A motion function: points, and laws between them.
    Points(Points),
    /// A position table.
    Table(Table),
}

/// The points of a motion function as a file has them. Reads as a slice.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    points: Vec<MotionPoint>,
    /// The CSV file they come from, with the line of each.
    source: Option<Source>,
}

impl Deref for Points {
    type Target = [MotionPoint];

    fn deref(&self) -> &[MotionPoint] {
        &self.points
    }
}

/// A position table as a file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Master and slave positions.
    pub rows: Vec<(f64, f64)>,
    /// True if the master positions are declared equidistant.
    pub equidistant: bool,
    /// Interpolation between the rows.
    pub interpolation: Interpolation,
    /// The CSV file the rows come from, with the line of each.
    source: Option<Source>,
}

/// The schema of the file.
impl JsonSchema for CamFile {
    fn schema_name() -> Cow<'static, str> {
        "CamFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        text::CamText::json_schema(generator)
    }
}

impl CamFile {
    /// Reads a cam file, and the CSV file it names.
    ///
    /// # Errors
    /// [`CamFileError`], naming the file, the point or row, and the field.
    pub fn load(path: &Path) -> Result<Self, CamFileError> {
        let text = text_file::read(path, MOST_BYTES).map_err(ConfigError::from)?;
        Self::parse(path, &text)
    }

    /// Reads a cam file from text. `path` is its name in errors, and a CSV file is searched for in
    /// its folder.
    ///
    /// # Errors
    /// [`CamFileError`], naming the file, the point or row, and the field.
    pub fn parse(path: &Path, text: &str) -> Result<Self, CamFileError> {
        let file = path.display().to_string();
        let table = parse_table(&file, text)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut read = Self::read(&file, folder, table)
            // First the lines, which are found by the path, and then the number that people read.
            .map_err(|error| error.in_text(&file, text).with_points())?;
        read.elements = match read.shape {
            // `[[point]]` and `[table]` have their elements at different paths.
            Shape::Points(_) => elements_of(text, &["point"]),
            Shape::Table(_) => elements_of(text, &["table", "rows"]),
        };
        Ok(read)
    }

    /// Resolves the relative paths of the CSV files that the contents of a cam file name, from
    /// `folder`. A value of another type stays for the error of [`from_table`](Self::from_table).
    pub fn resolve_files(contents: &mut toml::Table, folder: &Path) {
        text::resolve_files(contents, folder);
    }

    /// Reads a cam file from a table, for example a part of another file. `file` is its name in
    /// errors, and a CSV file is searched for in `folder`.
    ///
    /// # Errors
    /// [`CamFileError`], naming the file, the point or row, and the field.
    pub fn from_table(file: &str, folder: &Path, table: toml::Table) -> Result<Self, CamFileError> {
        Self::read(file, folder, table).map_err(CamFileError::with_points)
    }

    /// Reads a cam file, with points by their paths in errors: `point[2].law`.
    fn read(file: &str, folder: &Path, table: toml::Table) -> Result<Self, CamFileError> {
        let parsed: text::CamText = from_table(file, table)?;
        let shape = parsed.shape(file, folder)?;
        shape.check_size(file)?;
        Ok(Self {
            shape,
            title: parsed.title,
            table_id: parsed.table_id,
            master_unit: parsed.master_unit,
            slave_unit: parsed.slave_unit,
            course: parsed.course,
            file: file.to_owned(),
            elements: Vec::new(),
        })
    }

    /// Calculates the plate.
    ///
    /// # Errors
    /// [`CamFileError::Plate`] with the NC's number, naming the point or the row.
    pub fn plate(&self) -> Result<Plate, CamFileError> {
        self.source().plate().map_err(|error| CamFileError::Plate {
            place: self.place_of(&error),
            error,
        })
    }

    /// The points or table of the plate, for a calculation elsewhere.
    #[must_use]
    pub fn source(&self) -> PlateSource {
        // Copied: the plate is calculated elsewhere, and the file stays for its places.
        let rows = match &self.shape {
            Shape::Points(points) => SourceRows::Points(points.to_vec()),
            Shape::Table(table) => SourceRows::Positions {
                rows: table.rows.clone(),
                interpolation: table.interpolation,
                equidistant: table.equidistant,
            },
        };
        PlateSource {
            course: self.course,
            rows,
        }
    }

    /// The file, and the field or the line if known.
    fn place_of(&self, error: &CamError) -> String {
        match &self.shape {
            Shape::Points(points) => points
                .line_of(error)
                // A CSV file of points names its own line, the cam file the place of the point.
                .unwrap_or_else(|| self.file_at(error.row())),
            Shape::Table(table) => table.place_of(&self.file_at(error.row()), error),
        }
    }
}

impl CamFile {
    /// The file, with line and column of a point or row if known.
    fn file_at(&self, row: Option<usize>) -> String {
        // A part of another file has no positions.
        let position = row.and_then(|row| self.elements.get(row));
        match position {
            Some(position) => format!("{}:{position}", self.file),
            None => self.file.clone(),
        }
    }
}

/// The largest number of a point or a row: the limit that a receiver accepts for an axis.
const LARGEST: f64 = PlateSource::LARGEST;

impl Shape {
    /// Checks that no number exceeds the limit of an axis. Non-finite numbers are refused by the
    /// plate itself.
    fn check_size(&self, file: &str) -> Result<(), ConfigError> {
        let check = |field: &dyn Fn() -> String, received: f64| {
            // `NaN` would pass no comparison: the plate refuses it with the NC's number.
            if !received.is_finite() || received.abs() <= LARGEST {
                return Ok(());
            }
            let received = format!("{received:e}");
            let expected = format!("a number from -{LARGEST:e} to {LARGEST:e}");
            Err(Wrong::of(field(), received, expected).in_file(file))
        };
        match self {
            Self::Points(points) => points.iter().enumerate().try_for_each(|(row, point)| {
                let values = [
                    ("master", point.master),
                    ("slave", point.slave),
                    ("velocity", point.velocity),
                    ("acceleration", point.acceleration),
                    ("jerk", point.jerk),
                ];
                let mut values = values.into_iter();
                values.try_for_each(|(name, value)| check(&|| points.place_of(row, name), value))
            }),
            Self::Table(table) => {
                let mut rows = table.rows.iter().enumerate();
                rows.try_for_each(|(row, (master, slave))| {
                    check(&|| table.place_of_row(row, "master"), *master)?;
                    check(&|| table.place_of_row(row, "slave"), *slave)
                })
            }
        }
    }
}

impl Points {
    /// A point and its field: the line of a CSV file, or the point in the cam file.
    fn place_of(&self, row: usize, field: &str) -> String {
        match &self.source {
            // As many lines as points, by the reading of both in one loop.
            Some(csv) => format!("{}: line {}, {field}", csv.file, csv.lines[row]),
            None => format!("point[{row}].{field}"),
        }
    }

    /// The CSV file, and the line in it if known; none for points in the cam file.
    fn line_of(&self, error: &CamError) -> Option<String> {
        let csv = self.source.as_ref()?;
        // `get`: an error may name the point behind the last one.
        let line = error.row().and_then(|row| csv.lines.get(row));
        Some(match line {
            Some(line) => format!("{}: line {line}", csv.file),
            None => csv.file.clone(),
        })
    }
}

impl Table {
    /// A row and its column: the line of a CSV file, or the row in the cam file.
    fn place_of_row(&self, row: usize, column: &str) -> String {
        match &self.source {
            Some(csv) => format!("{}: line {}, {column}", csv.file, csv.lines[row]),
            None => format!("table.rows[{row}], {column}"),
        }
    }

    /// Place of the error: the line of a CSV file, or the row in the cam file.
    fn place_of(&self, file: &str, error: &CamError) -> String {
        let row = error.row();
        match (&self.source, row) {
            (None, None) => format!("{file}: table"),
            (None, Some(row)) => format!("{file}: table.rows[{row}]"),
            (Some(csv), None) => csv.file.clone(),
            (Some(csv), Some(row)) => format!("{}: line {}", csv.file, csv.lines[row]),
        }
    }
}

#[cfg(test)]
mod tests;
