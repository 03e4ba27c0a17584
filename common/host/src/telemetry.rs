//! Telemetry: what leaves the cycle thread for people, recorders and the status.

use std::time::Duration;

use coaxle_clock::cycle::Turn;
use coaxle_clock::{Instant, Span};
use coaxle_node::Arrival;
use rtrb::Consumer;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::machine::{self, Machine};
use crate::status::Reporter;

/// One cycle as telemetry sees it.
#[derive(Clone, Copy, Debug)]
pub struct Record<S> {
    /// When the cycle should have begun.
    pub ideal_start: Instant<Machine>,
    /// When it really did.
    pub woke: Instant<Machine>,
    /// What the node showed of itself at its end.
    pub snapshot: S,
}

/// Something that a cycle took in of the followed clock.
#[derive(Clone, Copy, Debug)]
pub struct ArrivalRecord {
    /// When the cycle should have begun.
    pub ideal_start: Instant<Machine>,
    /// Which cycle it was.
    pub turn: Turn,
    /// What it took in.
    pub arrival: Arrival,
}

/// Keeps what a node shows of itself. It runs on the telemetry thread, where it may allocate,
/// write files and take its time: what the rings cannot hold meanwhile is dropped and counted.
pub trait Recorder<S>: Send {
    /// Takes a cycle's record; each is given once, in order.
    fn record(&mut self, record: &Record<S>);

    /// Takes something that a cycle took in; each is given once, in order, but some time before or
    /// after the record of its cycle.
    fn arrived(&mut self, record: &ArrivalRecord) {
        let _ = record;
    }

    /// What to add to the node's status, a few times a second. A text under `health` is the
    /// node's own opinion: it shows while the network gives no reason for a worse one.
    fn status(&self) -> Map<String, Value>;

    /// The run is over: nothing more comes.
    ///
    /// # Errors
    /// Whatever was recorded could not be kept.
    fn finish(&mut self) -> anyhow::Result<()>;
}

/// The fields of a structure, as a recorder adds them to the status; none of anything else.
#[must_use]
pub fn fields_of(structure: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(structure) {
        Ok(Value::Object(fields)) => fields,
        _ => Map::new(),
    }
}

/// How often the rings are emptied.
const TICK: Duration = Duration::from_millis(10);
/// Four times a second.
const STATUS_PERIOD: Span = Span::from_millis(250);

/// The ends of the rings that the cycle thread fills.
pub(crate) struct Telemetry<S> {
    pub(crate) records: Consumer<Record<S>>,
    pub(crate) arrivals: Consumer<ArrivalRecord>,
}

/// Empties the rings until the cycle thread is gone, then finishes the recorder.
pub(crate) fn observe<S>(
    mut telemetry: Telemetry<S>,
    recorder: &mut dyn Recorder<S>,
    reporter: &mut Reporter,
) -> anyhow::Result<()> {
    let mut next_status = machine::now();
    loop {
        // Asked before the rings are emptied, so that the last records are not missed.
        let last_round = telemetry.records.is_abandoned();
        while let Ok(record) = telemetry.records.pop() {
            recorder.record(&record);
        }
        while let Ok(arrival) = telemetry.arrivals.pop() {
            recorder.arrived(&arrival);
        }
        if last_round {
            break;
        }
        if machine::now() >= next_status {
            next_status = machine::now() + STATUS_PERIOD;
            reporter.report(recorder.status());
        }
        std::thread::park_timeout(TICK);
    }
    let finished = recorder.finish();
    reporter.report_end(recorder.status());
    finished
}
