//! Reading a recorded motion.

use std::path::Path;

use coaxle_node::one_line;
use coaxle_node::text_file::{self, Unreadable};
use coaxle_recording::Damage;

/// Greatest length of a recording, bytes: an hour in cycles of a millisecond.
const MOST_BYTES: u64 = 128 << 20;
/// Greatest number of its rows.
pub(super) const MOST_ROWS: usize = 4_000_000;
/// The greatest number in it, and the least time between two rows, s: with these, all calculated values
/// are finite. A value that no axis can have is reported in the cycle in which it occurs.
pub(super) const MOST: f64 = 1e100;
const SHORTEST: f64 = 1e-9;

/// A recorded motion, its missing columns differentiated.
#[derive(Debug)]
pub(super) struct RecordedMotion {
    pub(super) rows: Vec<MotionRow>,
    pub(super) velocity_recorded: bool,
}

/// Row of a recording.
#[derive(Clone, Copy, Debug)]
pub(super) struct MotionRow {
    pub(super) time: f64,
    pub(super) position: f64,
    pub(super) velocity: f64,
    /// Acceleration; none if it was not recorded.
    pub(super) acceleration: Option<f64>,
}

/// Error of a file that cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file cannot be read.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// A line that is not CSV, or has too few or too many values.
    #[error("{file}: {reason}")]
    Syntax {
        /// The file.
        file: String,
        /// Line and reason.
        reason: csv::Error,
    },
    /// A header without the required columns.
    #[error(
        "{file}: line 1: received the columns {received}, expected `time_s`, `position` and at \
         most `velocity` and `acceleration`, each once"
    )]
    Columns {
        /// The file.
        file: String,
        /// The header.
        received: String,
    },
    /// An invalid value.
    #[error("{file}: line {line}: {column}: received {received:?}, expected {expected}")]
    Value {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The column's name.
        column: &'static str,
        /// Value received.
        received: String,
        /// Value expected.
        expected: String,
    },
    /// A recording in MCAP that is damaged, or was not finished.
    #[error("{file}: {damage}: `coaxle recover` keeps what is whole of it")]
    Recording {
        /// The file.
        file: String,
        /// Kind and place of the damage.
        damage: Box<Damage>,
    },
    /// A missing or unknown axis name for a recording in MCAP, or an axis name for a file with only one
    /// axis.
    #[error("{file}: axis: received {received}, expected {expected}")]
    Axis {
        /// The file.
        file: String,
        /// The name received.
        received: String,
        /// The names in the recording.
        expected: String,
    },
    /// An invalid value in a cycle of a recording in MCAP.
    #[error("{file}: {axis}: cycle at {at_ns} ns: received {received}, expected {expected}")]
    Cycle {
        /// The file.
        file: String,
        /// The axis.
        axis: String,
        /// The cycle, by the clock of the recording.
        at_ns: i64,
        /// Value received.
        received: f64,
        /// Value expected.
        expected: String,
    },
    /// A file with too few rows for a motion.
    #[error("{file}: received {received} rows, expected at least 2")]
    TooShort {
        /// The file.
        file: String,
        /// Number of rows.
        received: usize,
    },
    /// A file with more rows than a node keeps.
    #[error("{file}: received more than {MOST_ROWS} rows, expected at most that many")]
    TooLong {
        /// The file.
        file: String,
    },
}

/// Reads a recorded motion.
pub(super) fn read(path: &Path) -> Result<RecordedMotion, ReplayError> {
    let text = text_file::read_table(path, MOST_BYTES)?;
    let file = path.display().to_string();
    Text { file, text }.parse()
}

/// A file and its content.
struct Text {
    file: String,
    text: String,
}

impl Text {
    fn parse(&self) -> Result<RecordedMotion, ReplayError> {
        let mut csv = csv::ReaderBuilder::new()
            // Spreadsheets and people align columns by blanks.
            .trim(csv::Trim::All)
            .from_reader(self.text.as_bytes());
        let header = csv.headers().map_err(|reason| self.syntax(reason))?;
        let columns = ReplayColumns::find(self, header)?;

        let mut rows: Vec<MotionRow> = Vec::new();
        for record in csv.records() {
            let record = record.map_err(|reason| self.syntax(reason))?;
            let row = columns.row(self, &record)?;
            if let Some(before) = rows.last()
                && row.time <= before.time
            {
                let expected = format!("more than {}, the time before", before.time);
                return Err(self.value(&record, "time_s", columns.time, expected));
            }
            if let Some(before) = rows.last()
                // A slope over a shorter time could be infinite: 2e100 / 1e-9 and its next derivative stay far below
                // 1e308.
                && row.time - before.time < SHORTEST
            {
                let expected = format!(
                    "at least {SHORTEST} s after {}, the time before",
                    before.time
                );
                return Err(self.value(&record, "time_s", columns.time, expected));
            }
            if rows.len() == MOST_ROWS {
                let file = self.file.clone();
                return Err(ReplayError::TooLong { file });
            }
            rows.push(row);
        }
        if rows.len() < 2 {
            return Err(ReplayError::TooShort {
                file: self.file.clone(),
                received: rows.len(),
            });
        }
        let velocity_recorded = columns.velocity.is_some();
        if !velocity_recorded {
            differentiate(&mut rows);
        }
        Ok(RecordedMotion {
            rows,
            velocity_recorded,
        })
    }

    fn syntax(&self, reason: csv::Error) -> ReplayError {
        ReplayError::Syntax {
            file: self.file.clone(),
            reason,
        }
    }

