//! The receiver as a node.

use coaxle_axis::motion_plan::PlanFault;
use coaxle_axis::{Job, NcToPlcAxis};
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleIndex, Instant, Local};
use coaxle_node::beacon::{BEACON_CAPACITY, BeaconLabel, encode_beacon_request};
use coaxle_node::circles::CircleChange;
use coaxle_node::command::{FarName, MAX_KNOWN, NotTaken, OrderCargo, SlaveName};
use coaxle_node::config::Wrong;
use coaxle_node::exchange::{TIME_REQUEST_CAPACITY, encode_time_request};
use coaxle_node::frame::sender_id;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::Subscription;
use coaxle_node::{
    Arrival, BeaconServer, BeaconServerCounters, Channel, CommandOrder, CommandOutcome,
    FrameHeader, Message, Node, Outgoing, PresentAfter, RejectionCounters, TimeServer,
    TimeServerCounters,
};
use coaxle_slave::{Command, Refusal};

use crate::axes_frame::AxesFrame;
use crate::config::ReceiverConfig;
use crate::drives::Drives;
use crate::own_cycle::OwnCycle;
use crate::pipeline::Pipeline;
use crate::reports::ReportPublisher;
use crate::slaves::{SlaveNumber, Slaves};
use crate::snapshot::ReceiverSnapshot;
use crate::virtual_axes::VirtualAxes;

/// A receiver: follows far axes and drives slaves with them.
#[derive(Debug)]
pub struct Receiver {
    cycle: OwnCycle,
    pipeline: Pipeline,
    identity: Identity,
    slave_names: Vec<NodeName>,
    far_names: Vec<NodeName>,
    tick: Tick,
    slaves: AxesFrame,
    far_axes: AxesFrame,
    /// Reports, if it has a slave of a sender's axis.
    reports: Option<Box<ReportPublisher>>,
    time_server: TimeServer,
    /// Timing channel for others, if it has one.
    beacon_server: Option<Box<BeaconServer>>,
    /// Time requests that were refused on their way in.
    refused_requests: RejectionCounters,
    /// The subscriptions, each with its node, by the number among all nodes received from.
    sources: Box<[Source]>,
    /// Time request due to each node received from.
    due: Box<[Option<u32>]>,
    /// Index of the next node to check for a due request in this cycle.
    next_asked: usize,
    request: [u8; TIME_REQUEST_CAPACITY],
    /// Beacon due to each node received from.
    due_beacons: Box<[Option<u32>]>,
    beacon: [u8; BEACON_CAPACITY],
    /// True if its beacons have readings of a common time.
    takes_common_time: bool,
    snapshot: ReceiverSnapshot,
}

/// Source of the messages of a subscription.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// A far node or a standby: its axes, or its responses.
    Far(usize),
    /// Requesters of this node's time.
    Requests,
    /// The timing channel to a far node.
    Beacons(usize),
    /// Requesters on its own timing channel.
    BeaconRequests,
    /// Plans of a far node or a standby.
    Plans(usize),
}

/// Sender's identity in every frame.
#[derive(Clone, Copy, Debug)]
struct Identity {
    sender: u32,
    epoch: u64,
}

impl Receiver {
    /// Creates a receiver whose first cycle is due at `start`. `epoch` distinguishes this run from
    /// earlier ones. The drives of its slaves are simulated; others are passed to
    /// [`with_drives`](Self::with_drives).
    ///
    /// # Errors
    /// [`Wrong`] names the parameter that is out of range, the slave whose drive is in
    /// another process, or the file of a virtual axis that cannot be replayed.
    pub fn new(config: &ReceiverConfig, start: Instant<Local>, epoch: u64) -> Result<Self, Wrong> {
        Self::with_drives(config, Drives::new(), start, epoch)
    }

