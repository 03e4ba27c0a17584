//! The sender node.

use std::num::NonZeroU32;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleIndex, Instant, Local, Schedule, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::Wrong;
use coaxle_node::frame::{FrameHeader, body_capacity, encode_body, sender_id};
use coaxle_node::wiring::Subscription;
use coaxle_node::{
    BeaconServer, BeaconServerCounters, Channel, Message, Node, Outgoing, PresentAfter, RunCycle,
    TimeServer, TimeServerCounters,
};
use coaxle_source::config::AxisConfig;
use coaxle_source::{AxisSource, SourceAxis, SourceSample};

use crate::config::SenderConfig;
use crate::followers::{FollowerCondition, FollowerWatch};
use crate::plans::PlanPublisher;
use crate::signals::AxisSignals;
use crate::snapshot::SenderSnapshot;
use crate::stated_delay::StatedDelay;

/// The sender node: each cycle it computes its axes at the ideal start of that cycle and encodes
/// them into one frame, in the order of their ids.
///
/// Axes follow the time of the node's clock, not the number of its cycles: the motion skips skipped
/// cycles too.
pub struct Sender {
    schedule: Schedule,
    start: Instant<Local>,
    header: FrameHeader,
    axes: Vec<Axis>,
    shown: Vec<NcToPlcAxis>,
    body: Vec<u8>,
    /// Length of the pending body.
    waiting: Option<usize>,
    /// Plans, if an axis plans.
    plans: Option<Box<PlanPublisher>>,
    time_server: TimeServer,
    beacon_server: BeaconServer,
    /// Followers, if an axis has some.
    followers: Option<Box<FollowerWatch>>,
    /// Time by which the axes are shown later, if they are.
    delay: Option<StatedDelay>,
    /// The subscriptions.
    sources: Box<[Source]>,
    snapshot: SenderSnapshot,
}

/// Source of the messages of a subscription.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// Requesters of this node's time.
    Requests,
    /// The timing channel.
    Beacons,
    /// The follower with this number.
    Follower(usize),
}

struct Axis {
    source: SourceAxis,
    /// Place in the snapshot, if it is shown there.
    slot: Option<usize>,
}

impl Sender {
    /// Creates the node whose first cycle is due at `start`. `epoch` distinguishes this run from
    /// earlier ones of the same sender. Reads the files of replayed axes.
    ///
    /// # Errors
    /// [`Wrong`] if such a file cannot be replayed, or an axis to be shown does not exist.
    pub fn new(config: &SenderConfig, start: Instant<Local>, epoch: u64) -> Result<Self, Wrong> {
        let axes = config.axes.iter().enumerate();
        let axes = axes.map(|(axis, config)| Axis::new(axis, config));
        Self::with_axes(config, axes.collect::<Result<_, _>>()?, start, epoch)
    }

