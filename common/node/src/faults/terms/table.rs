//! A term from a file.

use std::path::Path;

use crate::config::{Between, ConfigError, FaultSeconds, Wrong};
use crate::two_columns;

/// A function of time through the rows of a table. Its first value holds before them, its last one after.
#[derive(Clone, Debug)]
pub(super) struct Table {
    rows: Vec<Row>,
    between: Between,
}

#[derive(Clone, Copy, Debug)]
struct Row {
    at: f64,
    value: f64,
    /// The integral from the first row on.
    integral: f64,
}

/// Names of the columns in errors.
const COLUMNS: [&str; 2] = ["s", "value"];

impl Table {
    /// Reads a CSV file of seconds since the start and values, each of which has to be a valid `V`.
    pub(super) fn read<V>(path: &Path, between: Between) -> Result<Self, ConfigError>
    where
        V: TryFrom<f64, Error = Wrong>,
    {
        let (rows, source) = two_columns::read(path, COLUMNS)?;
        let file = source.file.as_str();
        if rows.is_empty() {
            let wrong = Wrong::value("no rows", "at least 1: seconds and value");
            return Err(wrong.in_file(file));
        }
        let mut table = Self {
            rows: Vec::with_capacity(rows.len()),
            between,
        };
        for ((at, value), line) in rows.into_iter().zip(&source.lines) {
            let in_column = |column: usize| {
                let place = format!("line {line}, {}", COLUMNS[column]);
                move |wrong: Wrong| wrong.within(place).in_file(file)
            };
            // As the limits of a term in the config: a table must not exceed them either.
            FaultSeconds::new(at).map_err(in_column(0))?;
            V::try_from(value).map_err(in_column(1))?;
            if let Some(last) = table.rows.last()
                // Equal times have no slope.
                && at <= last.at
            {
                let expected = format!("more than {}, the row before", last.at);
                return Err(in_column(0)(Wrong::value(at, expected)));
            }
            table.push(at, value);
        }
        Ok(table)
    }

    fn push(&mut self, at: f64, value: f64) {
        let integral = match self.rows.last() {
            None => 0.0,
            // Summed once: a mean over any time costs two searches.
            Some(last) => last.integral + area(last, self.slope(last, at, value), at - last.at),
        };
        self.rows.push(Row {
            at,
            value,
            integral,
        });
    }

    fn slope(&self, row: &Row, next_at: f64, next_value: f64) -> f64 {
        match self.between {
            Between::Linear => (next_value - row.value) / (next_at - row.at),
            Between::Held => 0.0,
        }
    }

    /// The row that applies at `at`, and the slope from there on.
    fn row_at(&self, at: f64) -> (&Row, f64) {
        // The row that has begun by now: a step happens at its own time.
        let begun = self.rows.partition_point(|row| row.at <= at);
        // Before the first row its value holds.
        let row = &self.rows[begun.saturating_sub(1)];
        let slope = match self.rows.get(begun) {
            Some(next) if begun > 0 => self.slope(row, next.at, next.value),
            _ => 0.0,
        };
        (row, slope)
    }

    /// The value at `at` s.
    pub(super) fn at(&self, at: f64) -> f64 {
        let (row, slope) = self.row_at(at);
        row.value + slope * (at - row.at)
    }

    /// The integral up to `at` s, from the first row on.
    pub(super) fn integral(&self, at: f64) -> f64 {
        let (row, slope) = self.row_at(at);
        row.integral + area(row, slope, at - row.at)
    }
}

/// Integral of a straight line from a row on.
fn area(row: &Row, slope: f64, passed: f64) -> f64 {
    // v·t + ½·m·t².
    passed * (row.value + 0.5 * slope * passed)
}
