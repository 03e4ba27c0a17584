//! The sender node.

use std::num::NonZeroU32;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleIndex, Instant, Local, Schedule, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::frame::{FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_node::{Channel, Message, Node, Outgoing, TimeServer, TimeServerCounters};
use coaxle_source::config::AxisConfig;
use coaxle_source::{AxisSample, ReplayError, Source, axis_struct};

use crate::config::{SHOWN_BY_DEFAULT, SenderConfig};

/// The sender node: each cycle it works out where its axes are at the ideal start of that cycle
/// and encodes them into one frame, in the order of their ids.
///
/// Axes follow the time of the node's clock, not the number of its cycles: cycles that are skipped
/// are skipped by the motion too.
pub struct Sender {
    schedule: Schedule,
    start: Instant<Local>,
    header: FrameHeader,
    axes: Vec<Axis>,
    shown: Vec<NcToPlcAxis>,
    body: Vec<u8>,
    /// Length of the body that waits to be sent.
    waiting: Option<usize>,
    time_server: TimeServer,
    snapshot: SenderSnapshot,
}

struct Axis {
    id: u32,
    modulo: Option<f64>,
    source: Box<dyn Source>,
    /// Its place in the snapshot, if it is shown there.
    slot: Option<usize>,
}

/// What a sender shows of itself after each cycle.
#[derive(Debug, PartialEq)]
pub struct SenderSnapshot {
    /// The cycle, skipped ones counted.
    pub count: u64,
    /// The manual's index of that cycle.
    pub index: CycleIndex,
    /// This run of the sender.
    pub epoch: u64,
    /// When the cycle should have begun.
    pub ideal_start: Instant<Local>,
    /// When it began.
    pub woke: Instant<Local>,
    /// Cycles skipped so far.
    pub overruns: u64,
    /// What became of time requests about its clock.
    pub time_requests: TimeRequestCounters,
    /// How the axes that the config shows (the first ones by id, unless it names others) really
    /// move, at the ideal start of the cycle.
    pub axes: Box<[AxisKinematics]>,
}

impl Clone for SenderSnapshot {
    fn clone(&self) -> Self {
        Self {
            axes: self.axes.clone(),
            ..*self
        }
    }

    fn clone_from(&mut self, other: &Self) {
        let Self {
            count,
            index,
            epoch,
            ideal_start,
            woke,
            overruns,
            time_requests,
            axes,
        } = self;
        *count = other.count;
        *index = other.index;
        *epoch = other.epoch;
        *ideal_start = other.ideal_start;
        *woke = other.woke;
        *overruns = other.overruns;
        *time_requests = other.time_requests;
        // In place: they are as many.
        axes.clone_from(&other.axes);
    }
}

/// What became of time requests about a sender's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimeRequestCounters {
    /// Answered, or dropped because too many came in one cycle.
    pub taken: TimeServerCounters,
    /// Refused before they reached the node.
    pub refused: u64,
}

/// How an axis really moves: behind an encoder, this is what the encoder measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisKinematics {
    /// The axis id.
    pub id: u32,
    /// Position, u.
    pub position: f64,
    /// Velocity, u/s.
    pub velocity: f64,
    /// Acceleration, u/s².
    pub acceleration: f64,
}

impl Sender {
    /// The node whose first cycle is due at `start`. `epoch` tells this run from earlier ones of
    /// the same sender. Reads the files of replayed axes.
    ///
    /// # Errors
    /// [`SenderError`] where such a file cannot be replayed, or an axis is to be shown that does
    /// not exist.
    pub fn new(
        config: &SenderConfig,
        start: Instant<Local>,
        epoch: u64,
    ) -> Result<Self, SenderError> {
        let mut axes = config
            .axes
            .iter()
            .map(Axis::new)
            .collect::<Result<Vec<_>, _>>()?;
        axes.sort_by_key(|axis| axis.id);
        let shown = choose_shown(&mut axes, config.show_axes.ids())?;
        let cycle_time = config.cycle_time_us.0;
        let sender = sender_id(&config.name);
        Ok(Self {
            schedule: Schedule::new(start, cycle_time),
            start,
            header: FrameHeader {
                sender,
                epoch,
                index: CycleIndex::of_count(0),
                count: 0,
                cycle_time,
                send_stamp: None,
            },
            shown: vec![NcToPlcAxis::default(); axes.len()],
            body: vec![0; body_capacity(axes.len())],
            axes,
            waiting: None,
            time_server: TimeServer::new(sender, epoch, start, cycle_time),
            snapshot: SenderSnapshot {
                count: 0,
                index: CycleIndex::of_count(0),
                epoch,
                ideal_start: start,
                woke: start,
                overruns: 0,
                time_requests: TimeRequestCounters::default(),
                axes: shown,
            },
        })
    }

