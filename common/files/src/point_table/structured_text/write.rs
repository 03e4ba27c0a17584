//! Writing the declaration of an array, with the parameters for `MC_CamTableSelect`.

use std::fmt::Write as _;

use coaxle_curve::law::MotionLaw;
use coaxle_plate::WrittenPoint;

use crate::point_table::PointTable;
use crate::point_table::field::{Field, type_name};

pub(in crate::point_table) fn write(table: &PointTable, array: &str) -> String {
    match table {
        PointTable::Points(points) => of_points(points, array),
        PointTable::Positions(rows) => of_rows(rows, array),
    }
}

fn of_points(points: &[WrittenPoint], array: &str) -> String {
    let lines = points.iter().enumerate().map(|(row, point)| {
        let values =
            Field::ALL.map(|field| format!("{} := {}", field.plc_name(), value(field, row, point)));
        format!("        ({})", values.join(", "))
    });
    let lines: Vec<_> = lines.collect();
    declaration(
        array,
        // From 1, as the indices of the points.
        &format!("ARRAY[1..{}] OF MC_MotionFunctionPoint", points.len()),
        &lines,
        "MC_TABLETYPE_MOTIONFUNCTION",
        1,
    )
}

fn of_rows(rows: &[(f64, f64)], array: &str) -> String {
    let lines = rows
        .iter()
        .map(|(master, slave)| format!("        {}, {}", number(*master), number(*slave)));
    let lines: Vec<_> = lines.collect();
    // From 0. An array without rows has no last index.
    let last = rows.len().saturating_sub(1);
    declaration(
        array,
        &format!("ARRAY[0..{last}, 0..1] OF LREAL"),
        &lines,
        "MC_TABLETYPE_NONEQUIDISTANT",
        2,
    )
}

fn declaration(
    array: &str,
    kind: &str,
    lines: &[String],
    table_type: &str,
    columns: usize,
) -> String {
    let mut text = String::new();
    let rows = lines.len();
    let _ = writeln!(
        text,
        "(* MC_CAM_REF: pArray := ADR({array}), ArraySize := SIZEOF({array}), TableType := {table_type}, \
         NoOfRows := {rows}, NoOfColumns := {columns} *)"
    );
    let _ = writeln!(
        text,
        "VAR\n    {array} : {kind} := [\n{}\n    ];\nEND_VAR",
        lines.join(",\n")
    );
    text
}

fn value(field: Field, row: usize, point: &WrittenPoint) -> String {
    match field {
        Field::Index => point.index.unwrap_or(row as u32 + 1).to_string(),
        // The last point has no law, and the structure has a field for it.
        Field::Law => point.law.unwrap_or(MotionLaw::Polynom1).name().to_owned(),
        Field::Type => type_name(point.point_type.unwrap_or_default()),
        Field::RelativeNext => point.relative_next.to_string(),
        Field::Master => number(point.master),
        Field::Slave => number(point.slave),
        Field::Velocity => number(point.velocity),
        Field::Acceleration => number(point.acceleration),
        Field::Jerk => number(point.jerk),
    }
}

/// Formats a literal of LREAL: with a decimal point and a digit behind it, also before an exponent, since REAL literals
/// of IEC 61131-3 have both.
fn number(value: f64) -> String {
    let shortest = format!("{value:?}");
    // Rust writes 1e16, IEC 61131-3 1.0e16.
    match shortest.split_once('e') {
        Some((digits, exponent)) if !digits.contains('.') => format!("{digits}.0e{exponent}"),
        _ => shortest,
    }
}