    /// Creates a receiver with these drives.
    ///
    /// # Errors
    /// As [`new`](Self::new), and a drive of an unknown slave, or of one without limits.
    pub fn with_drives(
        config: &ReceiverConfig,
        drives: Drives,
        start: Instant<Local>,
        epoch: u64,
    ) -> Result<Self, Wrong> {
        let cycle_time = config.cycle_time_us.0;
        let sender = sender_id(&config.name);
        let virtual_axes = VirtualAxes::open(&config.virtual_axes, start)?;
        let slaves = Slaves::new(config, drives)?;
        let pipeline = Pipeline::new(config, virtual_axes, slaves, epoch)?;
        // Messages come with the number of their subscription, so that no name is compared in the cycle.
        let subscriptions = config.wiring().subscriptions;
        let source = |subscription: &Subscription| match subscription.channel {
            Channel::TimeRequests => Source::Requests,
            Channel::BeaconRequests => Source::BeaconRequests,
            Channel::BeaconResponses => Source::Beacons(subscription.far),
            Channel::Plans => Source::Plans(subscription.far),
            Channel::Axes
            | Channel::Slaves
            | Channel::FarAxes
            | Channel::TimeResponses
            | Channel::Followers => Source::Far(subscription.far),
        };
        let cycle = OwnCycle::new(config, start);
        let beacon_server = || BeaconServer::new(sender, epoch, cycle.start(), cycle_time);
        Ok(Self {
            pipeline,
            identity: Identity { sender, epoch },
            far_names: config.far.iter().map(|far| far.node.clone()).collect(),
            slave_names: config.slaves.iter().map(|s| s.name.clone()).collect(),
            tick: Tick {
                count: 0,
                ideal_start: start,
                // No cycle has run yet.
                elapsed: 0,
            },
            slaves: AxesFrame::new(Channel::Slaves, config.slaves.len()),
            far_axes: AxesFrame::new(Channel::FarAxes, config.published_far_axes().len()),
            reports: ReportPublisher::new(config, epoch).map(Box::new),
            time_server: TimeServer::new(sender, epoch, cycle.start(), cycle_time),
            beacon_server: (config.timing_server.as_ref()).map(|_| Box::new(beacon_server())),
            cycle,
            refused_requests: RejectionCounters::default(),
            sources: subscriptions.iter().map(source).collect(),
            due: vec![None; config.received_nodes().len()].into(),
            next_asked: 0,
            request: [0; TIME_REQUEST_CAPACITY],
            due_beacons: vec![None; config.received_nodes().len()].into(),
            beacon: [0; BEACON_CAPACITY],
            takes_common_time: config.time.is_some(),
            snapshot: ReceiverSnapshot::new(config, start),
        })
    }

    /// The slave with a name.
    #[must_use]
    pub fn slave_number(&self, name: &str) -> Option<SlaveNumber> {
        number_of(&self.slave_names, name).map(SlaveNumber)
    }

    /// Sends a command to a slave, in addition to those of its program. It takes effect with the
    /// next cycle.
    ///
    /// # Errors
    /// [`Refusal`]; the slave is unchanged.
    ///
    /// # Panics
    /// If the number is one of another receiver's, which has more slaves.
    pub fn command(&mut self, slave: SlaveNumber, command: &Command) -> Result<Job, Refusal> {
        self.pipeline.slaves.command(slave, command)
    }

    /// Virtual axes in the newest cycle, in the order of the config.
    #[must_use]
    pub fn virtual_axes(&self) -> &[NcToPlcAxis] {
        self.pipeline.virtual_axes.axes()
    }

    /// A far axis in the newest cycle, as its slaves follow it; none without data. Axes are numbered in the order of the config,
    /// from 0; their axis ids begin with 1.
    #[must_use]
    pub fn far_axis(&self, number: usize) -> Option<NcToPlcAxis> {
        self.pipeline.corrected_axis(number)
    }

    fn unknown_slave(&self, received: SlaveName) -> CommandOutcome {
        CommandOutcome::NotTaken(NotTaken::UnknownSlave {
            received,
            known: known(&self.slave_names, SlaveName::new),
        })
    }

    /// Encodes the frames of the slaves and of the far axes in this cycle.
    fn encode_axes(&mut self) {
        let header = FrameHeader {
            sender: self.identity.sender,
            epoch: self.identity.epoch,
            // The manual's 16 bits of the count, for receivers that know only these.
            index: CycleIndex::of_count(self.tick.count),
            count: self.tick.count,
            cycle_time: self.cycle.cycle_time(),
            present_after: PresentAfter::new(self.pipeline.hold_back()),
            // The host adds the stamp where the frame leaves.
            send_stamp: None,
        };
        let pipeline = &mut self.pipeline;
        self.slaves.encode(&header, || pipeline.slaves.axes());
        self.far_axes.encode(&header, || pipeline.corrected_axes());
    }

