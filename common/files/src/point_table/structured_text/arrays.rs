//! Arrays while they are being read.

use std::collections::BTreeMap;

use coaxle_node::config::{ConfigError, Wrong};
use coaxle_plate::WrittenPoint;

use crate::point_table::field::{Field, Value, default_point};
use crate::point_table::{MOST_ROWS, PointTable};

/// Arrays that can hold a plate, by their names, which are case-insensitive.
#[derive(Default)]
pub(super) struct Arrays<'a> {
    named: BTreeMap<String, (&'a str, Array)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Points,
    Positions,
}

/// An element of an initial value.
pub(super) enum Element {
    /// A position, or a repeat count for the next element.
    Number(f64),
    Point(Box<WrittenPoint>),
}

/// The elements of an array, by their indices.
pub(super) struct Array {
    kind: Kind,
    /// The lower bounds of its dimensions.
    first: [i64; 2],
    /// Line of its first occurrence.
    line: usize,
    /// Count of numbers read from an initial value.
    numbers: usize,
    points: BTreeMap<i64, WrittenPoint>,
    rows: BTreeMap<i64, [Option<f64>; 2]>,
}

impl<'a> Arrays<'a> {
    /// A declared array; a repeated declaration replaces the earlier one.
    pub(super) fn declared(
        &mut self,
        name: &'a str,
        kind: Kind,
        first: [i64; 2],
        line: usize,
    ) -> &mut Array {
        let key = name.to_lowercase();
        // Initial values of the earlier declaration must not stay.
        self.named.remove(&key);
        let array = || (name, Array::new(kind, first, line));
        &mut self.named.entry(key).or_insert_with(array).1
    }

    /// The array of that name; without a declaration its kind follows from the assignment.
    pub(super) fn assigned(&mut self, name: &'a str, kind: Kind, line: usize) -> &mut Array {
        let known = self.named.get(&name.to_lowercase());
        // An array of another kind is another one of that name.
        if known.is_none_or(|(_, array)| array.kind != kind) {
            // Undeclared arrays count from 0.
            return self.declared(name, kind, [0, 0], line);
        }
        let known = self.named.entry(name.to_lowercase());
        &mut known
            .or_insert_with(|| (name, Array::new(kind, [0, 0], line)))
            .1
    }

    /// Names of the arrays that are not empty.
    pub(super) fn names(&self) -> impl Iterator<Item = &'a str> {
        let filled = self.named.values().filter(|(_, array)| !array.is_empty());
        filled.map(|(name, _)| *name)
    }

    pub(super) fn take(&mut self, name: &str) -> Option<Array> {
        let (_, array) = self.named.remove(&name.to_lowercase())?;
        // A declaration without values is no plate.
        (!array.is_empty()).then_some(array)
    }

    pub(super) fn take_first(&mut self) -> Option<Array> {
        let name = self.names().next()?;
        self.take(name)
    }
}

impl Array {
    const fn new(kind: Kind, first: [i64; 2], line: usize) -> Self {
        Self {
            kind,
            first,
            line,
            numbers: 0,
            points: BTreeMap::new(),
            rows: BTreeMap::new(),
        }
    }

    fn is_empty(&self) -> bool {
        self.points.is_empty() && self.rows.is_empty()
    }

    /// Appends an element of an initial value this number of times.
    pub(super) fn push(&mut self, times: f64, element: Element) -> Result<(), Wrong> {
        // Two numbers for each row: a point counts as two.
        let room = (2 * MOST_ROWS).saturating_sub(self.numbers + 2 * self.points.len());
        // Before the loop: `1000000000(0.0)` would fill the memory. A fraction or `NaN` is no count.
        if !(0.0..=room as f64).contains(&times) || times.fract() != 0.0 {
            let received = format!("{times} elements");
            let expected = format!("at most {MOST_ROWS} rows");
            return Err(Wrong::value(received, expected));
        }
        for _ in 0..times as usize {
            match (&element, self.kind) {
                (Element::Point(point), Kind::Points) => {
                    // Initial values begin at the lower bound, whatever it is.
                    let index = self.first[0] + self.points.len() as i64;
                    self.points.insert(index, (**point).clone());
                }
                (Element::Number(number), Kind::Positions) => {
                    let row = self.first[0] + (self.numbers / 2) as i64;
                    // Master and slave alternate: the rows of the array lie one behind the other.
                    self.rows.entry(row).or_default()[self.numbers % 2] = Some(*number);
                    self.numbers += 1;
                }
                (Element::Number(number), Kind::Points) => {
                    return Err(Wrong::value(number, "a point in brackets"));
                }
                (Element::Point(_), Kind::Positions) => {
                    return Err(Wrong::value("a structure", "a number"));
                }
            }
        }
        Ok(())
    }

