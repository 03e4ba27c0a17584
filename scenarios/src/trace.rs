//! `trace.csv`: every receiver cycle.

use std::io::Write;

use anyhow::Context;
use serde::Serialize;

use crate::evaluate::{Row, RowSink};

/// One line of the trace, in front of what the receiver recorded.
#[derive(Serialize)]
struct Line<'a> {
    receiver: &'a str,
    t_s: f64,
    true_position: Option<f64>,
    true_velocity: Option<f64>,
    set_velocity: Option<f64>,
    time_error_us: Option<f64>,
}

/// Writes the trace. The first error ends it and is told at the end.
pub(crate) struct TraceWriter<W: Write> {
    receivers: Vec<String>,
    csv: csv::Writer<W>,
    error: Option<csv::Error>,
    wrote_header: bool,
}

impl<W: Write> TraceWriter<W> {
    pub(crate) fn new(receivers: Vec<String>, writer: W) -> Self {
        Self {
            receivers,
            csv: csv::WriterBuilder::new()
                .has_headers(false)
                .from_writer(writer),
            error: None,
            wrote_header: false,
        }
    }

    pub(crate) fn finish(mut self) -> anyhow::Result<()> {
        if let Some(error) = self.error {
            return Err(error).context("cannot write the trace");
        }
        self.csv.flush().context("cannot write the trace")
    }

    fn write(&mut self, receiver: usize, row: &Row) -> csv::Result<()> {
        if !self.wrote_header {
            self.wrote_header = true;
            self.csv.write_record(header())?;
        }
        let line = Line {
            receiver: &self.receivers[receiver],
            t_s: row.t_s,
            true_position: row.truth.map(|(position, _)| position),
            true_velocity: row.truth.map(|(_, velocity)| velocity),
            set_velocity: row.set_velocity,
            time_error_us: row.time_error_us,
        };
        self.csv.serialize((line, &row.record))
    }
}

impl<W: Write> RowSink for TraceWriter<W> {
    fn row(&mut self, receiver: usize, row: &Row) {
        if self.error.is_none() {
            self.error = self.write(receiver, row).err();
        }
    }
}

/// The columns: those of the line, then those of the receiver's record.
fn header() -> Vec<&'static str> {
    let mut columns = vec![
        "receiver",
        "t_s",
        "true_position",
        "true_velocity",
        "set_velocity",
        "time_error_us",
    ];
    columns.extend(coaxle_receiver::ReceiverRecord::COLUMNS);
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_receiver::ReceiverRecord;

    /// The columns as serde has them.
    fn columns_of(values: impl Serialize) -> Vec<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.serialize(values).unwrap();
        let text = String::from_utf8(writer.into_inner().unwrap()).unwrap();
        let header = text.lines().next().unwrap();
        header.split(',').map(str::to_owned).collect()
    }

    fn record() -> ReceiverRecord {
        let config = coaxle_node::config::parse(
            "test",
            "name = \"r\"\ncycle-time-us = 1000\nmaster = { node = \"m\" }",
        )
        .unwrap();
        let start = coaxle_clock::Instant::EPOCH;
        let receiver = coaxle_receiver::Receiver::new(&config, start, 1).unwrap();
        ReceiverRecord::new(0, 0, &coaxle_node::Node::snapshot(&receiver))
    }

    #[test]
    fn every_column_has_its_name() {
        let line = Line {
            receiver: "r",
            t_s: 0.0,
            true_position: None,
            true_velocity: None,
            set_velocity: None,
            time_error_us: None,
        };
        let mut expected = columns_of(line);
        expected.extend(columns_of(record()));
        assert_eq!(header(), expected);
    }

    #[test]
    fn a_row_has_as_many_values_as_there_are_columns() {
        let mut trace = TraceWriter::new(vec!["r".to_owned()], Vec::new());
        trace.row(
            0,
            &Row {
                t_s: 1.5,
                record: record(),
                truth: None,
                set_velocity: None,
                time_error_us: Some(2.0),
            },
        );
        let text = String::from_utf8(trace.csv.into_inner().unwrap()).unwrap();
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].matches(',').count(), lines[1].matches(',').count());
        assert!(lines[1].starts_with("r,1.5,,,,2.0,0,0,0,"), "{}", lines[1]);
    }
}