    /// Encodes the next time request of this cycle; returns its length, and the number of the node
    /// it is to.
    fn encode_time_request(&mut self) -> Option<(usize, usize)> {
        while let Some(due) = self.due.get_mut(self.next_asked) {
            let far = self.next_asked;
            self.next_asked += 1;
            if let Some(number) = due.take() {
                let Identity { sender, epoch, .. } = self.identity;
                let at = self.tick.ideal_start;
                let length = encode_time_request(sender, epoch, number, at, &mut self.request);
                return Some((length, far));
            }
        }
        None
    }

    /// Encodes the next beacon of this cycle; returns its length, and the number of the node it is to.
    fn encode_beacon(&mut self) -> Option<(usize, usize)> {
        let due = self.due_beacons.iter().position(Option::is_some);
        let far = due?;
        let number = self.due_beacons[far].take()?;
        let label = BeaconLabel {
            requester: self.identity.sender,
            run: self.identity.epoch,
            number,
        };
        let at = self.tick.ideal_start;
        let length = encode_beacon_request(&label, self.takes_common_time, at, &mut self.beacon);
        Some((length, far))
    }

    fn show(&mut self, now: Instant<Local>) {
        let shown = &mut self.snapshot;
        shown.ideal_start = self.tick.ideal_start;
        shown.woke = now;
        let signals = &mut shown.signals.node;
        signals.cycle = self.tick.count;
        signals.run = self.identity.epoch;
        signals.overruns = self.cycle.overruns();
        self.cycle.show(signals);
        signals.hold_back_us = self.pipeline.hold_back().as_micros_f64();
        let TimeServerCounters { answered, dropped } = self.time_server.counters();
        signals.requests_answered = answered;
        signals.requests_dropped = dropped;
        signals.requests_refused = self.refused_requests.total();
        let late = (now - self.tick.ideal_start).as_micros_f64();
        let ages = shown.signals.far.iter_mut();
        ages.filter_map(|far| far.frame_age_us.as_mut())
            .for_each(|age| *age += late);
        let signals = &mut shown.signals.node;
        if let Some(server) = &self.beacon_server {
            let BeaconServerCounters {
                answered,
                dropped,
                refused,
            } = server.counters();
            signals.beacons_answered = answered;
            signals.beacons_dropped = dropped;
            signals.beacons_refused = refused;
        }
    }
}

fn number_of(names: &[NodeName], name: &str) -> Option<usize> {
    names.iter().position(|other| other.as_str() == name)
}

/// The known names, for an unknown one.
fn known<T, E>(names: &[NodeName], name: impl Fn(&str) -> Result<T, E>) -> [Option<T>; MAX_KNOWN] {
    // A fixed number of them, without allocation, as an order is answered in the cycle.
    let mut known = names.iter().filter_map(|other| name(other.as_str()).ok());
    std::array::from_fn(|_| known.next())
}

