//! The text format of a cam file.

use std::path::{Path, PathBuf};

use coaxle_node::config::{ConfigError, Wrong};
use coaxle_node::two_columns;
use coaxle_plate::{Course, Interpolation, WrittenPoint};
use schemars::JsonSchema;
use serde::Deserialize;

use super::{CamFileError, Points, Shape, Table};
use crate::point_table;

/// A cam plate: a motion function of `[[point]]`s or of `[points]` elsewhere, or a `[table]`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct CamText {
    /// A title of one line, such as the plate's purpose.
    #[serde(default)]
    pub(super) title: String,
    /// Number of the plate, by which commands refer to it.
    pub(super) table_id: Option<TableId>,
    /// Unit of the master positions, for display; `x` by default.
    #[serde(default = "any_master_unit")]
    pub(super) master_unit: String,
    /// Unit of the slave positions, for display; `u` by default.
    #[serde(default = "any_slave_unit")]
    pub(super) slave_unit: String,
    /// Linear course, or cyclic: repeated from period to period.
    #[serde(default)]
    pub(super) course: Course,
    /// Points of a motion function, in the order of the master.
    #[serde(default)]
    point: Vec<WrittenPoint>,
    /// The points in a file of their own, instead: for large functions.
    points: Option<PointsText>,
    /// A table of positions, instead of points.
    table: Option<TableText>,
}

fn any_master_unit() -> String {
    "x".to_owned()
}

fn any_slave_unit() -> String {
    "u".to_owned()
}

/// Resolves the relative paths of the CSV files that the contents of a cam file name, from `folder`.
pub(super) fn resolve_files(contents: &mut toml::Table, folder: &Path) {
    for part in ["points", "table"] {
        let csv = contents.get_mut(part).and_then(|part| part.get_mut("csv"));
        if let Some(toml::Value::String(csv)) = csv {
            // A table has only text: of a folder whose name is none, the error for the missing file shows what is left.
            *csv = folder.join(&*csv).to_string_lossy().into_owned();
        }
    }
}

/// Number of a cam plate, 1 to 255.
#[doc(alias = "MC_CAM_ID")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(try_from = "i64")]
#[schemars(inline, extend("minimum" = 1, "maximum" = 255))]
pub struct TableId(u8);

impl TableId {
    /// The number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }
}

impl TryFrom<i64> for TableId {
    type Error = Wrong;
    fn try_from(number: i64) -> Result<Self, Wrong> {
        // From a wider number: a number beyond 255 must not become another plate by wrapping.
        match u8::try_from(number) {
            Ok(id) if id > 0 => Ok(Self(id)),
            _ => Err(Wrong::value(number, "1 to 255").with_code(0x4b32)),
        }
    }
}

/// The points of a motion function in a CSV file next to this one.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "CamPoints")]
struct PointsText {
    /// A CSV file whose first line names the columns, `law`, `master` and `slave` among them; in
    /// the folder of this file.
    csv: PathBuf,
}

/// A table of positions, in the file or in a CSV file next to it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "CamTable")]
struct TableText {
    /// Master positions at equal distances, as is required then.
    #[serde(default)]
    equidistant: bool,
    /// Motion of the slave between two rows.
    #[serde(default)]
    interpolation: Interpolation,
    /// The rows: master position, x, and slave position, u.
    rows: Option<Vec<(f64, f64)>>,
    /// A CSV file with the columns `master` and `slave`, in the folder of this file.
    csv: Option<PathBuf>,
}

impl CamText {
    /// The points or table of the plate; a CSV file is searched for in `folder`.
    pub(super) fn shape(&self, file: &str, folder: &Path) -> Result<Shape, CamFileError> {
        // A slice pattern tells an empty list from a given one.
        match (&self.table, &self.points, &self.point[..]) {
            (Some(table), None, []) => table.checked(file, folder).map(Shape::Table),
            (None, Some(points), []) => points.load(folder).map(Shape::Points),
            (None, None, points @ [_, ..]) => motion_points(file, points).map(Shape::Points),
            (None, None, []) => {
                let expected = "several [[point]], one [points] or one [table]";
                let wrong = Wrong::of("point", "neither points nor a table", expected);
                Err(wrong.with_code(NO_CAM_TYPE).in_file(file).into())
            }
            // A table beside any points is the more likely slip, so that the first field of it is named.
            (Some(_), _, _) => {
                let expected = "either [[point]] or [table]";
                let wrong = Wrong::of("table", "points and a table", expected);
                Err(wrong.with_code(NO_CAM_TYPE).in_file(file).into())
            }
            (None, Some(_), [_, ..]) => {
                let expected = "either [[point]] or [points]";
                let wrong = Wrong::of("points", "points here and in a CSV file", expected);
                Err(wrong.in_file(file).into())
            }
        }
    }
}

/// Error code of the NC for a plate that is neither a motion function nor a table.
const NO_CAM_TYPE: u32 = 0x4b35;

/// The error of a point without a law.
fn no_law(file: &str, place: String) -> ConfigError {
    let expected = "one: only the last point and ignored ones need none";
    Wrong::of(place, "none", expected).in_file(file)
}

fn motion_points(file: &str, points: &[WrittenPoint]) -> Result<Points, CamFileError> {
    // The row with the missing law is the error: the path is made from it.
    let points =
        WrittenPoint::to_points(points).map_err(|row| no_law(file, format!("point[{row}].law")))?;
    Ok(Points {
        points,
        source: None,
    })
}

impl PointsText {
    fn load(&self, folder: &Path) -> Result<Points, CamFileError> {
        // Beside the cam file: both are moved together.
        let (written, source) = point_table::load_points(&folder.join(&self.csv))?;
        let points = WrittenPoint::to_points(&written)
            .map_err(|row| no_law(&source.file, format!("line {}, law", source.lines[row])))?;
        Ok(Points {
            points,
            source: Some(source),
        })
    }
}

impl TableText {
    fn checked(&self, file: &str, folder: &Path) -> Result<Table, CamFileError> {
        let (rows, source) = match (&self.rows, &self.csv) {
            (Some(rows), None) => (rows.clone(), None),
            (None, Some(csv)) => {
                let (rows, source) = two_columns::read(&folder.join(csv), ["master", "slave"])?;
                // With its lines, which errors name instead of rows.
                (rows, Some(source))
            }
            (rows, _) => {
                // Given as missing and given twice need different cures.
                let received = if rows.is_some() { "both" } else { "neither" };
                let received = format!("{received} of rows and csv");
                let wrong = Wrong::of("table", received, "one of them");
                return Err(wrong.in_file(file).into());
            }
        };
        Ok(Table {
            rows,
            equidistant: self.equidistant,
            interpolation: self.interpolation,
            source,
        })
    }
}