    /// Creates the node with sources of the caller's in place of those of its axes, in the order of the config.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn moved_by(
        config: &SenderConfig,
        sources: impl Iterator<Item = Box<dyn AxisSource>>,
        start: Instant<Local>,
        epoch: u64,
    ) -> Result<Self, Wrong> {
        let axes = config.axes.iter().zip(sources);
        let axes = axes.map(|(config, source)| Axis::of(SourceAxis::with(config, source)));
        Self::with_axes(config, axes.collect(), start, epoch)
    }

    fn with_axes(
        config: &SenderConfig,
        mut axes: Vec<Axis>,
        start: Instant<Local>,
        epoch: u64,
    ) -> Result<Self, Wrong> {
        // Receivers look axes up by id, and the trace has them in this order.
        axes.sort_by_key(|axis| axis.source.id());
        check_presentation(config)?;
        check_followers(config)?;
        check_common_time(config)?;
        // After sorting, which moves the axes.
        place_shown(&mut axes, config)?;
        let mut snapshot = SenderSnapshot::new(config, start);
        snapshot.signals.node.run = epoch;
        // Messages come with the number of their subscription.
        let source = |subscription: &Subscription| match subscription.channel {
            Channel::Followers => Source::Follower(subscription.far),
            Channel::BeaconRequests => Source::Beacons,
            _ => Source::Requests,
        };
        let subscriptions = config.wiring().subscriptions;
        let cycle_time = config.cycle_time_us.0;
        let sender = sender_id(&config.name);
        let first = config.clock.first_count.get();
        let schedule = Schedule::counting_from(first, start, cycle_time);
        let plans = PlanPublisher::new(
            &config.axes,
            cycle_time.span(),
            start - schedule.start(),
            RunCycle {
                sender,
                epoch,
                count: first,
            },
        );
        Ok(Self {
            start,
            header: FrameHeader {
                sender,
                epoch,
                index: CycleIndex::of_count(first),
                count: first,
                cycle_time,
                present_after: None,
                send_stamp: None,
            },
            shown: vec![NcToPlcAxis::default(); axes.len()],
            // Sized once, because the cycle must not allocate.
            body: vec![0; body_capacity(axes.len())],
            axes,
            waiting: None,
            plans: plans.map(Box::new),
            // The start of cycle 0, which lies before the node's own start if counting begins later.
            time_server: TimeServer::new(sender, epoch, schedule.start(), cycle_time),
            beacon_server: BeaconServer::new(sender, epoch, schedule.start(), cycle_time),
            followers: FollowerWatch::new(config, epoch).map(Box::new),
            delay: (config.axes.present_after())
                .map(|range| StatedDelay::new(range, cycle_time.span())),
            sources: subscriptions.iter().map(source).collect(),
            schedule,
            snapshot,
        })
    }

    /// The axes in the newest frame, in the order of their ids.
    #[must_use]
    pub fn axes(&self) -> &[NcToPlcAxis] {
        &self.shown
    }

    fn move_axes(&mut self, now: Instant<Local>) -> bool {
        let mut do_axes_stand = true;
        let since_start = now - self.start;
        self.judge_followers(now);
        let is_settled = self.delay.as_ref().is_none_or(StatedDelay::is_settled);
        for (axis, shown) in self.axes.iter_mut().zip(&mut self.shown) {
            let of_axis = |watch: &FollowerWatch| watch.of(axis.source.id());
            if let Some(mut followers) = self.followers.as_deref().and_then(of_axis) {
                followers.are_in_sync &= is_settled;
                axis.source.take_followers(since_start, &followers);
            }
            // At the ideal start, not at the late wake-up: receivers extrapolate from there.
            let sample = axis.source.at(since_start, shown);
            do_axes_stand &= sample.motion.velocity == 0.0 && sample.motion.acceleration == 0.0;
            if let Some(slot) = axis.slot {
                self.snapshot.signals.axes[slot] = signals_of(&sample);
            }
        }
        do_axes_stand
    }

    fn judge_followers(&mut self, now: Instant<Local>) {
        let Some(followers) = &mut self.followers else {
            return;
        };
        followers.judge(now);
        if let Some(delay) = &mut self.delay {
            delay.take_sync(now - self.snapshot.ideal_start, followers.are_in_sync());
        }
    }

    /// Leads the presentation delay to what the followers want.
    fn lead_delay(&mut self, now: Instant<Local>, do_axes_stand: bool) {
        let wanted = self
            .followers
            .as_ref()
            .and_then(|watch| watch.wanted_delay());
        let signals = &mut self.snapshot.signals.node;
        signals.wanted_present_after_us = wanted.map(Span::as_micros_f64);
        let Some(delay) = &mut self.delay else {
            return;
        };
        if delay.is_led() {
            delay.advance(now - self.snapshot.ideal_start, wanted, do_axes_stand);
        }
        self.header.present_after = delay.field();
        let stated = self.header.present_after.map(PresentAfter::span);
        signals.present_after_us = stated.map(Span::as_micros_f64);
    }

    fn plan(&mut self, tick: &Tick) {
        let Some(plans) = &mut self.plans else {
            return;
        };
        let axes = &self.axes;
        // In the order of their ids.
        let source_of = |id| {
            let place = axes.binary_search_by_key(&id, |axis| axis.source.id());
            place.ok().map(|place| &axes[place].source)
        };
        plans.encode(tick, tick.ideal_start - self.start, source_of);
        self.snapshot.signals.node.plans_published = plans.published;
    }

    fn encode(&mut self, tick: &Tick) {
        self.header.count = tick.count;
        self.header.index = CycleIndex::of_count(tick.count);
        let length = encode_body(&self.header, &self.shown, &mut self.body)
            .expect("the config bounds the axes and the body was made for them");
        self.waiting = Some(length);
    }

    fn show(&mut self, tick: &Tick, now: Instant<Local>) {
        self.snapshot.ideal_start = tick.ideal_start;
        self.snapshot.woke = now;
        let signals = &mut self.snapshot.signals.node;
        signals.cycle = tick.count;
        signals.index = self.header.index.0;
        signals.overruns = self.schedule.overruns();
        let TimeServerCounters { answered, dropped } = self.time_server.counters();
        signals.requests_answered = answered;
        signals.requests_dropped = dropped;
        let BeaconServerCounters {
            answered,
            dropped,
            refused,
        } = self.beacon_server.counters();
        signals.beacons_answered = answered;
        signals.beacons_dropped = dropped;
        signals.beacons_refused = refused;
        self.show_followers();
    }

    fn show_followers(&mut self) {
        let Some(watch) = &self.followers else {
            return;
        };
        let conditions = &mut self.snapshot.followers;
        for (shown, condition) in conditions.iter_mut().zip(watch.conditions()) {
            *shown = condition;
        }
        let count = |is: fn(&FollowerCondition) -> bool| {
            conditions.iter().filter(|it| is(it)).count() as u32
        };
        let signals = &mut self.snapshot.signals.node;
        signals.followers_in_sync = count(|it| *it == FollowerCondition::InSync);
        signals.followers_failed = count(|it| it.is_failure());
        let held = self.axes.iter().filter(|axis| axis.source.is_held());
        signals.axes_held = held.count() as u32;
    }
}

