//! A cam file as it is written.

use std::path::{Path, PathBuf};

use coaxle_curve::law::MotionLaw;
use coaxle_plate::{Course, Interpolation, MotionPoint, PointType};
use serde::Deserialize;

use super::{CamFileError, Shape, Table};
use crate::config::ConfigError;
use crate::two_columns;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) struct CamText {
    #[serde(default)]
    pub(super) title: String,
    pub(super) table_id: Option<TableId>,
    #[serde(default = "any_master_unit")]
    pub(super) master_unit: String,
    #[serde(default = "any_slave_unit")]
    pub(super) slave_unit: String,
    #[serde(default)]
    pub(super) course: Course,
    #[serde(rename = "point", default)]
    points: Vec<PointText>,
    table: Option<TableText>,
}

fn any_master_unit() -> String {
    "x".to_owned()
}

fn any_slave_unit() -> String {
    "u".to_owned()
}

/// Number of a cam plate, 1 to 255.
#[doc(alias = "MC_CAM_ID")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "i64")]
pub struct TableId(u8);

impl TableId {
    /// The number.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }
}

impl TryFrom<i64> for TableId {
    type Error = String;
    fn try_from(number: i64) -> Result<Self, String> {
        match u8::try_from(number) {
            Ok(id) if id > 0 => Ok(Self(id)),
            _ => Err(format!("0x4b32: received {number}, expected 1 to 255")),
        }
    }
}

/// `[[point]]`
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct PointText {
    index: Option<u32>,
    law: Option<MotionLaw>,
    #[serde(rename = "type")]
    point_type: Option<PointType>,
    #[serde(default = "next_row")]
    relative_next: i32,
    master: f64,
    slave: f64,
    #[serde(default)]
    velocity: f64,
    #[serde(default)]
    acceleration: f64,
    #[serde(default)]
    jerk: f64,
}

const fn next_row() -> i32 {
    1
}

/// `[table]`
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct TableText {
    #[serde(default)]
    equidistant: bool,
    #[serde(default)]
    interpolation: Interpolation,
    rows: Option<Vec<(f64, f64)>>,
    csv: Option<PathBuf>,
}

impl CamText {
    /// What the plate is made of; a CSV file is looked for in `folder`.
    pub(super) fn shape(&self, file: &str, folder: &Path) -> Result<Shape, CamFileError> {
        match (&self.table, &self.points[..]) {
            (Some(table), []) => table.checked(file, folder).map(Shape::Table),
            (None, points @ [_, ..]) => motion_points(file, points).map(Shape::Points),
            (None, []) => Err(ConfigError::field(
                file,
                "point",
                "received neither points nor a table, expected several [[point]] or one [table]",
            )
            .into()),
            (Some(_), [_, ..]) => Err(ConfigError::field(
                file,
                "table",
                "received points and a table, expected either [[point]] or [table]",
            )
            .into()),
        }
    }
}

fn motion_points(file: &str, points: &[PointText]) -> Result<Vec<MotionPoint>, CamFileError> {
    let last = points.len() - 1;
    points
        .iter()
        .enumerate()
        .map(|(row, point)| {
            point.checked(row, row == last).ok_or_else(|| {
                let field = format!("point {}, law", row + 1);
                let reason = "received none, expected one: only the last point and ignored ones \
                              need none";
                ConfigError::field(file, field, reason).into()
            })
        })
        .collect()
}

impl PointText {
    /// The point with what may be left out filled in; none if its law is missing.
    fn checked(&self, row: usize, is_last: bool) -> Option<MotionPoint> {
        let point_type = self.point_type.unwrap_or_else(|| self.implied_type());
        let unused = is_last || point_type == PointType::Ignore;
        Some(MotionPoint {
            index: self.index.unwrap_or(row as u32 + 1),
            function: self.law.or(unused.then_some(MotionLaw::Polynom1))?,
            point_type,
            relative_next: self.relative_next,
            master: self.master,
            slave: self.slave,
            velocity: self.velocity,
            acceleration: self.acceleration,
            jerk: self.jerk,
        })
    }

    /// The kind of point that has these values.
    fn implied_type(&self) -> PointType {
        match (self.velocity != 0.0, self.acceleration != 0.0) {
            (false, false) => PointType::Rest,
            (true, false) => PointType::Velocity,
            (false, true) => PointType::Turn,
            (true, true) => PointType::Motion,
        }
    }
}

impl TableText {
    fn checked(&self, file: &str, folder: &Path) -> Result<Table, CamFileError> {
        let (rows, source) = match (&self.rows, &self.csv) {
            (Some(rows), None) => (rows.clone(), None),
            (None, Some(csv)) => {
                let (rows, source) = two_columns::read(&folder.join(csv), ["master", "slave"])?;
                (rows, Some(source))
            }
            (rows, _) => {
                let received = if rows.is_some() { "both" } else { "neither" };
                let reason = format!("received {received} of rows and csv, expected one of them");
                return Err(ConfigError::field(file, "table", reason).into());
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
