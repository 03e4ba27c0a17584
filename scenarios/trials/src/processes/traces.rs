//! The nodes' traces, brought together and judged.

use std::io::ErrorKind;
use std::path::Path;

use anyhow::Context;
use coaxle_clock::Instant;
use coaxle_lab::evaluate::{Evaluation, truth_of};
use coaxle_lab::finished::Finished;
use coaxle_lab::row::RowSink;
use coaxle_lab::scenario::Scenario;
use coaxle_lab::summary::World;
use coaxle_lab::topology::Topology;
use coaxle_node::signal::Signals;
use coaxle_os::Machine;
use coaxle_receiver::{ReceiverConfig, SignalRow};
use coaxle_sender::SenderRow;
use coaxle_sender::config::SenderConfig;
use csv::StringRecord;
use serde::de::DeserializeOwned;

use super::child::Child;

/// Judges every receiver cycle of all traces, in the order of time.
pub(super) fn evaluate(
    scenario: &Scenario,
    topology: &Topology,
    children: &[Child],
    begin: Instant<Machine>,
    sink: &mut impl RowSink,
) -> anyhow::Result<Finished> {
    // Zipped with the configs below, so that duplicates at the end of the list are left out.
    let (senders, receivers) = children.split_at(scenario.senders.len());
    let senders: Vec<Vec<TraceCycle<SenderRow>>> = (senders.iter().zip(&scenario.senders))
        .map(|(child, config)| read(child, |row| TraceCycle::of_sender(config, row)))
        .collect::<Result<_, _>>()?;
    let receivers: Vec<Vec<TraceCycle<SignalRow>>> = (receivers.iter().zip(&scenario.receivers))
        .map(|(child, config)| read(child, |row| TraceCycle::of_receiver(config, row)))
        .collect::<Result<_, _>>()?;
    let start = senders
        .iter()
        .flatten()
        .map(|record| record.at_ns)
        .chain(receivers.iter().flatten().map(|record| record.at_ns))
        .min()
        // Every node was killed before its first cycle.
        .unwrap_or(begin.as_nanos());
    let mut evaluation = Evaluation::new(
        scenario,
        topology,
        World::Processes,
        Instant::from_nanos(start),
    );
    for step in in_order(&senders, &receivers) {
        match step {
            TraceStep::Sender(sender, cycle) => {
                let SenderRow { node, axes } = &cycle.signals;
                // The truth of an instant comes before the receivers that are compared with it.
                evaluation.push_sender(sender, node);
                for (config, axis) in scenario.senders[sender].shown_axes().zip(axes) {
                    let sample = truth_of(cycle.at_ns, node, axis);
                    evaluation.push_master(sender, config.id.get(), sample);
                }
            }
            TraceStep::Receiver(receiver, cycle) => {
                let TraceCycle {
                    at_ns,
                    woke_ns,
                    signals,
                } = cycle;
                evaluation.push_receiver(receiver, *at_ns, *woke_ns, signals, sink);
            }
        }
    }
    Ok(Finished::new(evaluation.finish(sink)))
}

enum TraceStep<'a> {
    Sender(usize, &'a TraceCycle<SenderRow>),
    Receiver(usize, &'a TraceCycle<SignalRow>),
}

impl TraceStep<'_> {
    fn at_ns(&self) -> i64 {
        match self {
            Self::Sender(_, record) => record.at_ns,
            Self::Receiver(_, record) => record.at_ns,
        }
    }
}

fn in_order<'a>(
    senders: &'a [Vec<TraceCycle<SenderRow>>],
    receivers: &'a [Vec<TraceCycle<SignalRow>>],
) -> Vec<TraceStep<'a>> {
    let of_senders = senders.iter().enumerate().flat_map(|(n, records)| {
        records
            .iter()
            .map(move |record| TraceStep::Sender(n, record))
    });
    let of_receivers = receivers.iter().enumerate().flat_map(|(n, records)| {
        records
            .iter()
            .map(move |record| TraceStep::Receiver(n, record))
    });
    let mut steps: Vec<_> = of_senders.chain(of_receivers).collect();
    // Stable: at equal times senders stay before receivers.
    steps.sort_by_key(TraceStep::at_ns);
    steps
}

/// A node's cycle, as its trace has it. Columns are read by place, not by name: the config gives the numbers of nodes,
/// axes and slaves.
struct TraceCycle<R> {
    at_ns: i64,
    woke_ns: i64,
    signals: R,
}

impl TraceCycle<SenderRow> {
    fn of_sender(config: &SenderConfig, row: &StringRecord) -> csv::Result<Self> {
        let mut columns = RowColumns { row, at: 0 };
        let (at_ns, woke_ns) = columns.next(2)?;
        let mut signals = SenderRow::new(config);
        signals.node = columns.signals()?;
        for axis in &mut signals.axes {
            *axis = columns.signals()?;
        }
        Ok(Self {
            at_ns,
            woke_ns,
            signals,
        })
    }
}

impl TraceCycle<SignalRow> {
    fn of_receiver(config: &ReceiverConfig, row: &StringRecord) -> csv::Result<Self> {
        let mut columns = RowColumns { row, at: 0 };
        let (at_ns, woke_ns) = columns.next(2)?;
        let mut signals = SignalRow::new(config);
        signals.node = columns.signals()?;
        for far in &mut signals.far {
            *far = columns.signals()?;
        }
        for axis in &mut signals.axes {
            *axis = columns.signals()?;
        }
        for axis in &mut signals.virtual_axes {
            *axis = columns.signals()?;
        }
        for slave in &mut signals.slaves {
            *slave = columns.signals()?;
        }
        Ok(Self {
            at_ns,
            woke_ns,
            signals,
        })
    }
}

/// The values of a row, from left to right.
struct RowColumns<'a> {
    row: &'a StringRecord,
    at: usize,
}

impl RowColumns<'_> {
    fn signals<S: Signals + DeserializeOwned>(&mut self) -> csv::Result<S> {
        self.next(S::SIGNALS.len())
    }

    fn next<T: DeserializeOwned>(&mut self, count: usize) -> csv::Result<T> {
        // A part of its own, because serde reads a record from its first column.
        let part: StringRecord = self.row.iter().skip(self.at).take(count).collect();
        self.at += count;
        // Without headers, columns are taken by place.
        part.deserialize(None)
    }
}

/// Every row of all runs of a node.
fn read<T>(
    child: &Child,
    each: impl Fn(&StringRecord) -> csv::Result<T>,
) -> anyhow::Result<Vec<T>> {
    let mut rows = Vec::new();
    // A restarted node has a file for each run, in the order of time.
    for path in child.files() {
        read_file(path, &mut rows, &each)
            .with_context(|| format!("cannot read the trace {}", path.display()))?;
    }
    Ok(rows)
}

fn read_file<T>(
    path: &Path,
    rows: &mut Vec<T>,
    each: impl Fn(&StringRecord) -> csv::Result<T>,
) -> anyhow::Result<()> {
    let text = match std::fs::read_to_string(path) {
        // A node that was killed before its first cycle has none.
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        read => read?,
    };
    // A killed node may leave half a line.
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let mut reader = csv::Reader::from_reader(&text.as_bytes()[..whole]);
    for row in reader.records() {
        rows.push(each(&row?)?);
    }
    Ok(())
}
