//! Changes of the text of a cam file.

use coaxle_files::cam::{CamFile, Shape};
use coaxle_plate::{MotionPoint, PointType};
use serde::Deserialize;
use serde_json::Value as Json;
use toml_edit::{Array, DocumentMut, Value};

use super::CamDesign;
use super::points::{count, insert_behind, point, remove, rows};
use super::view_settings::ViewSettings;
use crate::edit::toml_text::{document, number, put, put_at, value_of};

/// A change from the page.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum CamPageChange {
    /// A point or row is dragged to a place of a chart: 0 position, 1 velocity, 2 acceleration.
    Drag {
        point: usize,
        quantity: usize,
        along: f64,
        value: f64,
        /// Size of a pixel, horizontally and vertically: finer than this is not intended.
        grain: [f64; 2],
    },
    /// A field of a point, or of a row: `master` or `slave`. Null takes it out.
    Set {
        point: usize,
        field: String,
        value: Json,
    },
    /// A field of the head, or of the table.
    Head { field: String, value: Json },
    /// A point or row at a place of the first chart.
    Insert {
        along: f64,
        value: f64,
        grain: [f64; 2],
    },
    /// A point or row is taken out.
    Remove { point: usize },
}

/// Fields of the file that are no points.
const HEAD: [&str; 7] = [
    "title",
    "table-id",
    "course",
    "master-unit",
    "slave-unit",
    "table.interpolation",
    "table.equidistant",
];
/// Fields of a point that the page changes.
const FIELDS: [&str; 8] = [
    "law",
    "type",
    "relative-next",
    "master",
    "slave",
    "velocity",
    "acceleration",
    "jerk",
];

pub(super) fn changed(
    design: &CamDesign,
    text: &str,
    change: &Json,
    settings: &ViewSettings,
) -> Result<String, String> {
    let change = CamPageChange::deserialize(change).map_err(|error| error.to_string())?;
    let mut document = document(text)?;
    let names_csv = |part: &str| {
        let part = document.get(part);
        part.is_some_and(|part| part.get("csv").is_some())
    };
    // The page writes one file only.
    let rows_elsewhere = names_csv("table") || names_csv("points");
    if rows_elsewhere && !matches!(change, CamPageChange::Head { .. }) {
        return Err("the rows are in a CSV file of their own, and are changed there".to_owned());
    }
    // A text that makes no cam file can still be repaired: by its head, or by taking points out.
    let cam = CamFile::parse(&design.path, text);
    let start = match cam.as_ref().map(|cam| &cam.shape) {
        Ok(Shape::Points(points)) => points.first().map(|point| point.master),
        Ok(Shape::Table(table)) => table.rows.first().map(|row| row.0),
        Err(_) => None,
    };
    // Time on the axis begins at the first master position.
    let start = start.unwrap_or_default();
    // A plate that is dragged stays one: it stops where it would end being one.
    let must_stay = matches!(
        change,
        CamPageChange::Drag { .. } | CamPageChange::Insert { .. }
    ) && design.plate(text).is_ok();
    match change {
        CamPageChange::Head { field, value } => {
            if !HEAD.contains(&field.as_str()) {
                return Err(format!(
                    "received field {field:?}, expected one of {}",
                    HEAD.join(", ")
                ));
            }
            put_at(&mut document, &field, optional(&value)?)?;
        }
        CamPageChange::Set {
            point: n,
            field,
            value,
        } => set(&mut document, n, &field, optional(&value)?)?,
        CamPageChange::Drag {
            point: n,
            quantity,
            along,
            value,
            grain,
        } => {
            let master = rounded(
                settings.master(start, along),
                // A width, not a place: without the start.
                settings.master(0.0, grain[0]),
            );
            let value = rounded(
                value / settings.factor(quantity),
                grain[1] / settings.factor(quantity),
            );
            drag(&mut document, n, quantity, master, value)?;
        }
        CamPageChange::Insert {
            along,
            value,
            grain,
        } => {
            let master = rounded(
                settings.master(start, along),
                settings.master(0.0, grain[0]),
            );
            insert(
                &mut document,
                cam.ok().as_ref(),
                master,
                rounded(value, grain[1]),
            )?;
        }
        CamPageChange::Remove { point: n } => take_out(&mut document, n)?,
    }
    let text = document.to_string();
    // After all changes, on the text itself: the check is the one of saving.
    if must_stay {
        design.plate(&text)?;
    }
    Ok(text)
}

fn optional(value: &Json) -> Result<Option<Value>, String> {
    match value {
        Json::Null => Ok(None),
        value => value_of(value).map(Some),
    }
}

/// To a step of 1, 2 or 5 times a power of ten that is no coarser than the screen.
fn rounded(value: f64, grain: f64) -> f64 {
    // Negative where a master runs backwards over a time axis.
    let grain = grain.abs();
    // Written so that NaN is refused as well.
    if !(grain > 0.0 && grain.is_finite()) {
        return value;
    }
    // Of 1, 2 and 5 the largest that is not above the grain: a digit more would be noise of the mouse.
    let power = grain.log10().floor();
    let digits = grain / 10_f64.powf(power);
    let step = if digits >= 5.0 {
        5.0
    } else if digits >= 2.0 {
        2.0
    } else {
        1.0
    };
    // Through text, as a power of ten below one is none of binary numbers.
    let whole = (value / (step * 10_f64.powf(power))).round() * step;
    format!("{whole}e{power}").parse().unwrap_or(value)
}

fn no_point(n: usize) -> String {
    format!("received point {}, expected one that is there", n + 1)
}

