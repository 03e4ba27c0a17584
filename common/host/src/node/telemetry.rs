//! Telemetry: data from the cycle thread for people, recorders and the status.

use std::time::Duration;

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Span};
use coaxle_node::Arrival;
use coaxle_node::audit::AuditRecord;
use coaxle_os::machine::{self, Machine};
use rtrb::{Consumer, Producer, RingBuffer};
use serde_json::{Map, Value};

use crate::files::InputRecord;
use crate::files::inputs::Inputs;
use crate::network::transport::Publisher;
use crate::node::status::Reporter;

/// Telemetry of one cycle.
#[derive(Clone, Copy, Debug)]
pub struct Record<S> {
    /// Nominal start of the cycle.
    pub ideal_start: Instant<Machine>,
    /// Actual start of the cycle.
    pub woke: Instant<Machine>,
    /// Snapshot of the node at the end of the cycle.
    pub snapshot: S,
}

/// A measurement of the followed clock that a cycle took in.
#[derive(Clone, Copy, Debug)]
pub struct ArrivalRecord {
    /// Nominal start of the cycle.
    pub ideal_start: Instant<Machine>,
    /// Number of the cycle.
    pub tick: Tick,
    /// The measurement.
    pub arrival: Arrival,
}

/// Keeps the snapshots of a node. It runs on the telemetry thread, where it may allocate, write
/// files and take its time: records that do not fit into the rings meanwhile are dropped and
/// counted.
pub trait Recorder<S>: Send {
    /// Takes a cycle's record; each is passed once, in order.
    fn record(&mut self, record: &Record<S>);

    /// Begins the run with this epoch, before any record. Live viewers receive the data published
    /// by `rows`.
    fn begin(&mut self, epoch: u64, rows: Box<dyn Publisher>) {
        let _ = (epoch, rows);
    }

    /// Takes a measurement that a cycle took in; each is passed once, in order, but some time
    /// before or after the record of its cycle.
    fn arrived(&mut self, record: &ArrivalRecord) {
        let _ = record;
    }

    /// True if it takes the node's inputs before its scans.
    fn wants_inputs(&self) -> bool {
        false
    }

    /// Takes the node's inputs before a scan; each is passed once, in order, but some time before
    /// or after the record of its cycle.
    fn told(&mut self, record: &InputRecord) {
        let _ = record;
    }

    /// Additions to the node's status, a few times a second. A text under `health` is the node's
    /// own judgement: it shows while the network gives no reason for a worse one.
    fn status(&self) -> Map<String, Value> {
        Map::new()
    }

    /// Takes the node's whole status, as published at `at`: JSON.
    fn reported(&mut self, at: Instant<Machine>, status: &str) {
        let _ = (at, status);
    }

    /// Takes a record of the node's audit, made at `at`; each is passed once, in order.
    fn audited(&mut self, at: Instant<Machine>, record: &AuditRecord) {
        let _ = (at, record);
    }

    /// Ends the run: no more records follow.
    ///
    /// # Errors
    /// The recorded data could not be kept.
    fn finish(&mut self) -> anyhow::Result<()> {
        Ok(())
    }
}

/// Interval at which the rings are emptied.
// The rings hold 0.8 s of the shortest cycle, and more of longer ones.
const TICK: Duration = Duration::from_millis(10);
/// Four times a second.
const STATUS_PERIOD: Span = Span::from_millis(250);

/// Memory for records that wait for telemetry.
// 8192 records of 4 KiB.
const RECORD_BYTES: usize = 32 << 20;
/// Capacity in records, as many as this memory holds; at most nearly a second's worth at the
/// shortest cycle time, and at least the lower limit.
const MOST_RECORDS: usize = 8192;
// 64 ms at 1 kHz: telemetry empties the rings every 10 ms.
const FEWEST_RECORDS: usize = 64;

/// The cycle thread's ends of the rings: records circulate, so that none is allocated in a cycle.
pub(crate) struct Records<S> {
    empty: Consumer<Record<S>>,
    full: Producer<Record<S>>,
}

/// Telemetry's ends of the rings.
pub(crate) struct Telemetry<S> {
    records: Consumer<Record<S>>,
    emptied: Producer<Record<S>>,
    arrivals: Consumer<ArrivalRecord>,
    inputs: Option<Inputs>,
}

