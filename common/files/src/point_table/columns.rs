//! A header with the names of fields.

use coaxle_node::config::Wrong;

use super::field::Field;

/// The field of each column, and the separator.
pub(super) struct Columns {
    pub(super) fields: Vec<Field>,
    separator: char,
}

impl Columns {
    /// Reads a header that names a law; none for a table of two columns of numbers.
    ///
    /// # Errors
    /// [`Wrong`] if a column is unknown or duplicate, or master or slave is missing.
    pub(super) fn of(header: &str) -> Option<Result<Self, Wrong>> {
        // The comma last: with another separator it is a decimal comma.
        let separators = [';', '\t', ','];
        let separator = separators.into_iter().find(|c| header.contains(*c))?;
        let names: Vec<_> = cells(header, separator).collect();
        // A law makes the difference between points and positions: both have master and slave.
        let has_law = names
            .iter()
            .any(|name| Field::called(name) == Some(Field::Law));
        has_law.then(|| {
            let fields = fields(&names)?;
            Ok(Self { fields, separator })
        })
    }

    pub(super) fn cells<'a>(&self, line: &'a str) -> impl Iterator<Item = &'a str> {
        cells(line, self.separator)
    }

    /// Parses a number; a decimal comma is accepted unless the comma is the separator.
    pub(super) fn number(&self, cell: &str) -> Option<f64> {
        // A cell with a point has no decimal comma: 1,234.5 is refused, not read as 1.2345.
        if self.separator != ',' && !cell.contains('.') {
            return cell.replacen(',', ".", 1).parse().ok();
        }
        cell.parse().ok()
    }
}

fn cells(line: &str, separator: char) -> impl Iterator<Item = &str> {
    line.split(separator).map(str::trim)
}

fn fields(names: &[&str]) -> Result<Vec<Field>, Wrong> {
    let mut fields = Vec::new();
    for name in names {
        // The names of the PLC are accepted, and those of cam files are listed.
        let field = Field::called(name).ok_or_else(|| {
            let expected = format!("some of {}", Field::ALL.map(Field::name).join(", "));
            Wrong::value(format_args!("column {name:?}"), expected)
        })?;
        if fields.contains(&field) {
            let received = format!("column {} twice", field.name());
            return Err(Wrong::value(received, "it once"));
        }
        fields.push(field);
    }
    // All other fields have a default.
    for needed in [Field::Master, Field::Slave] {
        if !fields.contains(&needed) {
            let received = format!("no column {}", needed.name());
            return Err(Wrong::value(received, "one"));
        }
    }
    Ok(fields)
}
