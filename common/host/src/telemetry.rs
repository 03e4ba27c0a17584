//! Telemetry: what leaves the cycle thread for people, recorders and the status.

use std::time::Duration;

use coaxle_clock::{Instant, Span};
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

/// Keeps what a node shows of itself. It runs on the telemetry thread, where it may allocate,
/// write files and take its time: what the ring cannot hold meanwhile is dropped and counted.
pub trait Recorder<S>: Send {
    /// Takes a cycle's record; each is given once, in order.
    fn record(&mut self, record: &Record<S>);

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

/// How often the ring is emptied.
const TICK: Duration = Duration::from_millis(10);
/// Four times a second.
const STATUS_PERIOD: Span = Span::from_millis(250);

/// Empties the ring until the cycle thread is gone, then finishes the recorder.
pub(crate) fn observe<S>(
    mut records: Consumer<Record<S>>,
    recorder: &mut dyn Recorder<S>,
    reporter: &mut Reporter,
) -> anyhow::Result<()> {
    let mut next_status = machine::now();
    loop {
        // Asked before the ring is emptied, so that the last records are not missed.
        let last_round = records.is_abandoned();
        while let Ok(record) = records.pop() {
            recorder.record(&record);
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