impl Node for Receiver {
    type Snapshot = ReceiverSnapshot;

    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>) {
        // Decides in the inbox which axes the next cycle can still need.
        let due = self.cycle.next_start();
        match (message, self.sources.get(subscription)) {
            // Anybody may ask, whatever the subscription.
            (Message::TimeRequest(request), _) => self.time_server.receive(at, request),
            (Message::Rejected(reason), Some(Source::Requests)) => {
                self.refused_requests.count(*reason);
            }
            (message, Some(Source::BeaconRequests)) => {
                let server = self.beacon_server.as_deref_mut();
                match (message, server) {
                    (Message::BeaconRequest(request), Some(server)) => server.receive(at, request),
                    (Message::Rejected(_), Some(server)) => server.reject(),
                    _ => {}
                }
            }
            (message, Some(Source::Beacons(number))) => {
                let node = self.pipeline.received_from(*number);
                match message {
                    Message::BeaconResponse(response) => node.store_beacon(at, response),
                    Message::Rejected(_) => node.reject_beacon(),
                    _ => {}
                }
            }
            (message, Some(Source::Plans(number))) => {
                let node = self.pipeline.received_from(*number);
                match message {
                    Message::PlannedPiece(piece) => node.store_plan(at, piece),
                    Message::PlanRefused(fault) => node.refuse_plan(*fault),
                    Message::Rejected(_) => node.refuse_plan(PlanFault::Unreadable),
                    _ => {}
                }
            }
            (message, Some(Source::Far(number))) => {
                let node = self.pipeline.received_from(*number);
                match message {
                    Message::Frame(frame) => node.store(at, frame, due),
                    Message::TimeResponse(response) => node.store_response(at, response),
                    Message::Rejected(reason) => node.reject(*reason),
                    Message::TimeRequest(_)
                    | Message::BeaconRequest(_)
                    | Message::BeaconResponse(_)
                    | Message::PlannedPiece(_)
                    | Message::PlanRefused(_)
                    | Message::FollowerReport(_) => {}
                }
            }
            // Without a reader: a subscription that the config does not have, or anything but a request among these.
            (_, Some(Source::Requests) | None) => {}
        }
    }

    fn execute_with(&mut self, order: &CommandOrder, cargo: &mut OrderCargo) -> CommandOutcome {
        match order {
            CommandOrder::Slave(order) => match self.slave_number(order.addressee.as_str()) {
                Some(number) => self.pipeline.slaves.execute(number, order),
                None => self.unknown_slave(order.addressee),
            },
            CommandOrder::Plate(order) => match self.slave_number(order.addressee.as_str()) {
                Some(number) => self.pipeline.slaves.execute_cam(number, order, cargo),
                None => self.unknown_slave(order.addressee),
            },
            CommandOrder::Far(order) => {
                match number_of(&self.far_names, order.addressee.as_str()) {
                    Some(number) => self.pipeline.far[number].execute(order),
                    None => CommandOutcome::NotTaken(NotTaken::UnknownFarNode {
                        received: order.addressee,
                        known: known(&self.far_names, FarName::new),
                    }),
                }
            }
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        self.tick = self.cycle.take(now);
        if self.cycle.is_locked() {
            // Responses to time requests count by the cycles as they are.
            let start = self.cycle.start();
            self.time_server.set_start(start);
            if let Some(server) = &mut self.beacon_server {
                server.set_start(start);
            }
        }
        self.pipeline.scan(&self.tick, &mut self.snapshot);
        self.encode_axes();
        if let Some(reports) = &mut self.reports {
            reports.encode(&self.tick, &self.pipeline.reported());
        }
        self.time_server.respond(&self.tick, now);
        if let Some(server) = &mut self.beacon_server {
            server.respond(&self.tick, now);
        }
        // A request that was not fetched is dropped: its stamp is that of its own cycle.
        for (far, due) in self.due.iter_mut().enumerate() {
            *due = self.pipeline.received_from(far).ask(&self.tick);
        }
        for (far, due) in self.due_beacons.iter_mut().enumerate() {
            *due = self.pipeline.received_from(far).due_beacon(&self.tick);
        }
        // Requests are encoded one by one while they are sent, with a single buffer.
        self.next_asked = 0;
        self.cycle.follow(&self.tick, now, &self.pipeline.far);
        self.show(now);
        self.tick
    }

    fn set_circle(&mut self, change: CircleChange) {
        self.pipeline.set_circle(change);
    }

    fn set_subscribed(&mut self, channel: Channel, is_subscribed: bool) {
        for frame in [&mut self.slaves, &mut self.far_axes] {
            if frame.channel == channel {
                frame.is_subscribed = is_subscribed;
            }
        }
        if let (Channel::Followers, Some(reports)) = (channel, &mut self.reports) {
            reports.set_subscribed(is_subscribed);
        }
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let ideal_start = self.tick.ideal_start;
        // Set values first: a slave elsewhere waits for them in this cycle.
        if self.slaves.pending.is_some() {
            return self.slaves.take(ideal_start);
        }
        if self.far_axes.pending.is_some() {
            return self.far_axes.take(ideal_start);
        }
        if let Some((length, far)) = self.encode_time_request() {
            return Some(Outgoing {
                channel: Channel::TimeRequests,
                far,
                ideal_start,
                body: &self.request[..length],
            });
        }
        if let Some((length, far)) = self.encode_beacon() {
            return Some(Outgoing {
                channel: Channel::BeaconRequests,
                far,
                ideal_start,
                body: &self.beacon[..length],
            });
        }
        let responses = self.time_server.transmit();
        responses
            .or_else(|| self.beacon_server.as_mut()?.transmit())
            .or_else(|| self.reports.as_mut()?.transmit(ideal_start))
    }

    fn arrival(&mut self) -> Option<Arrival> {
        self.pipeline.arrivals.next()
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.cycle.next_start()
    }

    fn ideal_start(&self, now: Instant<Local>) -> Instant<Local> {
        self.cycle.ideal_start(now)
    }

    fn snapshot(&self) -> &ReceiverSnapshot {
        &self.snapshot
    }

    fn snapshot_size(&self) -> usize {
        self.snapshot.size()
    }
}
