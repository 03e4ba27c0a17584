//! `trace.csv`: every receiver cycle.

use std::io::Write;

use anyhow::Context;
use coaxle_receiver::{ReceiverConfig, ReceiverRecord};
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
    columns: Vec<String>,
    csv: csv::Writer<W>,
    error: Option<csv::Error>,
    wrote_header: bool,
}

impl<W: Write> TraceWriter<W> {
    pub(crate) fn new(receivers: &[ReceiverConfig], writer: W) -> Self {
        Self {
            receivers: receivers.iter().map(|r| r.name.to_string()).collect(),
            columns: columns(receivers),
            csv: csv::WriterBuilder::new()
                .has_headers(false)
                // A receiver with fewer slaves has fewer values.
                .flexible(true)
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
            self.csv.write_record(&self.columns)?;
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

/// The columns: those of the line, then those of a receiver's record. Where receivers have several
/// slaves, a column has the names of those it is about.
fn columns(receivers: &[ReceiverConfig]) -> Vec<String> {
    let line = [
        "receiver",
        "t_s",
        "true_position",
        "true_velocity",
        "set_velocity",
        "time_error_us",
    ];
    let most = receivers.iter().map(|r| r.slaves.len()).max().unwrap_or(1);
    let names: Vec<String> = (0..most)
        .map(|n| {
            let nth = receivers.iter().filter_map(|r| r.slaves.get(n));
            let mut names: Vec<_> = nth.map(|slave| slave.name.as_str()).collect();
            names.dedup();
            names.join("|")
        })
        .collect();
    let record = ReceiverRecord::columns(names.iter().map(String::as_str));
    line.map(str::to_owned).into_iter().chain(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receiver(rest: &str) -> (ReceiverConfig, ReceiverRecord) {
        let text = format!("name = 'r'\ncycle-time-us = 1000\nmaster = {{ node = 'm' }}\n{rest}");
        let config = coaxle_node::config::parse("test", &text).unwrap();
        let start = coaxle_clock::Instant::EPOCH;
        let receiver = coaxle_receiver::Receiver::new(&config, start, 1).unwrap();
        let record = ReceiverRecord::new(0, 0, &coaxle_node::Node::snapshot(&receiver));
        (config, record)
    }

    fn lines_of(rest: &str) -> Vec<String> {
        let (config, record) = receiver(rest);
        let mut trace = TraceWriter::new(&[config], Vec::new());
        let row = Row {
            t_s: 1.5,
            record,
            truth: None,
            set_velocity: None,
            time_error_us: Some(2.0),
        };
        trace.row(0, &row);
        assert!(trace.error.is_none());
        let text = String::from_utf8(trace.csv.into_inner().unwrap()).unwrap();
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_row_has_as_many_values_as_there_are_columns() {
        for slaves in ["", "[[slave]]\nname = 'a'\n[[slave]]\nname = 'b'"] {
            let lines = lines_of(slaves);
            assert_eq!(lines.len(), 2);
            assert_eq!(lines[0].matches(',').count(), lines[1].matches(',').count());
            assert!(lines[1].starts_with("r,1.5,,,,2.0,0,0,0,"), "{}", lines[1]);
        }
    }

    #[test]
    fn every_column_has_its_name() {
        let lines = lines_of("[[slave]]\nname = 'a'\n[[slave]]\nname = 'b'");
        let value = |column: &str| {
            let place = lines[0].split(',').position(|name| name == column);
            lines[1].split(',').nth(place.expect(column))
        };
        for (column, expected) in [
            ("time_error_us", "2.0"),
            ("health", "waiting-for-master"),
            ("restarts", "0"),
            ("slave_state", "disabled"),
            ("drive_state", "off"),
            ("following_error", "0.0"),
            ("b.slave_state", "disabled"),
            ("b.following_error", "0.0"),
        ] {
            assert_eq!(value(column), Some(expected), "{column}");
        }
    }
}