/// Creates rings of records like the node's snapshot, which takes `bytes` bytes.
pub(crate) fn telemetry<S: Clone>(
    snapshot: &S,
    bytes: usize,
    arrivals: Consumer<ArrivalRecord>,
) -> (Records<S>, Telemetry<S>) {
    let count = (RECORD_BYTES / bytes.max(1)).clamp(FEWEST_RECORDS, MOST_RECORDS);
    // Both rings have the same length, so that a record in hand always finds a place.
    let (mut emptied, empty) = RingBuffer::new(count);
    let (full, records) = RingBuffer::new(count);
    for _ in 0..count {
        let record = Record {
            ideal_start: Instant::EPOCH,
            woke: Instant::EPOCH,
            // Cloned here, with its buffers, which `clone_from` uses again in each cycle.
            snapshot: snapshot.clone(),
        };
        // The ring has room for all of them.
        let _ = emptied.push(record);
    }
    let telemetry = Telemetry {
        records,
        emptied,
        arrivals,
        inputs: None,
    };
    (Records { empty, full }, telemetry)
}

impl<S: Clone> Records<S> {
    /// Hands a cycle to telemetry; returns false if telemetry lags behind too far.
    #[must_use]
    pub(crate) fn push(
        &mut self,
        ideal_start: Instant<Machine>,
        woke: Instant<Machine>,
        snapshot: &S,
    ) -> bool {
        // No empty record: all of them wait for telemetry. The cycle is left out and counted.
        let Ok(mut record) = self.empty.pop() else {
            return false;
        };
        record.ideal_start = ideal_start;
        record.woke = woke;
        // `clone_from` and not `clone`: vectors of the same length keep their memory.
        record.snapshot.clone_from(snapshot);
        self.full.push(record).is_ok()
    }
}

impl<S> Telemetry<S> {
    /// Passes the oldest record to `each`; returns false if there is none.
    pub(crate) fn take(&mut self, each: impl FnOnce(&Record<S>)) -> bool {
        let Ok(record) = self.records.pop() else {
            return false;
        };
        each(&record);
        // There is room for all records; at the end the other side is gone.
        let _ = self.emptied.push(record);
        true
    }

    /// Attaches the inputs to telemetry.
    pub(crate) fn attach(&mut self, inputs: Option<Inputs>) {
        self.inputs = inputs;
    }

    /// Takes the oldest scan with its inputs.
    fn input(&mut self) -> Option<InputRecord> {
        self.inputs.as_mut()?.take()
    }

    /// Takes the oldest arrival.
    pub(crate) fn arrival(&mut self) -> Option<ArrivalRecord> {
        self.arrivals.pop().ok()
    }
}

/// Empties the rings until the cycle thread is gone, then finishes the recorder.
pub(crate) fn observe<S>(
    mut telemetry: Telemetry<S>,
    recorder: &mut dyn Recorder<S>,
    reporter: &mut Reporter,
) -> anyhow::Result<()> {
    // At once: a client that looks for the node has its status without a wait.
    let mut next_status = machine::now();
    loop {
        // Read before the rings are emptied, so that the last records are not missed.
        let last_round = telemetry.records.is_abandoned();
        while telemetry.take(|record| recorder.record(record)) {}
        while let Some(arrival) = telemetry.arrival() {
            recorder.arrived(&arrival);
        }
        while let Some(input) = telemetry.input() {
            recorder.told(&input);
        }
        for (at, record) in reporter.take_audit() {
            recorder.audited(at, &record);
        }
        if last_round {
            break;
        }
        if machine::now() >= next_status {
            // From now on, not from the last due time: after a stall there is one status, not a burst.
            next_status = machine::now() + STATUS_PERIOD;
            let now = machine::now();
            let status = reporter.report(now, recorder.status());
            recorder.reported(now, &status);
        }
        // The park is only a sleep here: nobody wakes telemetry, which saves the cycle a call.
        std::thread::park_timeout(TICK);
    }
    let finished = recorder.finish();
    // After the recorder: the last status counts what it dropped at the end.
    reporter.report_end(machine::now(), recorder.status());
    finished
}
