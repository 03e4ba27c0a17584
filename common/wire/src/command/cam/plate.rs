//! A plate in an order: the content of a cam file, as JSON.

use std::sync::Arc;

use coaxle_cam::TableId;
use coaxle_plate::{Course, Interpolation, PlateSource, SourceRows, WrittenPoint};
use serde::{Deserialize, Serialize};

/// Plate to select: shared, since the response and the recording keep the order too.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "PlateOnWire", into = "PlateOnWire")]
pub struct PlateOrder {
    source: Arc<PlateSource>,
    table_id: Option<TableId>,
}

impl PlateOrder {
    /// Makes the order of a plate of this source, with its own number.
    #[must_use]
    pub fn new(source: PlateSource, table_id: Option<TableId>) -> Self {
        Self {
            source: Arc::new(source),
            table_id,
        }
    }

    /// Returns the source of the plate.
    #[must_use]
    pub const fn source(&self) -> &Arc<PlateSource> {
        &self.source
    }

    /// Returns the own number of the plate.
    #[must_use]
    pub const fn table_id(&self) -> Option<TableId> {
        self.table_id
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for PlateOrder {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "CamPlate".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        PlateOnWire::json_schema(generator)
    }
}

/// A cam plate: a motion function of points, or a table of positions.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct PlateOnWire {
    /// For people; not used.
    #[serde(default, skip_serializing)]
    #[allow(dead_code, reason = "a cam file has it")]
    title: Option<String>,
    /// Number of the plate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    table_id: Option<TableId>,
    /// For people; not used.
    #[serde(default, skip_serializing)]
    #[allow(dead_code, reason = "a cam file has it")]
    master_unit: Option<String>,
    /// For people; not used.
    #[serde(default, skip_serializing)]
    #[allow(dead_code, reason = "a cam file has it")]
    slave_unit: Option<String>,
    /// Course: linear, or repeated from cycle to cycle.
    #[serde(default)]
    course: Course,
    /// Points of a motion function.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    point: Vec<WrittenPoint>,
    /// Table of positions, instead of points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    table: Option<TableOnWire>,
}

/// Table of positions.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct TableOnWire {
    /// True if the master positions are equidistant, which is checked then.
    #[serde(default)]
    equidistant: bool,
    /// Interpolation of the slave between two rows.
    #[serde(default)]
    interpolation: Interpolation,
    /// The rows: master position, x, and slave position, u.
    rows: Vec<(f64, f64)>,
}

impl TryFrom<PlateOnWire> for PlateOrder {
    type Error = String;

    fn try_from(plate: PlateOnWire) -> Result<Self, String> {
        let rows = match (plate.table, &plate.point[..]) {
            (Some(table), []) => SourceRows::Positions {
                rows: table.rows,
                interpolation: table.interpolation,
                equidistant: table.equidistant,
            },
            (None, points @ [_, ..]) => {
                SourceRows::Points(WrittenPoint::to_points(points).map_err(|row| {
                    let point = row + 1;
                    format!(
                        "point {point}, law: received none, expected one: only the last point and ignored ones need none"
                    )
                })?)
            }
            (None, []) => return Err("0x4b35: received neither point nor table, expected one of them".into()),
            (Some(_), [_, ..]) => return Err("0x4b35: received point and table, expected one of them".into()),
        };
        let course = plate.course;
        Ok(Self::new(PlateSource { course, rows }, plate.table_id))
    }
}

impl From<PlateOrder> for PlateOnWire {
    fn from(plate: PlateOrder) -> Self {
        let (point, table) = match &plate.source.rows {
            SourceRows::Points(points) => (points.iter().map(WrittenPoint::from).collect(), None),
            SourceRows::Positions {
                rows,
                interpolation,
                equidistant,
            } => {
                let table = TableOnWire {
                    equidistant: *equidistant,
                    interpolation: *interpolation,
                    rows: rows.clone(),
                };
                (Vec::new(), Some(table))
            }
        };
        Self {
            title: None,
            table_id: plate.table_id,
            master_unit: None,
            slave_unit: None,
            course: plate.source.course,
            point,
            table,
        }
    }
}
