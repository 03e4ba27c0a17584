//! Record of one run in the folder of a sweep.

use std::collections::BTreeMap;

use coaxle_node::signal::Kind;
use coaxle_recording::Value;
use serde::{Deserialize, Serialize};

use crate::figures::{SummaryFields, SummaryFigure, Units};
use crate::summary::{ReceiverSummary, Summary};
use crate::verdict::Verdict;

/// Record of a run: figures, and failures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RunRecord {
    /// Number of expectations, and of violated invariants.
    pub(super) judged: usize,
    /// Failures, a line each.
    pub(super) failures: Vec<String>,
    /// The figures, a row for each receiver and slave of it.
    #[serde(default)]
    pub(super) rows: Vec<FigureRow>,
}

/// The figures of a receiver, and of one of its slaves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct FigureRow {
    /// The receiver.
    pub(super) receiver: String,
    /// The slave, if it has any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) slave: Option<String>,
    /// True for the first row of this receiver: figures of receivers count once.
    pub(super) is_first: bool,
    /// Units of its figures.
    pub(super) units: Units,
    /// Figures by name; missing ones are left out. TOML keeps every bit of a number.
    figures: BTreeMap<String, toml::Value>,
}

impl RunRecord {
    pub(super) fn of(summary: &Summary, figures: &[SummaryFigure]) -> Self {
        let failed = summary.failed().map(Verdict::to_string);
        let rows = summary
            .receivers
            .iter()
            .flat_map(|(name, receiver)| rows_of(name, receiver, figures));
        Self {
            judged: summary.expectations.len(),
            failures: failed.collect(),
            rows: rows.collect(),
        }
    }
}

fn rows_of(name: &str, receiver: &ReceiverSummary, figures: &[SummaryFigure]) -> Vec<FigureRow> {
    let fields = SummaryFields::of_receiver(receiver);
    let slaves = receiver.slaves.iter().map(Some);
    // A receiver without slaves has a row, too.
    let none = receiver.slaves.is_empty().then_some(None);
    let slaves = slaves.chain(none).enumerate();
    let row = |(n, slave): (usize, Option<(&String, &_)>)| {
        let of_slave = slave.map(|(_, slave)| SummaryFields::of_slave(slave));
        let known = figures.iter().filter_map(|figure| {
            let value = figure.value(&fields, of_slave.as_ref())?;
            Some((figure.name.clone(), stored(value)?))
        });
        FigureRow {
            receiver: name.to_owned(),
            slave: slave.map(|(name, _)| name.clone()),
            is_first: n == 0,
            units: Units::of(receiver, slave.map(|(_, slave)| slave)),
            figures: known.collect(),
        }
    };
    slaves.map(row).collect()
}

/// Converts a value; none where TOML has no such value.
fn stored(value: Value) -> Option<toml::Value> {
    Some(match value {
        Value::Number(number) => number.into(),
        Value::Count(count) => i64::try_from(count).ok()?.into(),
        Value::Integer(integer) => integer.into(),
        Value::Flag(flag) => flag.into(),
        Value::Text(text) => text.into(),
    })
}

impl FigureRow {
    /// Value of a figure; none where it is missing.
    pub(super) fn value(&self, figure: &SummaryFigure) -> Option<Value> {
        let value = self.figures.get(&figure.name)?;
        match figure.kind {
            Kind::Number => value.as_float().map(Value::Number),
            Kind::Count => u64::try_from(value.as_integer()?).ok().map(Value::Count),
            Kind::Integer => value.as_integer().map(Value::Integer),
            Kind::Flag => value.as_bool().map(Value::Flag),
            Kind::Text => value.as_str().map(|text| Value::Text(text.to_owned())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::{SlaveSummary, World};

    fn summary() -> Summary {
        let slave = |length_error| {
            let mut slave = SlaveSummary::default();
            slave.cuts.cuts = 3;
            slave.cuts.cut_length_error_max = length_error;
            slave
        };
        let slaves = [("saw", slave(Some(0.1 + 0.2))), ("print", slave(None))];
        let cutting = ReceiverSummary {
            mode: "observer",
            time_to_sync_s: Some(1e-300),
            slaves: slaves.map(|(name, slave)| (name.to_owned(), slave)).into(),
            ..ReceiverSummary::default()
        };
        let bare = ReceiverSummary::default();
        let verdict = Verdict {
            receiver: "b".to_owned(),
            slave: None,
            field: "errors".to_owned(),
            expected: "0".to_owned(),
            received: serde_json::Value::Null,
            met: false,
        };
        Summary {
            scenario: String::new(),
            title: String::new(),
            world: World::Virtual,
            seed: 1,
            duration_s: 1.0,
            interrupted_at_s: None,
            receivers: [("a", bare), ("b", cutting)]
                .map(|(name, receiver)| (name.to_owned(), receiver))
                .into(),
            routers: BTreeMap::new(),
            expectations: vec![verdict],
        }
    }

    #[test]
    fn every_receiver_and_slave_has_a_row_which_toml_keeps_to_the_bit() {
        let figures = SummaryFigure::all();
        let record = RunRecord::of(&summary(), &figures);
        let names: Vec<_> = (record.rows.iter())
            .map(|row| (row.receiver.as_str(), row.slave.as_deref(), row.is_first))
            .collect();
        let expected = [
            ("a", None, true),
            ("b", Some("print"), true),
            ("b", Some("saw"), false),
        ];
        assert_eq!(names, expected);
        assert_eq!(record.failures, ["b.errors is null, expected 0"]);
        let text = toml::to_string(&record).unwrap();
        let read: RunRecord = toml::from_str(&text).unwrap();
        assert_eq!(read, record);
        let value = |row: usize, name: &str| {
            let figure = figures.iter().find(|figure| figure.name == name).unwrap();
            read.rows[row].value(figure)
        };
        let error = "slave.cut_length_error_max";
        // 0.30000000000000004: seventeen digits, of which none may be lost.
        assert_eq!(value(2, error), Some(Value::Number(0.1 + 0.2)));
        assert_eq!(value(1, error), None);
        assert_eq!(value(2, "time_to_sync_s"), Some(Value::Number(1e-300)));
        assert_eq!(value(1, "slave.cuts"), Some(Value::Count(3)));
        assert_eq!(value(0, "slave.cuts"), None);
        assert_eq!(value(1, "mode"), Some(Value::Text("observer".to_owned())));
    }
}