impl Node for Sender {
    type Snapshot = SenderSnapshot;

    /// Takes time requests, beacons and reports of followers: a sender follows no node, but its clock is requested.
    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>) {
        match (message, self.sources.get(subscription)) {
            (Message::TimeRequest(request), _) => self.time_server.receive(at, request),
            (Message::BeaconRequest(request), _) => self.beacon_server.receive(at, request),
            (Message::FollowerReport(report), Some(Source::Follower(node))) => {
                if let Some(followers) = &mut self.followers {
                    followers.store(at, *node, report);
                }
            }
            (Message::Rejected(_), Some(Source::Beacons)) => self.beacon_server.reject(),
            (Message::Rejected(_), Some(Source::Follower(_))) => {
                let refused = &mut self.snapshot.signals.node.reports_refused;
                *refused = refused.saturating_add(1);
            }
            (Message::Rejected(_), _) => {
                let refused = &mut self.snapshot.signals.node.requests_refused;
                *refused = refused.saturating_add(1);
            }
            // No subscription brings others.
            (
                Message::Frame(_)
                | Message::TimeResponse(_)
                | Message::BeaconResponse(_)
                | Message::PlannedPiece(_)
                | Message::PlanRefused(_)
                | Message::FollowerReport(_),
                _,
            ) => {}
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        let tick = self.schedule.take(now);
        // Skipped cycles are in the difference: after a stall the axis is where time has taken it.
        let do_axes_stand = self.move_axes(tick.ideal_start);
        self.lead_delay(tick.ideal_start, do_axes_stand);
        self.encode(&tick);
        self.plan(&tick);
        // After the axes: the response must not delay them, and carries its own time.
        self.time_server.respond(&tick, now);
        self.beacon_server.respond(&tick, now);
        // Last, so that the counters are those after this cycle.
        self.show(&tick, now);
        tick
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        // The frame of axes leaves before all others: responses may be many, and plans have time.
        let ideal_start = self.snapshot.ideal_start;
        if let Some(length) = self.waiting.take() {
            return Some(Outgoing {
                channel: Channel::Axes,
                far: 0,
                ideal_start,
                body: &self.body[..length],
            });
        }
        let responses = self.time_server.transmit();
        responses
            .or_else(|| self.beacon_server.transmit())
            .or_else(|| self.plans.as_mut()?.transmit(ideal_start))
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.schedule.next_start()
    }

    fn snapshot(&self) -> &SenderSnapshot {
        &self.snapshot
    }

    fn snapshot_size(&self) -> usize {
        self.snapshot.size()
    }
}

