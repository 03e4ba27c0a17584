//! A record as a line of text on pipes: the cycle index, then position, velocity and acceleration of each
//! axis, separated by commas, or by blanks as LinuxCNC's `halsampler` prints them.

use std::fmt::Write as _;

use coaxle_axis::{NcToPlcAxis, StateWord};
use coaxle_clock::CycleIndex;

use crate::port::PlcOutput;

/// Fields of one axis.
const FIELDS: [&str; 3] = ["position", "velocity", "acceleration"];

/// Returns the head line of records of axes of these names:
/// `index,conveyor.position,conveyor.velocity,…`.
#[must_use]
pub fn head_line<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut line = "index".to_owned();
    for name in names {
        for field in FIELDS {
            line.extend([",", name, ".", field]);
        }
    }
    line
}

/// Reads the index and the axes of a line. A count that goes on beyond 65535 is an index, too. Such an axis counts as
/// operational and homed; its other state is unknown.
///
/// # Errors
/// [`RecordLineError`] with the field.
pub fn read_line(line: &str, axes: &mut [NcToPlcAxis]) -> Result<CycleIndex, RecordLineError> {
    let received = cells(line).count();
    let expected = 1 + FIELDS.len() * axes.len();
    if received != expected {
        return Err(RecordLineError::Fields { received, expected });
    }
    let mut cells = cells(line);
    let cell = cells.next().unwrap_or_default();
    let count = cell.parse().map_err(|_| RecordLineError::Index {
        received: shortened(cell),
    })?;
    for (number, axis) in axes.iter_mut().enumerate() {
        let mut values = [0.0; FIELDS.len()];
        for (value, field) in values.iter_mut().zip(FIELDS) {
            let cell = cells.next().unwrap_or_default();
            // `inf` and `nan` are numbers for `parse`, and would spread to all receivers.
            let number_of_cell = cell.parse().ok().filter(|number: &f64| number.is_finite());
            *value = number_of_cell.ok_or_else(|| RecordLineError::Number {
                axis: number,
                field,
                received: shortened(cell),
            })?;
        }
        *axis = moving(values);
    }
    Ok(CycleIndex::of_count(count))
}

/// Returns the fields of a line. Without a comma, blanks separate them; blanks behind commas are usual in CSV written by people.
fn cells(line: &str) -> impl Iterator<Item = &str> {
    let has_commas = line.contains(',');
    let separates = move |char: char| match has_commas {
        true => char == ',',
        false => char.is_whitespace(),
    };
    let cells = line.split(separates).map(str::trim);
    cells.filter(move |cell| has_commas || !cell.is_empty())
}

/// Appends the line of a record, with its end. Missing axes are empty fields.
pub fn write_line(output: &PlcOutput<'_>, out: &mut String) {
    // Writing to a string cannot fail.
    let _ = write!(out, "{}", output.index.0);
    for axis in output.axes {
        let _ = match axis {
            Some(axis) => write!(
                out,
                ",{},{},{}",
                axis.set_position, axis.set_velocity, axis.set_acceleration
            ),
            // Empty fields keep the columns of the axes behind it in place.
            None => write!(out, ",,,"),
        };
    }
    out.push('\n');
}

fn moving([position, velocity, acceleration]: [f64; 3]) -> NcToPlcAxis {
    NcToPlcAxis {
        // A line has no state word: without these bits the axis would be neither operational nor homed.
        state_word: StateWord::OPERATIONAL | StateWord::HOMED,
        actual_position: position,
        actual_velocity: velocity,
        set_position: position,
        set_velocity: velocity,
        set_acceleration: acceleration,
        ..NcToPlcAxis::default()
    }
}

/// Shortens a field for a message.
fn shortened(cell: &str) -> String {
    // A field may be as long as the line.
    cell.chars().take(32).collect()
}

/// Error of a line that is not a record.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordLineError {
    /// Too few or too many fields.
    #[error(
        "{received} fields came, expected {expected}: the cycle index, and position, velocity and acceleration of each axis"
    )]
    Fields {
        /// Number of fields received.
        received: usize,
        /// Number of fields expected.
        expected: usize,
    },
    /// A first field that is not an index.
    #[error("index: received {received:?}, expected the cycle index, a whole number of at least 0")]
    Index {
        /// Text received.
        received: String,
    },
    /// Another field that is not a number.
    #[error("axis[{axis}].{field}: received {received:?}, expected a finite number")]
    Number {
        /// Number of the axis, from 0.
        axis: usize,
        /// Name of its field.
        field: &'static str,
        /// Text received.
        received: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_written_can_be_read() {
        let mut axes = [NcToPlcAxis::default(); 2];
        let index = read_line("65535, 1.5,-2,3e-3,0,0,0", &mut axes);
        assert_eq!(index, Ok(CycleIndex(65_535)));
        let first = (axes[0].set_position, axes[0].set_velocity);
        assert_eq!((first, axes[0].set_acceleration), ((1.5, -2.0), 0.003));
        let mut line = String::new();
        let output = PlcOutput {
            number: 0,
            index: CycleIndex(65_535),
            axes: &[Some(axes[0]), None],
        };
        write_line(&output, &mut line);
        assert_eq!(line, "65535,1.5,-2,0.003,,,\n");
        assert_eq!(
            head_line(["a", "b"].into_iter()),
            "index,a.position,a.velocity,a.acceleration,b.position,b.velocity,b.acceleration"
        );
    }

    #[test]
    fn a_line_of_halsampler_is_one_too() {
        let mut axes = [NcToPlcAxis::default(); 1];
        for (line, index) in [("7 1.5 -2 0.003 ", 7), ("65543  1.5 -2\t0.003", 7)] {
            assert_eq!(read_line(line, &mut axes), Ok(CycleIndex(index)));
            assert_eq!((axes[0].set_position, axes[0].set_velocity), (1.5, -2.0));
        }
        let lost = read_line("overrun", &mut axes).unwrap_err();
        assert_eq!(
            lost,
            RecordLineError::Fields {
                received: 1,
                expected: 4
            }
        );
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (line, expected) in [
            ("", "0 fields came, expected 4"),
            ("1,", "2 fields came, expected 4"),
            ("1,2,3,4,5", "5 fields came, expected 4"),
            (
                "-1,1,2,3",
                "index: received \"-1\", expected the cycle index, a whole number of at least 0",
            ),
            (
                "1,2,nan,3",
                "axis[0].velocity: received \"nan\", expected a finite number",
            ),
            ("1,2,3,", "axis[0].acceleration: received \"\""),
        ] {
            let mut axes = [NcToPlcAxis::default(); 1];
            let error = read_line(line, &mut axes).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{line}: {error}");
        }
    }
}
