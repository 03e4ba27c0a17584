//! Telemetry: what leaves the cycle thread for people, recorders and the status.

use std::time::Duration;

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Span};
use coaxle_node::Arrival;
use coaxle_os::machine::{self, Machine};
use rtrb::{Consumer, Producer, RingBuffer};
use serde_json::{Map, Value};

use crate::inputs::{InputRecord, Inputs};
use crate::status::Reporter;
use crate::transport::Publisher;

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
    pub tick: Tick,
    /// What it took in.
    pub arrival: Arrival,
}

/// Keeps what a node shows of itself. It runs on the telemetry thread, where it may allocate,
/// write files and take its time: what the rings cannot hold meanwhile is dropped and counted.
pub trait Recorder<S>: Send {
    /// Takes a cycle's record; each is given once, in order.
    fn record(&mut self, record: &Record<S>);

    /// The run with this epoch begins: nothing has been given yet. Whoever looks on hears what `rows` publishes.
    fn begin(&mut self, epoch: u64, rows: Box<dyn Publisher>) {
        let _ = (epoch, rows);
    }

    /// Takes something that a cycle took in; each is given once, in order, but some time before or
    /// after the record of its cycle.
    fn arrived(&mut self, record: &ArrivalRecord) {
        let _ = record;
    }

    /// Whether it takes what the node is told before its scans.
    fn wants_inputs(&self) -> bool {
        false
    }

    /// Takes what the node was told before a scan; each is given once, in order, but some time before or after the record
    /// of its cycle.
    fn told(&mut self, record: &InputRecord) {
        let _ = record;
    }

    /// What to add to the node's status, a few times a second. A text under `health` is the
    /// node's own opinion: it shows while the network gives no reason for a worse one.
    fn status(&self) -> Map<String, Value> {
        Map::new()
    }

    /// The node's whole status, as it was published at `at`: JSON.
    fn reported(&mut self, at: Instant<Machine>, status: &str) {
        let _ = (at, status);
    }

    /// The run is over: nothing more comes.
    ///
    /// # Errors
    /// Whatever was recorded could not be kept.
    fn finish(&mut self) -> anyhow::Result<()> {
        Ok(())
    }
}

/// How often the rings are emptied.
const TICK: Duration = Duration::from_millis(10);
/// Four times a second.
const STATUS_PERIOD: Span = Span::from_millis(250);

/// Memory for records that wait for telemetry.
const RECORD_BYTES: usize = 32 << 20;
/// As many as that holds, but no more than nearly a second's worth at the shortest cycle time, and no
/// fewer than that many.
const MOST_RECORDS: usize = 8192;
const FEWEST_RECORDS: usize = 64;

/// The cycle thread's ends of the rings: records go round, so that none is ever made in a cycle.
pub(crate) struct Records<S> {
    empty: Consumer<Record<S>>,
    full: Producer<Record<S>>,
}

/// The other ends.
pub(crate) struct Telemetry<S> {
    records: Consumer<Record<S>>,
    emptied: Producer<Record<S>>,
    arrivals: Consumer<ArrivalRecord>,
    inputs: Option<Inputs>,
}

/// Rings of records like the node's snapshot, which takes so many bytes.
pub(crate) fn telemetry<S: Clone>(
    snapshot: &S,
    bytes: usize,
    arrivals: Consumer<ArrivalRecord>,
) -> (Records<S>, Telemetry<S>) {
    let count = (RECORD_BYTES / bytes.max(1)).clamp(FEWEST_RECORDS, MOST_RECORDS);
    let (mut emptied, empty) = RingBuffer::new(count);
    let (full, records) = RingBuffer::new(count);
    for _ in 0..count {
        let record = Record {
            ideal_start: Instant::EPOCH,
            woke: Instant::EPOCH,
            snapshot: snapshot.clone(),
        };
        // The ring was made for them.
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
    /// Hands a cycle to telemetry; false if that lags behind too far.
    #[must_use]
    pub(crate) fn push(
        &mut self,
        ideal_start: Instant<Machine>,
        woke: Instant<Machine>,
        snapshot: &S,
    ) -> bool {
        let Ok(mut record) = self.empty.pop() else {
            return false;
        };
        record.ideal_start = ideal_start;
        record.woke = woke;
        record.snapshot.clone_from(snapshot);
        self.full.push(record).is_ok()
    }
}

impl<S> Telemetry<S> {
    /// The oldest record, shown to `each`.
    pub(crate) fn take(&mut self, each: impl FnOnce(&Record<S>)) -> bool {
        let Ok(record) = self.records.pop() else {
            return false;
        };
        each(&record);
        // There is room for all that there are; at the end nobody takes it any more.
        let _ = self.emptied.push(record);
        true
    }

    /// From now on these inputs are telemetry's, too.
    pub(crate) fn attach(&mut self, inputs: Option<Inputs>) {
        self.inputs = inputs;
    }

    /// The oldest scan with what came before it.
    fn input(&mut self) -> Option<InputRecord> {
        self.inputs.as_mut()?.take()
    }

    /// The oldest arrival.
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
    let mut next_status = machine::now();
    loop {
        // Asked before the rings are emptied, so that the last records are not missed.
        let last_round = telemetry.records.is_abandoned();
        while telemetry.take(|record| recorder.record(record)) {}
        while let Some(arrival) = telemetry.arrival() {
            recorder.arrived(&arrival);
        }
        while let Some(input) = telemetry.input() {
            recorder.told(&input);
        }
        if last_round {
            break;
        }
        if machine::now() >= next_status {
            next_status = machine::now() + STATUS_PERIOD;
            let now = machine::now();
            let status = reporter.report(now, recorder.status());
            recorder.reported(now, &status);
        }
        std::thread::park_timeout(TICK);
    }
    let finished = recorder.finish();
    reporter.report_end(machine::now(), recorder.status());
    finished
}