impl Axis {
    fn new(axis: usize, config: &AxisConfig) -> Result<Self, Wrong> {
        let field = || format!("axis[{axis}].replay.file");
        let source =
            SourceAxis::open_ahead(config).map_err(|error| Wrong::with_reason(field(), error))?;
        Ok(Self::of(source))
    }

    const fn of(source: SourceAxis) -> Self {
        Self { source, slot: None }
    }
}

/// Checks that the axes are shown after the end of their cycle at the earliest: what is shown sooner is predicted.
fn check_presentation(config: &SenderConfig) -> Result<(), Wrong> {
    let cycle = config.cycle_time_us.0.span();
    match config.axes.present_after() {
        // One of "auto" begins with the cycle time.
        Some(range) if range.most < cycle => {
            let [most, cycle] = [range.most, cycle].map(|time| time.as_micros_f64() / 1e3);
            let expected = format!("the cycle time or more, {cycle} ms");
            Err(Wrong::of("present-after-ms", most, expected).within("axis[0]"))
        }
        _ => Ok(()),
    }
}

/// Checks that a common time has a channel on which it is stated.
fn check_common_time(config: &SenderConfig) -> Result<(), Wrong> {
    match (&config.time, &config.timing) {
        (Some(_), None) => Err(Wrong::of(
            "time",
            "one without `timing`",
            "`timing.listen` with the UDP address on which followers ask for it",
        )),
        _ => Ok(()),
    }
}

/// Checks that the sender is no follower of its own: it reports nothing.
fn check_followers(config: &SenderConfig) -> Result<(), Wrong> {
    for (n, axis) in config.axes.iter().enumerate() {
        let nodes = axis.followers.iter().flat_map(|followers| &followers.nodes);
        let mut nodes = nodes.enumerate();
        if let Some((k, node)) = nodes.find(|(_, node)| **node == config.name) {
            let received = format!("{:?}, the node itself", node.as_str());
            let wrong = Wrong::of(format!("followers.nodes[{k}]"), received, "receivers");
            return Err(wrong.within(format_args!("axis[{n}]")));
        }
    }
    Ok(())
}

/// Assigns the axes to be shown their places in the snapshot.
fn place_shown(axes: &mut [Axis], config: &SenderConfig) -> Result<(), Wrong> {
    let is_there = |id: &NonZeroU32| axes.iter().any(|axis| axis.source.id() == id.get());
    // Refused at the start: an axis that is never shown would look like a fault in the status.
    if let Some(missing) = config.show_axes.ids().iter().find(|id| !is_there(id)) {
        let known: Vec<_> = axes.iter().map(|axis| axis.source.id()).collect();
        let expected = format!("ids of the sender's axes: {known:?}");
        return Err(Wrong::of(
            "show-axes",
            format_args!("id {missing}"),
            expected,
        ));
    }
    for (slot, shown) in config.shown_axes().enumerate() {
        let axis = axes
            .iter_mut()
            .find(|axis| axis.source.id() == shown.id.get());
        if let Some(axis) = axis {
            axis.slot = Some(slot);
        }
    }
    Ok(())
}

fn signals_of(sample: &SourceSample) -> AxisSignals {
    let Kinematics {
        position,
        velocity,
        acceleration,
    } = sample.motion;
    AxisSignals {
        position,
        velocity,
        acceleration,
    }
}
