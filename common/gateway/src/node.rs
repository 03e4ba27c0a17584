//! The gateway node.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleIndex, Instant, Local, Schedule, Span};
use coaxle_node::frame::{FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_node::{AxisSample, Channel, Message, Node, Outgoing, TimeServerCounters};

use crate::config::{GatewayConfig, OutputConfig};
use crate::index_counter::{IndexCounter, SampleClass};
use crate::plc_clock::PlcClock;
use crate::port::{PlcOutput, PlcSample, Port};
use crate::signals::PlcAxisSignals;
use crate::snapshot::GatewaySnapshot;

/// Greatest age of a sample to publish: a PLC that was away has nothing to catch up on.
// Equal to the tolerance between count and time, beyond which a receiver refuses a frame.
const STALE: Span = Span::from_millis(100);
/// Greatest number of samples taken in one cycle: the rest of a burst waits for the next one.
// As many as the rings of the real world hold.
const SAMPLES_PER_CYCLE: u32 = 64;
/// The first subscription with axes for the PLC; the one before it has time requests.
const OUTPUTS: usize = 1;

/// The gateway node: publishes each cycle of a PLC once, as soon as the PLC's clock is known, and
/// forwards axes to it.
///
/// Its own cycles are twice as fast as the PLC's. The frames that it publishes are those of the PLC:
/// count, index and cycle time are the PLC's, the send stamp is relative to the ideal start of the PLC's
/// cycle, and time responses contain the PLC's clock. Each run of the PLC has an epoch of its own.
pub struct Gateway<P> {
    port: P,
    schedule: Schedule,
    counter: IndexCounter,
    clock: PlcClock,
    header: FrameHeader,
    ids: Box<[u32]>,
    incoming: PlcSample,
    newest: PlcSample,
    /// The cycle of the newest sample.
    newest_count: Option<u64>,
    body: Vec<u8>,
    /// The body that waits to be sent, and the start of its cycle.
    waiting: Option<(usize, Instant<Local>)>,
    outputs: Box<[Output]>,
    snapshot: GatewaySnapshot,
}

/// Axes of one node for the PLC.
struct Output {
    ids: Box<[u32]>,
    axes: Box<[Option<NcToPlcAxis>]>,
    /// The index of a frame that waits to be forwarded.
    index: Option<CycleIndex>,
}

impl<P: Port> Gateway<P> {
    /// Makes the node whose first cycle is due at `start`; `epoch` is that of the first run of the PLC.
    /// The config has been [checked](GatewayConfig::check).
    #[must_use]
    pub fn new(config: &GatewayConfig, port: P, start: Instant<Local>, epoch: u64) -> Self {
        let cycle_time = config.cycle_time_us.0;
        let sender = sender_id(&config.name);
        let axes = config.axes.len();
        let mut snapshot = GatewaySnapshot::new(config);
        snapshot.signals.node.run = epoch;
        Self {
            port,
            schedule: Schedule::new(start, config.scan_time()),
            counter: IndexCounter::new(cycle_time),
            clock: PlcClock::new(sender, epoch, cycle_time),
            header: FrameHeader {
                sender,
                epoch,
                index: CycleIndex(0),
                count: 0,
                cycle_time,
                present_after: None,
                send_stamp: None,
            },
            ids: config.axes.iter().map(|axis| axis.id.get()).collect(),
            incoming: PlcSample::of_axes(axes),
            newest: PlcSample::of_axes(axes),
            newest_count: None,
            body: vec![0; body_capacity(axes)],
            waiting: None,
            outputs: config.outputs.iter().map(Output::of).collect(),
            snapshot,
        }
    }

    /// Takes the samples that have arrived; true if one is of a new cycle.
    fn take_samples(&mut self, now: Instant<Local>) -> bool {
        let mut is_new = false;
        // Bounded: a port that never ends must not hang the cycle.
        for _ in 0..SAMPLES_PER_CYCLE {
            // Dated by the ideal start, to which the port's stamps are related.
            if !self.port.receive(now, &mut self.incoming) {
                break;
            }
            is_new |= self.take_sample();
        }
        is_new
    }

    fn take_sample(&mut self) -> bool {
        let PlcSample {
            at,
            index,
            connection,
            ..
        } = self.incoming;
        // Before the index is classified: after another connection it may continue by chance.
        if self.newest_count.is_some() && connection != self.newest.connection {
            self.counter.reset();
        }
        let signals = &mut self.snapshot.signals.node;
        let count = match self.counter.classify(index, at) {
            SampleClass::New { count } => {
                // The first cycle of a node has none before it.
                let before = self.newest_count.unwrap_or(count);
                // The cycles between the two were seen by nobody.
                signals.plc_missed += count.saturating_sub(before + 1);
                count
            }
            SampleClass::Begun { count, run } => {
                // The far clock of the old run would take the new counts for errors.
                self.clock.begin(run);
                signals.plc_runs += 1;
                count
            }
            SampleClass::Repeated | SampleClass::Outdated => {
                signals.plc_repeated += 1;
                return false;
            }
            SampleClass::Foreign => {
                signals.plc_foreign += 1;
                return false;
            }
        };
        signals.plc_cycles += 1;
        self.clock.observe(count, at);
        self.newest_count = Some(count);
        // The buffers change places: nothing is copied or allocated.
        std::mem::swap(&mut self.incoming, &mut self.newest);
        true
    }

    /// Encodes the newest sample, if the PLC's clock is known.
    fn publish(&mut self, now: Instant<Local>) {
        let Some(count) = self.newest_count else {
            return;
        };
        // Without the line a send stamp would carry the jitter of reading to all receivers.
        let Some(start) = self.clock.start_of(count) else {
            return;
        };
        // A burst after a stop: receivers have extrapolated beyond it already.
        if self.ids.is_empty() || now - self.newest.at > STALE {
            return;
        }
        // The config's ids: the id in the image is the PLC's own.
        for (axis, id) in self.newest.axes.iter_mut().zip(&self.ids) {
            axis.axis_id = *id;
        }
        self.header.epoch = self.clock.epoch();
        self.header.count = count;
        self.header.index = self.newest.index;
        let length = encode_body(&self.header, &self.newest.axes, &mut self.body)
            .expect("the config bounds the axes and the body was made for them");
        self.waiting = Some((length, start));
    }

    /// Forwards the axes for the PLC.
    fn forward_outputs(&mut self) {
        for (number, output) in self.outputs.iter_mut().enumerate() {
            // Once: a PLC must not see the same index as a new one.
            if let Some(index) = output.index.take() {
                self.port.send(&PlcOutput {
                    number,
                    index,
                    axes: &output.axes,
                });
            }
        }
    }

    fn show(&mut self, tick: &Tick) {
        let link = self.port.state();
        let signals = &mut self.snapshot.signals.node;
        signals.cycle = tick.count;
        signals.overruns = self.schedule.overruns();
        signals.plc_is_up = link.is_up;
        signals.plc_is_stopped = link.is_stopped;
        signals.plc_connections = link.connections;
        signals.plc_torn = link.torn;
        signals.plc_refused = link.refused;
        signals.plc_synced = self.clock.drift_ppm().is_some();
        signals.plc_drift_ppm = self.clock.drift_ppm();
        let TimeServerCounters { answered, dropped } = self.clock.counters();
        signals.requests_answered = answered;
        signals.requests_dropped = dropped;
        let Some(count) = self.newest_count else {
            // Without a sample the signals of the axes stay as they are.
            signals.plc_lateness_us = None;
            return;
        };
        signals.plc_index = self.newest.index.0;
        signals.plc_count = count;
        let lateness = self
            .clock
            .start_of(count)
            .map(|start| self.newest.at - start);
        signals.plc_lateness_us = lateness.map(Span::as_micros_f64);
        for (shown, axis) in self.snapshot.signals.axes.iter_mut().zip(&self.newest.axes) {
            *shown = PlcAxisSignals {
                position: axis.set_position,
                velocity: axis.set_velocity,
                acceleration: axis.set_acceleration,
                error_code: axis.error_code,
            };
        }
    }
}

impl<P: Port> Node for Gateway<P> {
    type Snapshot = GatewaySnapshot;

    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>) {
        let signals = &mut self.snapshot.signals.node;
        match (subscription, message) {
            (_, Message::TimeRequest(request)) => self.clock.receive_request(at, request),
            (OUTPUTS.., Message::Frame(frame)) => {
                signals.outputs += 1;
                if let Some(output) = self.outputs.get_mut(subscription - OUTPUTS) {
                    output.take(frame.header.index, frame.axes);
                }
            }
            (OUTPUTS.., Message::Rejected(_)) => signals.outputs_refused += 1,
            (_, Message::Rejected(_)) => signals.requests_refused += 1,
            // The node has no timing channel, and no frames come as requests.
            (_, Message::Frame(_))
            | (_, Message::TimeResponse(_))
            | (_, Message::BeaconRequest(_))
            | (_, Message::BeaconResponse(_))
            | (_, Message::PlannedPiece(_))
            | (_, Message::PlanRefused(_))
            | (_, Message::FollowerReport(_)) => {}
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        let tick = self.schedule.take(now);
        let is_new = self.take_samples(tick.ideal_start);
        // After the samples of this cycle, so that they are in the line. At the ideal start: the jitter of waking is no
        // part of the line.
        self.clock.cycle(tick.ideal_start, self.newest_count);
        if is_new {
            self.publish(now);
        }
        // After the line is renewed, which the responses are about.
        self.clock.respond(now);
        self.forward_outputs();
        self.show(&tick);
        tick
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        // Axes before responses: receivers wait for them in each cycle.
        let Some((length, ideal_start)) = self.waiting.take() else {
            return self.clock.transmit();
        };
        Some(Outgoing {
            channel: Channel::Axes,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.schedule.next_start()
    }

    fn snapshot(&self) -> &GatewaySnapshot {
        &self.snapshot
    }

    fn snapshot_size(&self) -> usize {
        self.snapshot.size()
    }
}

impl Output {
    fn of(config: &OutputConfig) -> Self {
        let ids = config.ids();
        Self {
            axes: vec![None; ids.len()].into(),
            ids: ids.into(),
            index: None,
        }
    }

    /// Keeps the axes of a frame; the newest one is forwarded.
    fn take(&mut self, index: CycleIndex, samples: &[Option<AxisSample>]) {
        let places = self.axes.iter_mut().zip(&self.ids);
        for ((axis, id), sample) in places.zip(samples) {
            // An axis that did not come is none, not the previous one.
            *axis = sample.as_ref().map(|sample| of_sample(*id, sample));
        }
        self.index = Some(index);
    }
}

/// Returns the structure of an axis from a sample of a frame.
fn of_sample(id: u32, sample: &AxisSample) -> NcToPlcAxis {
    NcToPlcAxis {
        axis_id: id,
        state_word: sample.state_word,
        error_code: sample.error_code,
        actual_position: sample.set.position,
        actual_velocity: sample.set.velocity,
        set_position: sample.set.position,
        set_velocity: sample.set.velocity,
        set_acceleration: sample.set.acceleration,
        ..NcToPlcAxis::default()
    }
}
