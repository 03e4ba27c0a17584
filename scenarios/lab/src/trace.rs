//! `trace.csv`: every receiver cycle, a line for each far or virtual axis.

use std::io::Write;

use anyhow::Context;
use coaxle_node::signal::Instance;
use coaxle_receiver::ReceiverConfig;
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals, SlaveSignals};
use serde::Serialize;

use crate::row::{Row, RowSink};
use crate::topology::View;

/// A line of the trace, in front of the receiver's signals.
#[derive(Serialize)]
struct TraceLine<'a> {
    receiver: &'a str,
    t_s: f64,
    true_position: Option<f64>,
    true_velocity: Option<f64>,
    set_velocity: Option<f64>,
    time_error_us: Option<f64>,
}

/// Writes the trace. The first error ends it and is reported at the end.
pub(crate) struct TraceWriter<W: Write> {
    names: Vec<String>,
    columns: Vec<String>,
    csv: csv::Writer<W>,
    error: Option<csv::Error>,
    wrote_header: bool,
}

impl<W: Write> TraceWriter<W> {
    pub(crate) fn new(receivers: &[ReceiverConfig], views: &[View], writer: W) -> Self {
        Self {
            names: views.iter().map(|view| view.name.clone()).collect(),
            columns: columns(receivers, views),
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
        // A row cannot return an error: a sink only takes them.
        if let Some(error) = self.error {
            return Err(error).context("cannot write the trace");
        }
        self.csv.flush().context("cannot write the trace")
    }

    fn write(&mut self, view: usize, row: &Row) -> csv::Result<()> {
        if !self.wrote_header {
            self.wrote_header = true;
            self.csv.write_record(&self.columns)?;
        }
        let line = TraceLine {
            receiver: &self.names[view],
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
    fn row(&mut self, view: usize, row: &Row) {
        if self.error.is_none() {
            self.error = self.write(view, row).err();
        }
    }
}

/// The columns: those of the line, then those of the record by parts of the receiver. Columns of slaves are
/// prefixed with the names of all slaves that they contain.
fn columns(receivers: &[ReceiverConfig], views: &[View]) -> Vec<String> {
    let line = [
        "receiver",
        "t_s",
        "true_position",
        "true_velocity",
        "set_velocity",
        "time_error_us",
        "at_ns",
        "woke_ns",
    ];
    // A table of CSV has one header, so columns of slaves are those of the receiver with the most.
    let most = views
        .iter()
        .map(|view| view.slaves.len())
        .max()
        .unwrap_or(0);
    let names = (0..most).map(|n| {
        let nth = views.iter().filter_map(|view| {
            let slave = &receivers[view.receiver].slaves[*view.slaves.get(n)?];
            Some(slave.name.as_str())
        });
        let mut names: Vec<_> = nth.collect();
        names.sort_unstable();
        names.dedup();
        names.join("|")
    });
    let of = |name: &str, instance: fn(String) -> Instance| {
        instance(name.to_owned()).columns().collect::<Vec<_>>()
    };
    let mut columns = line.map(str::to_owned).to_vec();
    columns.extend(of("", Instance::of::<NodeSignals>));
    columns.extend(of("far", Instance::of::<FarNodeSignals>));
    columns.extend(of("axis", Instance::of::<FarAxisSignals>));
    columns.extend(names.flat_map(|name| of(&name, Instance::of::<SlaveSignals>)));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::ReceiverCycle;
    use coaxle_receiver::SignalRow;

    fn lines_of(rest: &str) -> Vec<String> {
        let text = format!("name = 'r'\ncycle-time-us = 1000\nmaster = {{ node = 'm' }}\n{rest}");
        let config: ReceiverConfig = coaxle_node::config::parse("test", &text).unwrap();
        let view = View::of_first_axis(config.slaves.len());
        let mut record = Box::<ReceiverCycle>::default();
        record.fill(0, 0, &SignalRow::new(&config), &view);
        let mut trace = TraceWriter::new(&[config], &[view], Vec::new());
        let row = Row {
            t_s: 1.5,
            record,
            truth: None,
            set_velocity: None,
            time_error_us: Some(2.0),
            evaluated: true,
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
            ("far.restarts", "0"),
            ("axis.synced", "false"),
            ("a.state", "disabled"),
            ("a.drive_state", "off"),
            ("a.following_error", "0.0"),
            ("b.state", "disabled"),
            ("b.following_error", "0.0"),
        ] {
            assert_eq!(value(column), Some(expected), "{column}");
        }
    }
}
