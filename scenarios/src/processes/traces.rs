//! The nodes' traces, brought together and judged.

use std::path::Path;

use anyhow::Context;
use coaxle_clock::Instant;
use coaxle_motion::profile::Kinematics;
use coaxle_receiver::ReceiverRecord;
use coaxle_sender::SenderRecord;
use coaxle_sim::TruthSample;
use serde::de::DeserializeOwned;

use super::child::Child;
use crate::evaluate::{Evaluation, RowSink};
use crate::run::Finished;
use crate::scenario::Scenario;
use crate::topology::Topology;

/// Judges every receiver cycle of all traces, in the order of time.
pub(super) fn evaluate(
    scenario: &Scenario,
    topology: &Topology,
    children: &[Child],
    sink: &mut impl RowSink,
) -> anyhow::Result<Finished> {
    let (senders, receivers) = children.split_at(scenario.senders.len());
    let senders: Vec<Vec<SenderRecord>> = senders.iter().map(read).collect::<Result<_, _>>()?;
    let receivers: Vec<Vec<ReceiverRecord>> =
        receivers.iter().map(read).collect::<Result<_, _>>()?;
    let start = senders
        .iter()
        .flatten()
        .map(|record| record.at_ns)
        .chain(receivers.iter().flatten().map(|record| record.at_ns))
        .min()
        .context("no node left a trace")?;
    let mut evaluation = Evaluation::new(scenario, topology, Instant::from_nanos(start));
    for step in in_order(&senders, &receivers) {
        match step {
            Step::Sender(sender, record) => {
                let sample = TruthSample {
                    at: Instant::from_nanos(record.at_ns),
                    epoch: record.epoch,
                    count: record.count,
                    axis: Kinematics {
                        position: record.position,
                        velocity: record.velocity,
                        acceleration: record.acceleration,
                    },
                };
                evaluation.master_was(sender, record.axis, sample);
            }
            Step::Receiver(receiver, record) => {
                evaluation.receiver_did(receiver, record.clone(), sink);
            }
        }
    }
    Ok(Finished::new(evaluation.finish(sink)))
}

enum Step<'a> {
    Sender(usize, &'a SenderRecord),
    Receiver(usize, &'a ReceiverRecord),
}

impl Step<'_> {
    fn at_ns(&self) -> i64 {
        match self {
            Self::Sender(_, record) => record.at_ns,
            Self::Receiver(_, record) => record.at_ns,
        }
    }
}

fn in_order<'a>(
    senders: &'a [Vec<SenderRecord>],
    receivers: &'a [Vec<ReceiverRecord>],
) -> Vec<Step<'a>> {
    let of_senders = senders
        .iter()
        .enumerate()
        .flat_map(|(n, records)| records.iter().map(move |record| Step::Sender(n, record)));
    let of_receivers = receivers
        .iter()
        .enumerate()
        .flat_map(|(n, records)| records.iter().map(move |record| Step::Receiver(n, record)));
    let mut steps: Vec<_> = of_senders.chain(of_receivers).collect();
    steps.sort_by_key(Step::at_ns);
    steps
}

/// All rows of all runs of a node.
fn read<T: DeserializeOwned>(child: &Child) -> anyhow::Result<Vec<T>> {
    let mut rows = Vec::new();
    for path in child.files() {
        read_file(path, &mut rows)
            .with_context(|| format!("cannot read the trace {}", path.display()))?;
    }
    Ok(rows)
}

fn read_file<T: DeserializeOwned>(path: &Path, rows: &mut Vec<T>) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(path)?;
    // A killed node may leave half a line.
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let mut reader = csv::Reader::from_reader(&text.as_bytes()[..whole]);
    for row in reader.records() {
        // By place, not by name: the slaves' columns have names of their own.
        rows.push(row?.deserialize(None)?);
    }
    Ok(())
}
