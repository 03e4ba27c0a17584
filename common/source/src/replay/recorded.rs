//! Reading the motion of an axis out of a recording in MCAP.

use std::collections::BTreeSet;
use std::io::{BufReader, Read};
use std::path::Path;

use coaxle_node::{one_line, text_file};
use coaxle_recording::{Item, ReadTable, Reader, Row as Recorded, Value};

use super::table::{MOST, MOST_ROWS, MotionRow, RecordedMotion, ReplayError, differentiate};

/// Names of the signals of a motion: of an axis or a slave, and of a far axis.
const POSITION: [&str; 2] = ["position", "corrected_position"];
const VELOCITY: [&str; 2] = ["velocity", "corrected_velocity"];
const ACCELERATION: [&str; 1] = ["acceleration"];

/// True if a file is a recording, by its name.
pub(super) fn is_recording(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "mcap")
}

/// Reads the motion of an axis, from the first cycle in which its position is known. Cycles without a
/// position are left out.
pub(super) fn read(path: &Path, axis: &str) -> Result<RecordedMotion, ReplayError> {
    // The file is not kept: it may be of any length, only rows of the axis are.
    let file = text_file::open(path, u64::MAX)?;
    let name = path.display().to_string();
    let mut reader = RecordedAxisReader {
        axis,
        file: &name,
        places: None,
        start_ns: None,
        rows: Vec::new(),
        velocity_recorded: true,
    };
    reader.all_of(Reader::new(BufReader::new(file)))
}

/// An axis while it is read from a recording.
struct RecordedAxisReader<'a> {
    axis: &'a str,
    file: &'a str,
    places: Option<Places>,
    /// The cycle of the first row.
    start_ns: Option<i64>,
    rows: Vec<MotionRow>,
    velocity_recorded: bool,
}

/// Columns of the values of an axis in a row.
struct Places {
    table: usize,
    position: usize,
    velocity: Option<usize>,
    acceleration: Option<usize>,
}

impl RecordedAxisReader<'_> {
    fn all_of<R: Read>(&mut self, mut reader: Reader<R>) -> Result<RecordedMotion, ReplayError> {
        while let Some(item) = reader.next() {
            // A motion with a gap in it would be interpolated across it: damage is refused instead of skipped.
            let item = item.map_err(|damage| ReplayError::Recording {
                file: self.file.to_owned(),
                damage: Box::new(damage),
            })?;
            if let Item::Row(row) = item {
                self.take(reader.tables(), &row)?;
            }
        }
        if self.places.is_none() {
            return Err(self.no_axis(reader.tables()));
        }
        let mut rows = std::mem::take(&mut self.rows);
        if rows.len() < 2 {
            return Err(ReplayError::TooShort {
                file: self.file.to_owned(),
                received: rows.len(),
            });
        }
        if !self.velocity_recorded {
            differentiate(&mut rows);
        }
        Ok(RecordedMotion {
            rows,
            velocity_recorded: self.velocity_recorded,
        })
    }

    fn take(&mut self, tables: &[ReadTable], row: &Recorded) -> Result<(), ReplayError> {
        if self.places.is_none() {
            // Looked up with each row until found: tables appear while the file is read.
            self.places = places(tables, row.table, self.axis);
        }
        let Some(places) = self.places.as_ref().filter(|of| of.table == row.table) else {
            return Ok(());
        };
        let value = |place: usize| row.values[place].as_ref().and_then(Value::as_number);
        let Some(position) = value(places.position) else {
            return Ok(());
        };
        let start_ns = *self.start_ns.get_or_insert(row.at_ns);
        let velocity = places.velocity.and_then(value);
        let acceleration = places.acceleration.and_then(value);
        // Subtracted as integers: in f64 a time of day in ns is exact to 256 ns only.
        let time = row.at_ns.saturating_sub(start_ns) as f64 * 1e-9;
        for number in [Some(position), velocity, acceleration]
            .into_iter()
            .flatten()
        {
            if !number.is_finite() || number.abs() > MOST {
                return Err(self.wrong(row, number, format!("numbers from -{MOST:e} to {MOST:e}")));
            }
        }
        // Later by a nanosecond at least, as integers: no check of the shortest step is needed here.
        if let Some(before) = self.rows.last()
            && time <= before.time
        {
            let expected = format!("more than {} s, the time before", before.time);
            return Err(self.wrong(row, time, expected));
        }
        if self.rows.len() == MOST_ROWS {
            let file = self.file.to_owned();
            return Err(ReplayError::TooLong { file });
        }
        // A single missing one makes the column useless: mixed ones would contradict each other.
        self.velocity_recorded &= velocity.is_some();
        self.rows.push(MotionRow {
            time,
            position,
            velocity: velocity.unwrap_or(0.0),
            acceleration,
        });
        Ok(())
    }

    fn wrong(&self, row: &Recorded, received: f64, expected: String) -> ReplayError {
        ReplayError::Cycle {
            file: self.file.to_owned(),
            axis: one_line(self.axis),
            at_ns: row.at_ns,
            received,
            expected,
        }
    }

    fn no_axis(&self, tables: &[ReadTable]) -> ReplayError {
        let named = |table: &ReadTable| {
            let columns = table.columns.iter();
            let moved = columns.filter(|column| POSITION.contains(&column.signal.as_str()));
            let names = moved.map(|column| match tables.len() {
                1 => format!("{:?}", column.instance),
                _ => format!("\"{}/{}\"", table.name, column.instance),
            });
            names.collect::<BTreeSet<_>>()
        };
        let there: Vec<String> = tables.iter().flat_map(named).collect();
        ReplayError::Axis {
            file: self.file.to_owned(),
            received: format!("{:?}", one_line(self.axis)),
            expected: match there.as_slice() {
                [] => "a recording with an axis in it".to_owned(),
                there => one_line(&format!("one of {}", there.join(", "))),
            },
        }
    }
}

/// Returns the columns of the axis in rows of this table, if it is there: by its name, or by that of the
/// table and its own.
fn places(tables: &[ReadTable], table: usize, axis: &str) -> Option<Places> {
    let of = &tables[table];
    let own = axis
        .strip_prefix(&of.name)
        .and_then(|rest| rest.strip_prefix('/'));
    let place = |signals: &[&str]| {
        let mut columns = of.columns.iter();
        columns.position(|column| {
            (column.instance == axis || Some(column.instance.as_str()) == own)
                && signals.contains(&column.signal.as_str())
        })
    };
    Some(Places {
        table,
        position: place(&POSITION)?,
        velocity: place(&VELOCITY),
        acceleration: place(&ACCELERATION),
    })
}