    fn value(
        &self,
        record: &csv::StringRecord,
        column: &'static str,
        at: usize,
        expected: String,
    ) -> ReplayError {
        ReplayError::Value {
            file: self.file.clone(),
            line: self.line(record),
            column,
            received: one_line(&record[at]),
            expected,
        }
    }

    /// Returns the line of a record. Its own position is the end of the record before it, which is
    /// another line if there are blank ones.
    fn line(&self, record: &csv::StringRecord) -> usize {
        let ended = record
            .position()
            .map_or(0, |position| position.byte() as usize);
        let before = self.text.get(..ended).unwrap_or_default();
        let blank = self.text[before.len()..]
            .bytes()
            .take_while(|byte| matches!(byte, b'\r' | b'\n'));
        let is_newline = |byte: &u8| *byte == b'\n';
        1 + before.bytes().filter(is_newline).count() + blank.filter(is_newline).count()
    }
}

/// Index of each column.
struct ReplayColumns {
    time: usize,
    position: usize,
    velocity: Option<usize>,
    acceleration: Option<usize>,
}

impl ReplayColumns {
    fn find(text: &Text, header: &csv::StringRecord) -> Result<Self, ReplayError> {
        let find = |name: &str| header.iter().position(|column| column == name);
        let velocity = find("velocity");
        let acceleration = find("acceleration");
        let known = 2 + usize::from(velocity.is_some()) + usize::from(acceleration.is_some());
        match (find("time_s"), find("position")) {
            // By count, so that an unknown or a doubled column is refused as well.
            (Some(time), Some(position)) if header.len() == known => Ok(Self {
                time,
                position,
                velocity,
                acceleration,
            }),
            _ => Err(ReplayError::Columns {
                file: text.file.clone(),
                received: one_line(&listed(header)),
            }),
        }
    }

    fn row(&self, text: &Text, record: &csv::StringRecord) -> Result<MotionRow, ReplayError> {
        let number = |column: &'static str, at: usize| match record[at].parse::<f64>() {
            // NaN fails this comparison, and is no finite number below.
            Ok(number) if number.abs() <= MOST => Ok(number),
            Ok(number) if number.is_finite() => {
                let expected = format!("a number from -{MOST:e} to {MOST:e}");
                Err(text.value(record, column, at, expected))
            }
            _ => Err(text.value(record, column, at, "a finite number".to_owned())),
        };
        let optional =
            |column: &'static str, at: Option<usize>| at.map(|at| number(column, at)).transpose();
        Ok(MotionRow {
            time: number("time_s", self.time)?,
            position: number("position", self.position)?,
            velocity: optional("velocity", self.velocity)?.unwrap_or(0.0),
            acceleration: optional("acceleration", self.acceleration)?,
        })
    }
}

fn listed(header: &csv::StringRecord) -> String {
    let columns = header.iter().map(|column| format!("`{column}`"));
    columns.collect::<Vec<_>>().join(", ")
}

/// Sets each row's velocity to the slope there of the parabola through it and its neighbours.
pub(super) fn differentiate(rows: &mut [MotionRow]) {
    let slope =
        |from: &MotionRow, to: &MotionRow| (to.position - from.position) / (to.time - from.time);
    let last = rows.len() - 1;
    // Two rows have no parabola.
    if last == 1 {
        let velocity = slope(&rows[0], &rows[1]);
        rows[0].velocity = velocity;
        rows[1].velocity = velocity;
        return;
    }
    for k in 0..=last {
        // The ends lie on the parabola of their neighbour.
        let middle = k.clamp(1, last - 1);
        let (a, b, c) = (&rows[middle - 1], &rows[middle], &rows[middle + 1]);
        let (left, right) = (slope(a, b), slope(b, c));
        let curvature = (right - left) / (c.time - a.time);
        // Newton's form: p' = f[a,b] + f[a,b,c]·((t - a) + (t - b)).
        rows[k].velocity = left + curvature * (2.0 * rows[k].time - a.time - b.time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        std::fs::write(&path, text).unwrap();
        let message = read(&path).unwrap_err().to_string();
        let file = path.display().to_string();
        message
            .strip_prefix(&file)
            .expect("every error begins with the file")
            .to_owned()
    }

    #[test]
    fn a_bad_file_is_refused_with_place_value_and_expectation() {
        for (text, expected) in [
            (
                "time_s,position\n0,1\n1,abc\n",
                ": line 3: position: received \"abc\", expected a finite number",
            ),
            (
                "time_s,position\n0,1\n1,inf\n",
                ": line 3: position: received \"inf\", expected a finite number",
            ),
            (
                "time_s,position\n0,1\n1,2\n\n1,3\n",
                ": line 5: time_s: received \"1\", expected more than 1, the time before",
            ),
            (
                "time_s,position\n0,1\n",
                ": received 1 rows, expected at least 2",
            ),
            ("", ": line 1: received the columns , expected `time_s`"),
            (
                "time_s,pos\n0,1\n1,2\n",
                ": line 1: received the columns `time_s`, `pos`, expected",
            ),
            (
                "time_s,position,position\n0,1,1\n1,2,2\n",
                ": line 1: received the columns `time_s`, `position`, `position`, expected",
            ),
            (
                "time_s,position\n0,1\n1\n",
                ": CSV error: record 2 (line: 3",
            ),
        ] {
            let message = refusal(text);
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let message = read(Path::new("no/such.csv")).unwrap_err().to_string();
        assert!(
            message.starts_with("no/such.csv: cannot be read: "),
            "{message}"
        );
    }
}
