//! Two-column tables of numbers as other programs export them.

use std::path::Path;

use crate::config::{ConfigError, Wrong};
use crate::text_file;

/// Greatest size of a CSV file, bytes.
// As for the points of a cam: docs/LIMITS.md.
const MOST_BYTES: u64 = 64 << 20;
/// Greatest number of its rows.
const MOST_ROWS: usize = 1_000_000;

/// Origin of the rows of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The CSV file.
    pub file: String,
    /// The line of each row, from 1.
    pub lines: Vec<usize>,
}

/// The rows of a table, and their origin.
pub type Rows = (Vec<(f64, f64)>, Source);

/// Reads rows of two numbers; errors use the names in `columns`.
///
/// Columns are separated by `;`, tabs, `,` or spaces, whichever of these the first line has first.
/// If the separator is not `,`, a decimal comma is accepted. Empty lines and lines that begin with
/// `#` are skipped, and so is a first line without any number: a header.
///
/// # Errors
/// A file that cannot be read, the line that is not a row, or too many rows.
pub fn read(path: &Path, columns: [&str; 2]) -> Result<Rows, ConfigError> {
    let text = text_file::read_table(path, MOST_BYTES)?;
    parse(path.display().to_string(), &text, columns)
}

/// Reads rows of two numbers from the text of this file, as [`read`] does.
///
/// # Errors
/// The line that is not a row, or too many rows.
pub fn parse(file: String, text: &str, columns: [&str; 2]) -> Result<Rows, ConfigError> {
    let text = text.trim_start_matches('\u{feff}');
    let mut filled = text
        .lines()
        .zip(1..)
        .map(|(line, number)| (line.trim(), number))
        .filter(|(line, _)| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    let separator = Separator::of(filled.peek().map_or("", |(line, _)| line));
    // At most one: a second line without a number is a mistake.
    filled.next_if(|(line, _)| separator.is_header(line));

    let mut rows = Vec::new();
    let mut lines = Vec::new();
    for (line, number) in filled {
        if rows.len() == MOST_ROWS {
            let received = format!("more than {MOST_ROWS} rows");
            return Err(Wrong::value(received, "at most that many").in_file(&file));
        }
        let row = separator.row(line, number, columns);
        rows.push(row.map_err(|wrong| wrong.in_file(&file))?);
        lines.push(number);
    }
    Ok((rows, Source { file, lines }))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Character(char),
    Spaces,
}

impl Separator {
    fn of(line: &str) -> Self {
        // The comma last: with another separator it is a decimal comma.
        [';', '\t', ',']
            .into_iter()
            .find(|separator| line.contains(*separator))
            .map_or(Self::Spaces, Self::Character)
    }

    fn is_header(self, line: &str) -> bool {
        self.cells(line)
            .iter()
            // A row with one number has a mistake, a header has none.
            .all(|cell| self.number(cell).is_none())
    }

    fn row(self, line: &str, number: usize, columns: [&str; 2]) -> Result<(f64, f64), Wrong> {
        let cells = self.cells(line);
        let [first, second] = columns;
        let [left, right] = cells[..] else {
            let received = format!("{} columns", cells.len());
            let expected = format!("2: {first} and {second}");
            return Err(Wrong::of(format!("line {number}"), received, expected));
        };
        let value = |column: &str, cell: &str| {
            let wrong = || Wrong::value(format_args!("{cell:?}"), "a number");
            let place = format!("line {number}, {column}");
            self.number(cell).ok_or_else(|| wrong().within(place))
        };
        Ok((value(first, left)?, value(second, right)?))
    }

    fn cells(self, line: &str) -> Vec<&str> {
        match self {
            Self::Character(separator) => line.split(separator).map(str::trim).collect(),
            Self::Spaces => line.split_whitespace().collect(),
        }
    }

    fn number(self, cell: &str) -> Option<f64> {
        // A cell with a point has no decimal comma.
        if self != Self::Character(',') && !cell.contains('.') {
            return cell.replacen(',', ".", 1).parse().ok();
        }
        cell.parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: [&str; 2] = ["master", "slave"];

    fn rows(text: &str) -> Result<Vec<(f64, f64)>, String> {
        parse("t.csv".to_owned(), text, COLUMNS)
            .map(|(rows, _)| rows)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn tables_of_all_countries_are_understood() {
        // Written with commas, semicolons, tabs and blanks, and with both decimal marks.
        let expected = Ok(vec![(0.0, 0.5), (90.0, -1.25e3)]);
        for text in [
            "0,0.5\n90,-1250\n",
            "master,slave\n0, 0.5\n90, -1.25e3",
            "\u{feff}Master;Slave\r\n0;0,5\r\n90;-1250\r\n",
            "0;0.5\n90;-1250.0",
            "# exported\n\nx\ty\n0\t0,5\n\n90,0\t-1250\n",
            "0 0.5\n90   -1250",
        ] {
            assert_eq!(rows(text), expected, "{text}");
        }
        assert_eq!(rows(""), Ok(vec![]));
    }

    #[test]
    fn rows_know_their_lines() {
        let (_, source) = parse("t.csv".to_owned(), "# two\nm;s\n0;0\n\n1;1\n", COLUMNS).unwrap();
        // The comment, the header and the empty line count.
        assert_eq!(source.lines, [3, 5]);
    }

    #[test]
    fn what_is_no_row_is_named_by_its_line() {
        for (text, expected) in [
            (
                "m;s\n0;0\n1;high\n",
                "t.csv: line 3, slave: received \"high\", expected a number",
            ),
            (
                "0;0\n;1\n",
                "t.csv: line 2, master: received \"\", expected a number",
            ),
            (
                "0,5,1,5\n",
                "t.csv: line 1: received 4 columns, expected 2: master and slave",
            ),
            (
                "0\n1\n",
                "t.csv: line 1: received 1 columns, expected 2: master and slave",
            ),
            (
                "0;0\n1,000.5;2\n",
                "t.csv: line 2, master: received \"1,000.5\", expected a number",
            ),
        ] {
            assert_eq!(rows(text), Err(expected.to_owned()));
        }
    }
}