    /// The axes as they are in the newest frame, in the order of their ids.
    #[must_use]
    pub fn axes(&self) -> &[NcToPlcAxis] {
        &self.shown
    }

    fn move_axes(&mut self, since_start: Span) {
        for (axis, shown) in self.axes.iter_mut().zip(&mut self.shown) {
            let sample = axis.source.sample(since_start);
            *shown = axis_struct(axis.id, axis.modulo, &sample);
            if let Some(slot) = axis.slot {
                self.snapshot.axes[slot] = AxisKinematics::of(axis.id, &sample);
            }
        }
    }

    fn encode(&mut self, tick: &Tick) {
        self.header.count = tick.count;
        self.header.index = CycleIndex::of_count(tick.count);
        let length = encode_body(&self.header, &self.shown, &mut self.body)
            .expect("the config bounds the axes and the body was made for them");
        self.waiting = Some(length);
    }
}

impl Node for Sender {
    type Snapshot = SenderSnapshot;

    /// A sender follows nobody, but it is asked what its clock shows.
    fn receive(&mut self, at: Instant<Local>, _: usize, message: &Message<'_>) {
        match message {
            Message::TimeRequest(request) => self.time_server.receive(at, request),
            Message::Rejected(_) => {
                let refused = &mut self.snapshot.time_requests.refused;
                *refused = refused.saturating_add(1);
            }
            Message::Frame(_) | Message::TimeResponse(_) => {}
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        let tick = self.schedule.take(now);
        self.move_axes(tick.ideal_start - self.start);
        self.encode(&tick);
        self.time_server.respond(&tick, now);
        self.snapshot.time_requests.taken = self.time_server.counters();
        self.snapshot.count = tick.count;
        self.snapshot.index = self.header.index;
        self.snapshot.ideal_start = tick.ideal_start;
        self.snapshot.woke = now;
        self.snapshot.overruns = self.schedule.overruns();
        tick
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let Some(length) = self.waiting.take() else {
            return self.time_server.transmit();
        };
        Some(Outgoing {
            channel: Channel::Axes,
            far: 0,
            ideal_start: self.snapshot.ideal_start,
            body: &self.body[..length],
        })
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.schedule.next_start()
    }

    fn snapshot(&self) -> &SenderSnapshot {
        &self.snapshot
    }

    fn snapshot_size(&self) -> usize {
        size_of::<SenderSnapshot>() + size_of_val(&*self.snapshot.axes)
    }
}

impl Axis {
    fn new(config: &AxisConfig) -> Result<Self, SenderError> {
        let source = coaxle_source::open(&config.source).map_err(|reason| SenderError::Replay {
            axis: config.name.clone(),
            reason,
        })?;
        Ok(Self {
            id: config.id.get(),
            modulo: config.modulo.map(|modulo| modulo.get()),
            source,
            slot: None,
        })
    }
}

/// Gives the axes that are to be shown their places in the snapshot: `wanted` in that order, or
/// the first ones where nothing is said. They are at rest at 0 until the first cycle.
fn choose_shown(
    axes: &mut [Axis],
    wanted: &[NonZeroU32],
) -> Result<Box<[AxisKinematics]>, SenderError> {
    let mut wanted: Vec<u32> = wanted.iter().map(|id| id.get()).collect();
    if wanted.is_empty() {
        wanted.extend(axes.iter().take(SHOWN_BY_DEFAULT).map(|axis| axis.id));
    }
    for (slot, id) in wanted.iter().enumerate() {
        match axes.iter_mut().find(|axis| axis.id == *id) {
            Some(axis) => axis.slot = Some(slot),
            None => {
                return Err(SenderError::NoSuchAxis {
                    received: *id,
                    expected: axes.iter().map(|axis| axis.id).collect(),
                });
            }
        }
    }
    let at_rest = |id| AxisKinematics {
        id,
        position: 0.0,
        velocity: 0.0,
        acceleration: 0.0,
    };
    Ok(wanted.into_iter().map(at_rest).collect())
}

impl AxisKinematics {
    fn of(id: u32, sample: &AxisSample) -> Self {
        let Kinematics {
            position,
            velocity,
            acceleration,
        } = sample.motion;
        Self {
            id,
            position,
            velocity,
            acceleration,
        }
    }
}

/// A sender that cannot start.
#[derive(Debug, thiserror::Error)]
pub enum SenderError {
    /// A recorded motion cannot be replayed.
    #[error("axis {axis:?}: {reason}")]
    Replay {
        /// The axis.
        axis: String,
        /// Why.
        reason: ReplayError,
    },
    /// An axis is to be shown that does not exist.
    #[error("show-axes: received id {received}, expected ids of the sender's axes: {expected:?}")]
    NoSuchAxis {
        /// The id.
        received: u32,
        /// Those there are.
        expected: Vec<u32>,
    },
}