    pub(super) fn assign_position(
        &mut self,
        row: i64,
        column: i64,
        number: f64,
    ) -> Result<(), Wrong> {
        // A column below the first becomes negative, and is refused by the conversion.
        let place = usize::try_from(column - self.first[1])
            .ok()
            .filter(|place| *place < 2);
        let place = place.ok_or_else(|| {
            let first = self.first[1];
            let expected = format!("{first} or {}", first + 1);
            Wrong::value(format_args!("column {column}"), expected)
        })?;
        check_room(&self.rows, row)?;
        self.rows.entry(row).or_default()[place] = Some(number);
        Ok(())
    }

    pub(super) fn assign_field(
        &mut self,
        row: i64,
        field: Field,
        value: Value<'_>,
    ) -> Result<(), Wrong> {
        check_room(&self.points, row)?;
        field.set(self.points.entry(row).or_insert_with(default_point), value)
    }

    /// The table of this array, without a gap.
    pub(super) fn table(self, file: &str) -> Result<PointTable, ConfigError> {
        let line = self.line;
        let missing = |index: i64, what: &str| {
            let field = format!("array of line {line}: element {index}");
            Wrong::of(field, format_args!("no {what}"), "one").in_file(file)
        };
        let indices: Vec<i64> = match self.kind {
            Kind::Points => self.points.keys().copied().collect(),
            Kind::Positions => self.rows.keys().copied().collect(),
        };
        // Sorted by the map: a difference other than 1 is a gap.
        if let Some(pair) = indices.windows(2).find(|pair| pair[1] != pair[0] + 1) {
            return Err(missing(pair[0] + 1, "value"));
        }
        match self.kind {
            Kind::Points => {
                for (index, point) in &self.points {
                    for (value, name) in [(point.master, "MasterPos"), (point.slave, "SlavePos")] {
                        // A point in a program may be filled by several assignments: only now all are read.
                        if value.is_nan() {
                            return Err(missing(*index, name));
                        }
                    }
                }
                Ok(PointTable::Points(self.points.into_values().collect()))
            }
            Kind::Positions => {
                let rows = self.rows.into_iter().map(|(index, row)| match row {
                    [Some(master), Some(slave)] => Ok((master, slave)),
                    [None, _] => Err(missing(index, "master position")),
                    [_, None] => Err(missing(index, "slave position")),
                });
                rows.collect::<Result<_, _>>().map(PointTable::Positions)
            }
        }
    }
}

/// Checks that an assignment to this row exceeds the bound of the rows by none: one that is there takes no room.
fn check_room<T>(rows: &BTreeMap<i64, T>, row: i64) -> Result<(), Wrong> {
    if rows.len() < MOST_ROWS || rows.contains_key(&row) {
        return Ok(());
    }
    Err(Wrong::value(
        format_args!("more than {MOST_ROWS} rows"),
        "at most that many",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Assigns both columns of this number of rows, or two fields of this number of points.
    fn assigned(kind: Kind, rows: usize) -> Result<Array, Wrong> {
        let mut array = Array::new(kind, [0, 0], 1);
        for row in 0..rows as i64 {
            for column in 0..2 {
                match (kind, column) {
                    (Kind::Positions, _) => array.assign_position(row, column, 1.0)?,
                    (Kind::Points, 0) => {
                        array.assign_field(row, Field::Master, Value::Number(1.0))?;
                    }
                    (Kind::Points, _) => {
                        array.assign_field(row, Field::Slave, Value::Number(1.0))?;
                    }
                }
            }
        }
        Ok(array)
    }

    #[test]
    fn the_last_row_of_the_longest_array_is_assigned_whole() {
        for kind in [Kind::Positions, Kind::Points] {
            let array = assigned(kind, MOST_ROWS).unwrap();
            assert!(array.table("t.st").is_ok());
            let Err(wrong) = assigned(kind, MOST_ROWS + 1) else {
                panic!("one row more than there may be");
            };
            let reason = wrong.to_string();
            assert!(
                reason.starts_with("received more than 1000000 rows"),
                "{reason}"
            );
        }
    }
}
