//! The rows of two recordings side by side.

use std::path::Path;

use coaxle_lab::number::significant;
use coaxle_recording::{Item, ReadTable, Reader, Row, Value};

use super::super::open;

/// Greatest number of signals listed.
const MOST_LINES: usize = 10;

/// Differences of the rows from those recorded.
#[derive(Debug, Default, PartialEq)]
pub(super) struct RowComparison {
    /// Rows that are in both.
    rows: u64,
    /// Number of these rows in which something differs.
    differing: u64,
    /// Signals that both have.
    signals: usize,
    /// The time of the first of them.
    begin_ns: Option<i64>,
    /// Rows that are in one of both only.
    alone: u64,
    /// Differences by signal, in the order of the recording.
    differences: Vec<SignalDifference>,
}

/// Differences of a signal.
#[derive(Clone, Debug, PartialEq)]
struct SignalDifference {
    name: String,
    unit: String,
    rows: u64,
    /// Time of the first difference, s after the first row.
    first_s: f64,
    /// Largest difference of numbers.
    largest: Option<f64>,
}

/// Compares two recordings, row by row with the same time.
pub(super) fn compare(recorded: &Path, replayed: &Path) -> anyhow::Result<RowComparison> {
    let mut recorded = FirstTableRows::of(recorded)?;
    let mut replayed = FirstTableRows::of(replayed)?;
    let (mut a, mut b) = (recorded.next(), replayed.next());
    let mut comparison = RowComparison::default();
    let mut columns = None;
    while let (Some(was), Some(is)) = (&a, &b) {
        // By time, not by place: the recording may have dropped rows.
        match was.at_ns.cmp(&is.at_ns) {
            std::cmp::Ordering::Less => {
                comparison.alone += 1;
                a = recorded.next();
            }
            std::cmp::Ordering::Greater => {
                comparison.alone += 1;
                b = replayed.next();
            }
            std::cmp::Ordering::Equal => {
                let columns = columns
                    // Tables are known only after their first row was read.
                    .get_or_insert_with(|| CommonColumns::of(recorded.table(), replayed.table()));
                comparison.row(columns, was, is);
                (a, b) = (recorded.next(), replayed.next());
            }
        }
    }
    comparison.alone += u64::from(a.is_some()) + u64::from(b.is_some());
    comparison.alone += recorded.count() as u64 + replayed.count() as u64;
    if let Some(columns) = columns {
        comparison.signals = columns.0.len();
        comparison.differences = columns.differences();
    }
    Ok(comparison)
}

impl RowComparison {
    /// True if both have rows in common and all of these are equal.
    pub(super) const fn is_same(&self) -> bool {
        // Rows of one side alone are no difference: they were dropped, and a line reports them.
        self.rows > 0 && self.differing == 0
    }

    /// A line, and one for each signal that differs.
    pub(super) fn lines(&self) -> Vec<String> {
        let Self {
            rows,
            signals,
            differing,
            ..
        } = self;
        let mut lines = Vec::new();
        if *rows == 0 {
            lines.push("no row of it is in the recording: nothing to compare".to_owned());
        } else if *differing == 0 {
            lines.push(format!(
                "the same bit for bit: {rows} rows of {signals} signals"
            ));
        } else {
            lines.push(format!(
                "{differing} of {rows} rows differ, in {} of {signals} signals",
                self.differences.len()
            ));
        }
        lines.extend(
            self.differences
                .iter()
                .take(MOST_LINES)
                .map(SignalDifference::line),
        );
        if self.differences.len() > MOST_LINES {
            lines.push(format!(
                "  and {} more",
                self.differences.len() - MOST_LINES
            ));
        }
        if self.alone > 0 {
            lines.push(format!(
                "{} rows are in one of both only: the recording dropped them, or their inputs",
                self.alone
            ));
        }
        lines
    }

    fn row(&mut self, columns: &mut CommonColumns, was: &Row, is: &Row) {
        self.rows += 1;
        let begin_ns = *self.begin_ns.get_or_insert(was.at_ns);
        let after_s = was.at_ns.saturating_sub(begin_ns) as f64 * 1e-9;
        let mut differs = false;
        for column in &mut columns.0 {
            let (was_value, is_value) = (&was.values[column.was], &is.values[column.is]);
            if !is_same(was_value.as_ref(), is_value.as_ref()) {
                differs = true;
                column.note(after_s, was_value.as_ref(), is_value.as_ref());
            }
        }
        self.differing += u64::from(differs);
    }
}

impl SignalDifference {
    fn line(&self) -> String {
        let Self {
            name,
            unit,
            rows,
            first_s,
            largest,
        } = self;
        let by = largest.map_or_else(String::new, |largest| {
            let unit = if unit.is_empty() {
                ""
            } else {
                &format!(" {unit}")
            };
            format!(", by {}{unit} at most", significant(largest, 3))
        });
        format!("  {name}: {rows} rows, first after {first_s:.6} s{by}")
    }
}

/// Equality to the last bit: NaN equals NaN.
fn is_same(was: Option<&Value>, is: Option<&Value>) -> bool {
    match (was, is) {
        // Bits instead of `==`: NaN would differ from itself, and 0 would equal −0.
        (Some(Value::Number(was)), Some(Value::Number(is))) => was.to_bits() == is.to_bits(),
        (was, is) => was == is,
    }
}

/// The columns that both have.
struct CommonColumns(Vec<CommonColumn>);

struct CommonColumn {
    was: usize,
    is: usize,
    difference: SignalDifference,
}

impl CommonColumns {
    fn of(was: &ReadTable, is: &ReadTable) -> Self {
        let both = was.columns.iter().enumerate().filter_map(|(n, column)| {
            let mut others = is.columns.iter();
            let is_it = |other: &coaxle_recording::Column| {
                // By name, because another config may have other slaves and so other columns.
                other.instance == column.instance && other.signal == column.signal
            };
            Some(CommonColumn {
                was: n,
                is: others.position(is_it)?,
                difference: SignalDifference {
                    name: column.name(),
                    unit: column.unit.clone(),
                    rows: 0,
                    first_s: 0.0,
                    largest: None,
                },
            })
        });
        Self(both.collect())
    }

    fn differences(self) -> Vec<SignalDifference> {
        let all = self.0.into_iter().map(|column| column.difference);
        all.filter(|difference| difference.rows > 0).collect()
    }
}

impl CommonColumn {
    fn note(&mut self, after_s: f64, was: Option<&Value>, is: Option<&Value>) {
        let difference = &mut self.difference;
        if difference.rows == 0 {
            difference.first_s = after_s;
        }
        difference.rows += 1;
        let number = |value: Option<&Value>| value.and_then(Value::as_number);
        if let (Some(was), Some(is)) = (number(was), number(is)) {
            let by = (was - is).abs();
            // `max` passes over a NaN, which would hide every other difference.
            difference.largest = Some(difference.largest.map_or(by, |largest| largest.max(by)));
        }
    }
}

/// The rows of the first table of a recording.
struct FirstTableRows(Reader<std::io::BufReader<std::fs::File>>);

impl FirstTableRows {
    fn of(path: &Path) -> anyhow::Result<Self> {
        Ok(Self(Reader::new(open(path)?)))
    }

    /// The table, once a row of it was read.
    fn table(&self) -> &ReadTable {
        &self.0.tables()[0]
    }
}

impl Iterator for FirstTableRows {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        self.0.by_ref().find_map(|item| match item {
            // A receiver's recording has one table. Damage was reported by the replay.
            Ok(Item::Row(row)) if row.table == 0 => Some(row),
            _ => None,
        })
    }
}
