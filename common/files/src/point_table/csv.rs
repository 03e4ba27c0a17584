//! Points and positions as CSV.

use std::fmt::Write as _;

use coaxle_node::config::{ConfigError, Wrong};
use coaxle_node::two_columns;
use coaxle_plate::WrittenPoint;

use super::columns::Columns;
use super::field::{Field, Value, default_point};
use super::{MOST_ROWS, PointTable, too_many};

pub(super) fn read(file: &str, text: &str) -> Result<PointTable, ConfigError> {
    let mut lines = filled(text);
    let first = lines.next();
    let columns = first.and_then(|(number, header)| Some((number, Columns::of(header)?)));
    match columns {
        // Without a law these are positions, or no table: the reader of positions says which.
        None => {
            let (rows, _) = two_columns::parse(file.to_owned(), text, ["master", "slave"])?;
            Ok(PointTable::Positions(rows))
        }
        Some((number, columns)) => {
            let columns = columns.map_err(in_header(file, number))?;
            let (points, _) = points(file, &columns, lines)?;
            Ok(PointTable::Points(points))
        }
    }
}

/// Reads points only, and the line of each.
pub(super) fn read_points(file: &str, text: &str) -> Result<Points, ConfigError> {
    let mut lines = filled(text);
    let header = lines.next();
    let columns = header.and_then(|(number, header)| Some((number, Columns::of(header)?)));
    let Some((number, columns)) = columns else {
        let number = header.map_or(1, |(number, _)| number);
        let wrong = Wrong::value("no column law", "a header with law, master, slave and more");
        return Err(in_header(file, number)(wrong));
    };
    points(file, &columns.map_err(in_header(file, number))?, lines)
}

/// Adds the file and the line of its header to an error.
fn in_header(file: &str, number: usize) -> impl Fn(Wrong) -> ConfigError {
    move |wrong| wrong.within(format_args!("line {number}")).in_file(file)
}

/// Points, and the line of each.
type Points = (Vec<WrittenPoint>, Vec<usize>);

/// The lines with contents, with their numbers.
fn filled(text: &str) -> impl Iterator<Item = (usize, &str)> {
    // Tabs at the end of a line may separate cells that are empty.
    // Programs for spreadsheets write a mark of the byte order.
    let lines = text.trim_start_matches('\u{feff}').lines();
    let lines = lines.map(|line| line.trim_matches([' ', '\r']));
    let numbered = (1..).zip(lines);
    numbered.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

fn points<'a>(
    file: &str,
    columns: &Columns,
    lines: impl Iterator<Item = (usize, &'a str)>,
) -> Result<Points, ConfigError> {
    let (mut points, mut numbers) = (Vec::new(), Vec::new());
    for (number, line) in lines {
        // Before a row is read: a file of 64 MiB may have more than a million short lines.
        if points.len() == MOST_ROWS {
            return Err(too_many(file));
        }
        let point = point(columns, line, number).map_err(|wrong| wrong.in_file(file))?;
        points.push(point);
        numbers.push(number);
    }
    Ok((points, numbers))
}

fn point(columns: &Columns, line: &str, number: usize) -> Result<WrittenPoint, Wrong> {
    let cells: Vec<_> = columns.cells(line).collect();
    let (received, expected) = (cells.len(), columns.fields.len());
    // A missing cell would shift all cells behind it.
    if received != expected {
        let received = format!("{received} columns");
        let expected = format!("{expected}, as in the header");
        return Err(Wrong::of(format!("line {number}"), received, expected));
    }
    let mut point = default_point();
    for (field, cell) in columns.fields.iter().zip(cells) {
        // An empty cell means the default, except for the positions.
        // A position of its own is the point: a default would move it to 0.
        if cell.is_empty() && !matches!(field, Field::Master | Field::Slave) {
            continue;
        }
        let value = columns
            .number(cell)
            // Words are laws and types: the field decides if a word fits.
            .map_or(Value::Word(cell), Value::Number);
        let set = field.set(&mut point, value);
        set.map_err(|wrong| wrong.within(format_args!("line {number}, {}", field.name())))?;
    }
    Ok(point)
}

pub(super) fn write(table: &PointTable) -> String {
    let mut text = String::new();
    match table {
        PointTable::Positions(rows) => {
            text.push_str("master,slave\n");
            for (master, slave) in rows {
                // The shortest text that is read as the same number.
                let _ = writeln!(text, "{master},{slave}");
            }
        }
        PointTable::Points(points) => {
            text = Field::ALL.map(Field::name).join(",") + "\n";
            for (row, point) in points.iter().enumerate() {
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{},{},{},{}",
                    // Points are numbered from 1, as the NC does.
                    point.index.unwrap_or(row as u32 + 1),
                    point.law.map_or("", |law| law.file_name()),
                    point.point_type.map_or("", |kind| kind.file_name()),
                    point.relative_next,
                    point.master,
                    point.slave,
                    point.velocity,
                    point.acceleration,
                    point.jerk,
                );
            }
        }
    }
    text
}