fn set(
    document: &mut DocumentMut,
    n: usize,
    field: &str,
    value: Option<Value>,
) -> Result<(), String> {
    if let Some(rows) = rows(document) {
        let column = ["master", "slave"].iter().position(|name| *name == field);
        let row = rows.get_mut(n).and_then(Value::as_array_mut);
        let (Some(row), Some(column), Some(value)) = (row, column, value) else {
            return Err(no_point(n));
        };
        return set_cell(row, column, value);
    }
    if !FIELDS.contains(&field) {
        return Err(format!(
            "received field {field:?}, expected one of {}",
            FIELDS.join(", ")
        ));
    }
    let point = point(document, n).ok_or_else(|| no_point(n))?;
    // Files leave derivatives of 0 out, since 0 is their default.
    let is_zero = value.as_ref().and_then(as_number) == Some(0.0);
    let may_be_left_out = matches!(field, "velocity" | "acceleration" | "jerk");
    put(
        point,
        field,
        value.filter(|_| !(is_zero && may_be_left_out)),
    );
    forget_wrong_type(point, field);
    Ok(())
}

fn set_cell(row: &mut Array, column: usize, mut value: Value) -> Result<(), String> {
    let cell = row.get_mut(column).ok_or("the row has no such column")?;
    // Blanks and comments around the old number stay.
    *value.decor_mut() = cell.decor().clone();
    *cell = value;
    Ok(())
}

/// Removes the type of a point if its own values contradict it.
fn forget_wrong_type(point: &mut dyn toml_edit::TableLike, field: &str) {
    let kind = point.get("type").and_then(|item| item.as_str());
    let kind = PointType::ALL
        .into_iter()
        .find(|known| Some(known.file_name()) == kind);
    let is_moved = |field: &str| {
        point
            .get(field)
            .and_then(|item| as_number(item.as_value()?))
            // A field that is left out is 0 and contradicts nothing.
            .is_some_and(|value| value != 0.0)
    };
    let contradicts = kind.is_some_and(|kind| {
        kind.stands_still() && is_moved("velocity")
            || kind.keeps_its_velocity() && is_moved("acceleration")
    });
    // Not when the type itself is set: then the error names the contradiction.
    if contradicts && field != "type" {
        put(point, "type", None);
    }
}

fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn drag(
    document: &mut DocumentMut,
    n: usize,
    quantity: usize,
    master: f64,
    value: f64,
) -> Result<(), String> {
    match quantity {
        0 => {
            // Both at once, as a point that is dragged in the plane changes both.
            set(document, n, "master", Some(number(master)))?;
            set(document, n, "slave", Some(number(value)))
        }
        1 => set(document, n, "velocity", Some(number(value))),
        2 => set(document, n, "acceleration", Some(number(value))),
        _ => Err("the jerk is not dragged: it follows from the laws".to_owned()),
    }
}

/// Between the points or rows that are around it; beyond the last one it is the last one.
fn insert(
    document: &mut DocumentMut,
    cam: Option<&CamFile>,
    master: f64,
    slave: f64,
) -> Result<(), String> {
    let cam = cam.ok_or("a point can be added to what makes a cam file")?;
    match &cam.shape {
        Shape::Points(points) => {
            // From the back: masters increase, so the first one found is the neighbour.
            let before = points.iter().rposition(|point| point.master < master);
            let before = before.ok_or("expected a place behind the first point")?;
            let last = points.len() - 1;
            if before == last {
                // Wraps for a single point, and then finds none.
                let law = law_behind(points.get(last.wrapping_sub(1)));
                if let Some(end) = point(document, last)
                    // The last point needs no law as long as it is the last: no segment begins there.
                    && !end.contains_key("law")
                {
                    put(end, "law", Some(Value::from(law)));
                }
                insert_behind(document, last, None, master, slave);
            } else {
                insert_behind(
                    document,
                    before,
                    Some(law_behind(points.get(before))),
                    master,
                    slave,
                );
            }
        }
        Shape::Table(table) => {
            let before = table.rows.iter().rposition(|row| row.0 < master);
            let place = before.ok_or("expected a place behind the first row")? + 1;
            let rows = rows(document).ok_or("the rows are in a file of their own")?;
            let row: Array = [number(master), number(slave)].into_iter().collect();
            let mut row = Value::from(row);
            // Indentation and line break of the row before, so that the array stays a column.
            let decor = rows.get(place - 1).map(|row| row.decor().clone());
            *row.decor_mut() = decor.unwrap_or_default();
            rows.insert_formatted(place, row);
        }
    }
    Ok(())
}

/// The law behind a new point: that of the segment where it may rest, else one from any motion to any.
fn law_behind(point: Option<&MotionPoint>) -> &'static str {
    use coaxle_curve::law::MotionLaw as L;
    match point.map(|point| point.function) {
        Some(
            law @ (L::Polynom3
            | L::Polynom7
            | L::Polynom8
            | L::Polynom9
            | L::Polynom11
            | L::Peisekah11
            | L::Sinuslinie
            | L::Modsinuslinie
            | L::Bestehorn
            | L::Beschltrapez
            | L::Polynom5Mm
            | L::Polynom7Mm
            | L::ModsinuslinieVv
            | L::Polynom3Vv),
        ) => law.file_name(),
        Some(law) if law.is_spline() => L::Spline.file_name(),
        // The usual law between rests: continuous in acceleration.
        Some(L::Polynom5) | None => L::Polynom5.file_name(),
        Some(_) => L::Polynom5Mm.file_name(),
    }
}

fn take_out(document: &mut DocumentMut, n: usize) -> Result<(), String> {
    if let Some(rows) = rows(document) {
        if n >= rows.len() {
            return Err(no_point(n));
        }
        rows.remove(n);
        return Ok(());
    }
    if n >= count(document) {
        return Err(no_point(n));
    }
    remove(document, n);
    Ok(())
}
