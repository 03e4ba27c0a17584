//! Our own nodes, with stamps of every step.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local, Span};
use coaxle_host::network::transport::{InProcess, Publisher};
use coaxle_host::node::{ArrivalRecord, Record, Recorder, Setup, run_over};
use coaxle_node::{Arrived, Message, Node, Outgoing};
use coaxle_os::{Machine, machine};
use coaxle_receiver::ReceiverSnapshot;
use coaxle_sender::{Sender, SenderSnapshot};

use super::report_ready;
use crate::bench::configs::{receiver_setup, sender_config, sender_setup};
use crate::bench::plan::{CycleStamps, FrameArrival, PeerReport};

/// Runs the sender; with stamps if requested, else just as its own program would.
pub(super) fn send(config: &str, stamps: bool, limit: Span) -> anyhow::Result<PeerReport> {
    let kept = SharedReport::default();
    if stamps {
        return run(stamped(config, &kept)?, limit, &kept);
    }
    let setup = sender_setup(&sender_config(config)?, Box::new(NullRecorder), |node| node);
    run(setup, limit, &kept)
}

/// Runs the sender with stamps, without a network.
pub(super) fn send_without_network(config: &str, limit: Span) -> anyhow::Result<PeerReport> {
    let kept = SharedReport::default();
    let mut setup = stamped(config, &kept)?;
    setup.run_for = Some(limit);
    // A transport within the process: wake-ups are measured without threads of Zenoh beside them.
    run_over(setup, InProcess::default())?;
    Ok(std::mem::take(&mut *lock(&kept)))
}

fn stamped(config: &str, kept: &SharedReport) -> anyhow::Result<Setup<StampedSender>> {
    let recorder = Box::new(StampKeeper(Arc::clone(kept)));
    Ok(sender_setup(
        &sender_config(config)?,
        recorder,
        StampedSender::new,
    ))
}

/// Runs the receiver.
pub(super) fn receive(config: &str, limit: Span) -> anyhow::Result<PeerReport> {
    let kept = SharedReport::default();
    let keeper = ArrivalKeeper {
        kept: Arc::clone(&kept),
        began: BTreeMap::new(),
        waiting: Vec::new(),
    };
    run(receiver_setup(config, Box::new(keeper))?, limit, &kept)
}

type SharedReport = Arc<Mutex<PeerReport>>;

fn run<N: Node + Send + 'static>(
    mut setup: Setup<N>,
    limit: Span,
    kept: &SharedReport,
) -> anyhow::Result<PeerReport> {
    // The parent ends the process earlier. Without the limit it would outlive a parent that hangs.
    setup.run_for = Some(limit);
    coaxle_host::node::run(setup)?;
    Ok(std::mem::take(&mut *lock(kept)))
}

fn lock(kept: &SharedReport) -> std::sync::MutexGuard<'_, PeerReport> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A sender that stamps the hand-over of its frame to the publisher.
struct StampedSender {
    node: Sender,
    shown: StampedSnapshot,
}

#[derive(Clone, Copy)]
struct StampedSnapshot {
    count: u64,
    handed_over: Instant<Machine>,
}

impl StampedSender {
    fn new(node: Sender) -> Self {
        let shown = StampedSnapshot {
            count: 0,
            handed_over: Instant::EPOCH,
        };
        Self { node, shown }
    }
}

impl Node for StampedSender {
    type Snapshot = StampedSnapshot;

    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>) {
        self.node.receive(at, subscription, message);
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        let tick = self.node.cycle(now);
        // Kept for the recorder, which sees the snapshot only after the cycle.
        self.shown.count = tick.count;
        tick
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let outgoing = self.node.transmit();
        if outgoing.is_none() {
            // The last call: everything is in the outbox, and the publisher is woken next.
            self.shown.handed_over = machine::now();
        }
        outgoing
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.node.next_cycle()
    }

    fn ideal_start(&self, now: Instant<Local>) -> Instant<Local> {
        self.node.ideal_start(now)
    }

    fn snapshot(&self) -> &StampedSnapshot {
        &self.shown
    }
}

struct StampKeeper(SharedReport);

impl Recorder<StampedSnapshot> for StampKeeper {
    fn record(&mut self, record: &Record<StampedSnapshot>) {
        lock(&self.0).cycles.push(CycleStamps {
            count: record.snapshot.count,
            ideal: record.ideal_start.as_nanos(),
            woke: record.woke.as_nanos(),
            handed_over: record.snapshot.handed_over.as_nanos(),
        });
    }

    fn begin(&mut self, _epoch: u64, _rows: Box<dyn Publisher>) {
        announce();
    }
}

/// Keeps nothing of a sender.
struct NullRecorder;

impl Recorder<SenderSnapshot> for NullRecorder {
    fn record(&mut self, _record: &Record<SenderSnapshot>) {}

    fn begin(&mut self, _epoch: u64, _rows: Box<dyn Publisher>) {
        announce();
    }
}

/// Keeps the frames that a receiver took in, and the scan of each.
struct ArrivalKeeper {
    kept: SharedReport,
    /// Actual starts of scans, by their ideal starts.
    began: BTreeMap<i64, i64>,
    /// Arrivals whose scan may not be recorded yet, by its ideal start.
    waiting: Vec<(i64, FrameArrival)>,
}

impl Recorder<ReceiverSnapshot> for ArrivalKeeper {
    fn record(&mut self, record: &Record<ReceiverSnapshot>) {
        self.began
            .insert(record.ideal_start.as_nanos(), record.woke.as_nanos());
        let axes = &record.snapshot.signals.axes;
        let followed = axes.iter().filter(|axis| axis.synced && axis.error == 0);
        // Overwritten each cycle: the last one counts, when all clocks are known.
        lock(&self.kept).followed = followed.count();
    }

    fn begin(&mut self, _epoch: u64, _rows: Box<dyn Publisher>) {
        announce();
    }

    fn arrived(&mut self, record: &ArrivalRecord) {
        let Arrived::Message(header) = &record.arrival.what else {
            return;
        };
        let Some(stamp) = header.send_stamp else {
            return;
        };
        // The node's clock has no faults of its own: spans are equal in both.
        let arrived = record.ideal_start + (record.arrival.at - record.tick.ideal_start);
        let came = FrameArrival {
            count: header.count,
            left_after: stamp.as_nanos(),
            arrived: arrived.as_nanos(),
            used: 0,
        };
        // The arrival may be recorded before its scan, so both are joined at the end.
        self.waiting.push((record.ideal_start.as_nanos(), came));
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        let frames = self.waiting.drain(..).filter_map(|(scan, came)| {
            // An arrival after the last recorded scan was used by none.
            let used = *self.began.get(&scan)?;
            Some(FrameArrival { used, ..came })
        });
        lock(&self.kept).frames = frames.collect();
        Ok(())
    }
}

fn announce() {
    if let Err(error) = report_ready() {
        tracing::error!("{error:#}");
    }
}
