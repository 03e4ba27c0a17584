//! A scenario in the simulation: virtual time, as fast as it goes.

use anyhow::Context;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::command::OrderCargo;
use coaxle_node::config::LinkConfig;
use coaxle_node::faults::seed_of;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{self, Subscription, far_link_seed};
use coaxle_node::{
    Arrival, Channel, CommandAnswer, CommandOrder, CommandOutcome, Message, Node, Outgoing,
};
use coaxle_receiver::{Drives, Receiver, ReceiverConfig};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;
use coaxle_sim::{CycleSeen, LinkSetup, NodeSetup, Observer, RouterSetup, True, World};

use crate::evaluate::{Evaluation, truth_of};
use crate::event::{Event, EventKind};
use crate::finished::{Finished, Progress};
use crate::layout::ScenarioLayout;
use crate::row::RowSink;
use crate::scenario::Scenario;
use crate::summary;
use crate::timeline::{ChangeKind, ChangeTarget, changes_of};
use crate::topology::Topology;
use crate::verdict::Verdict;

/// Runs a checked scenario in virtual time.
///
/// # Errors
/// A node that cannot be built, or that breaks its contract.
pub fn run(
    scenario: &Scenario,
    sink: &mut impl RowSink,
    progress: &mut dyn Progress,
) -> anyhow::Result<Finished> {
    let topology = Topology::of(scenario).map_err(|wrong| wrong.in_file("scenario"))?;
    let mut world = populate(scenario, &topology)?;
    let mut watcher = RunObserver {
        senders: scenario.senders.len(),
        receivers: scenario.receivers.len(),
        evaluation: Evaluation::new(scenario, &topology, summary::World::Virtual, Instant::EPOCH),
        sink,
        outcomes: vec![None; scenario.events.len()],
    };
    let end = Instant::EPOCH + Span::from_secs_f64(scenario.duration_s.get());
    let mut is_whole = true;
    for change in changes_of(scenario, &topology) {
        // Events behind the end happen at the end, where no cycle shows them any more.
        let at = (Instant::EPOCH + change.at).min(end);
        is_whole = run_in_steps(&mut world, at, &mut watcher, progress, end)?;
        if !is_whole {
            break;
        }
        match change.target {
            ChangeTarget::Node(node) => happen(&mut world, scenario, node, change.what),
            ChangeTarget::Router(router) => happen_to_router(&mut world, router, change.what),
        }
    }
    let is_whole = is_whole && run_in_steps(&mut world, end, &mut watcher, progress, end)?;
    let interrupted_at = (!is_whole).then(|| world.now().since_epoch().as_secs_f64());
    let commands = judge_commands(scenario, &watcher.outcomes);
    let routers = world.router_traffic();
    let RunObserver {
        evaluation, sink, ..
    } = watcher;
    let finished = Finished::new(evaluation.finish(sink)).with_commands(commands);
    let finished = finished.with_routers(routers);
    Ok(finished.interrupted_at(interrupted_at))
}

fn happen(world: &mut World<AnyNode>, scenario: &Scenario, node: usize, what: ChangeKind) {
    match what {
        ChangeKind::Kill => world.kill(node),
        ChangeKind::Start => world.start(node),
        ChangeKind::Stop => world.stop(node),
        ChangeKind::Resume => world.resume(node),
        ChangeKind::ResumeInPieces => world.resume_in_pieces(node),
        ChangeKind::Command(event) => {
            if let EventKind::Command(commanded) = &scenario.events[event].what {
                world.order(node, event, commanded.order.clone());
            }
        }
    }
}

fn happen_to_router(world: &mut World<AnyNode>, router: usize, what: ChangeKind) {
    match what {
        ChangeKind::Kill => world.kill_router(router),
        ChangeKind::Start => world.start_router(router),
        ChangeKind::Stop => world.stop_router(router),
        ChangeKind::Resume | ChangeKind::ResumeInPieces => world.resume_router(router),
        // The scenario was refused.
        ChangeKind::Command(_) => {}
    }
}

fn judge_commands(scenario: &Scenario, outcomes: &[Option<CommandOutcome>]) -> Vec<Verdict> {
    let judge = |(event, outcome): (&Event, &Option<CommandOutcome>)| {
        let EventKind::Command(commanded) = &event.what else {
            return None;
        };
        let answer = outcome.map(|outcome| CommandAnswer::new(&commanded.order, &outcome));
        Some(commanded.judge(event, answer.as_ref()))
    };
    scenario
        .events
        .iter()
        .zip(outcomes)
        .filter_map(judge)
        .collect()
}

fn populate(scenario: &Scenario, topology: &Topology) -> anyhow::Result<World<AnyNode>> {
    let mut world = World::new();
    for config in &scenario.senders {
        world.add_node(sender(scenario, config)?)?;
    }
    for config in &scenario.receivers {
        world.add_node(receiver(scenario, config)?)?;
    }
    for name in scenario.twins() {
        let senders = scenario.senders.iter();
        let mut setup = match senders.clone().find(|config| config.name == *name) {
            Some(config) => sender(scenario, config)?,
            None => {
                let mut receivers = scenario.receivers.iter();
                let config = receivers.find(|config| config.name == *name);
                receiver(scenario, config.context("a twin of no node")?)?
            }
        };
        // Otherwise it would draw the jitter of its original.
        setup.seed = seed_of(setup.seed, TWIN);
        let build = setup.build;
        setup.build = Box::new(move |start, run| build(start, FIRST_RUN_OF_TWIN + run));
        let twin = world.add_node(setup)?;
        // Until its event.
        world.kill(twin);
    }
    let layout =
        ScenarioLayout::of(scenario, topology).map_err(|wrong| wrong.in_file("scenario"))?;
    place_routers(&mut world, scenario, topology, &layout)?;
    connect(&mut world, scenario)?;
    Ok(world)
}

/// Places the routers, their connections, and every node behind one; a duplicate behind that of its original.
fn place_routers(
    world: &mut World<AnyNode>,
    scenario: &Scenario,
    topology: &Topology,
    layout: &ScenarioLayout,
) -> anyhow::Result<()> {
    let routers = &scenario.routers;
    for config in routers {
        // 8 bits at 1e-3 bit/ns for each Mbit/s.
        let ns_per_byte = config.mbit_s.map_or(0.0, |rate| 8_000.0 / rate.get());
        world.add_router(RouterSetup {
            name: config.name.to_string(),
            forwarding: config.forward_us.span(),
            ns_per_byte,
            longest_queue: config.queue_us.span(),
        });
    }
    let seeds = |one: &NodeName, other: &NodeName| {
        // A seed for each direction: losses there and back are independent.
        let seed = |from, to| seed_of(scenario.seed, &format!("hop {from} {to}"));
        [seed(one, other), seed(other, one)]
    };
    for [from, to] in layout.connected.iter().copied() {
        let link = routers[from].link.as_ref().unwrap_or(&scenario.network);
        let seeds = seeds(&routers[from].name, &routers[to].name);
        world.connect_routers([from, to], link, seeds)?;
    }
    let twins = scenario.twins();
    let twins = twins.iter().filter_map(|name| topology.node(name));
    for (node, original) in (0..layout.behind.len()).chain(twins).enumerate() {
        let Some(router) = layout.behind.get(original).copied() else {
            continue;
        };
        // A duplicate stands behind the router of its original, with faults drawn apart.
        let [up, down] = seeds(&topology.names()[original], &routers[router].name);
        let is_twin = node >= layout.behind.len();
        let seeds = [up, down].map(|seed| if is_twin { seed_of(seed, TWIN) } else { seed });
        world.place_behind(node, router, &scenario.network, seeds)?;
    }
    Ok(())
}

/// Seed part of duplicates' random numbers.
const TWIN: &str = "twin";

/// First run of a duplicate: no original is restarted so often, so their runs differ.
const FIRST_RUN_OF_TWIN: u64 = 1_000_000;

fn sender(scenario: &Scenario, config: &SenderConfig) -> anyhow::Result<NodeSetup<AnyNode>> {
    let config = config.clone();
    // Build once for the error; the factory cannot fail any more.
    Sender::new(&config, Instant::EPOCH, 0)?;
    Ok(NodeSetup {
        name: config.name.to_string(),
        seed: scenario.seed_of(&config.name),
        clock: config.clock.clone(),
        common_time: config.time.clone(),
        send_stamps: config.send_stamps,
        build: Box::new(move |start, run| {
            let sender = Sender::new(&config, start, run).expect("was built before");
            AnyNode::Sender(Box::new(sender))
        }),
    })
}

fn receiver(scenario: &Scenario, config: &ReceiverConfig) -> anyhow::Result<NodeSetup<AnyNode>> {
    let config = config.clone();
    Receiver::with_drives(&config, Drives::simulated(), Instant::EPOCH, 0)?;
    Ok(NodeSetup {
        name: config.name.to_string(),
        seed: scenario.seed_of(&config.name),
        clock: config.clock.clone(),
        common_time: config.time.clone(),
        send_stamps: true,
        build: Box::new(move |start, run| {
            let drives = Drives::simulated();
            let receiver =
                Receiver::with_drives(&config, drives, start, run).expect("was built before");
            AnyNode::Receiver(Box::new(receiver))
        }),
    })
}

/// Connects every two nodes by their wiring, by which real processes subscribe, too.
fn connect(world: &mut World<AnyNode>, scenario: &Scenario) -> anyhow::Result<()> {
    let wirings = scenario.wirings();
    let first_twin = scenario.senders.len() + scenario.receivers.len();
    for way in wiring::links(&wirings) {
        let (from, to) = (&wirings[way.from], &wirings[way.to]);
        let publication = &from.publications[way.publication];
        let subscription = &to.subscriptions[way.subscription];
        let Subscription {
            node,
            channel,
            reader,
            ..
        } = subscription;
        // The follower lays its faults over the link, in either direction.
        let (follower, faults, far) = match channel {
            Channel::TimeRequests | Channel::BeaconRequests | Channel::Followers => {
                (&from.node, &publication.faults, publication.far)
            }
            _ => (&to.node, &subscription.faults, subscription.far),
        };
        let seed = |part| {
            let seed = far_link_seed(scenario.seed_of(follower), part, *channel, far);
            if way.from.max(way.to) < first_twin {
                seed
            } else {
                seed_of(seed, TWIN)
            }
        };
        let network = match channel.is_timing() {
            true => scenario.timing_network.clone(),
            false if scenario.routers.is_empty() => scenario.network.clone(),
            // With routers the other faults apply on each hop, by the behaviour of the hops.
            false => content_faults(&scenario.network),
        };
        world.add_link(LinkSetup {
            from: way.from,
            channel: *channel,
            far: publication.far,
            key: node.channel_key(*channel),
            to: way.to,
            subscription: way.subscription,
            reader: reader.clone(),
            // Seeds of their own: faults of the link leave those of the network as they are.
            behaviour: vec![(network, seed("network")), (faults.clone(), seed("link"))],
        })?;
    }
    Ok(())
}

/// Faults of a network in the content of messages, which apply once however many hops there are. All other faults apply on each
/// hop.
fn content_faults(network: &LinkConfig) -> LinkConfig {
    LinkConfig {
        corruption: network.corruption,
        forgeries: network.forgeries.clone(),
        faults_until_s: network.faults_until_s,
        ..LinkConfig::default()
    }
}

/// Runs up to `until`; false if interrupted before.
fn run_in_steps<S: RowSink>(
    world: &mut World<AnyNode>,
    until: Instant<True>,
    watcher: &mut RunObserver<'_, S>,
    progress: &mut dyn Progress,
    end: Instant<True>,
) -> anyhow::Result<bool> {
    while world.now() < until {
        // In steps, as a run of hours without events has to be shown, and may be ended.
        let next = (world.now() + PROGRESS_STEP).min(until);
        world.run_until(next, watcher)?;
        let done = next.since_epoch().as_secs_f64() / end.since_epoch().as_secs_f64();
        if !progress.at(done) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Virtual time between two updates of the progress.
const PROGRESS_STEP: Span = Span::from_secs(1);

struct RunObserver<'a, S> {
    senders: usize,
    receivers: usize,
    evaluation: Evaluation,
    sink: &'a mut S,
    /// Outcomes of the commands among the scenario's events.
    outcomes: Vec<Option<CommandOutcome>>,
}

impl<S> RunObserver<'_, S> {
    /// True for a duplicate node, which is not observed.
    const fn is_twin(&self, index: usize) -> bool {
        index >= self.senders + self.receivers
    }
}

impl<S: RowSink> Observer<AnyNode> for RunObserver<'_, S> {
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, AnyNode>) {
        if self.is_twin(seen.index) {
            return;
        }
        let at_ns = seen.ideal_start.as_nanos();
        match seen.node {
            AnyNode::Sender(sender) => {
                let snapshot = sender.snapshot();
                let node = &snapshot.signals.node;
                self.evaluation.push_sender(seen.index, node);
                for (id, axis) in snapshot.axes() {
                    let sample = truth_of(at_ns, node, axis);
                    self.evaluation.push_master(seen.index, id, sample);
                }
            }
            AnyNode::Receiver(receiver) => {
                let (number, woke_ns) = (seen.index - self.senders, seen.woke.as_nanos());
                let signals = &receiver.snapshot().signals;
                self.evaluation
                    .push_receiver(number, at_ns, woke_ns, signals, self.sink);
            }
        }
    }

    fn arrived(
        &mut self,
        index: usize,
        ideal_start: Instant<True>,
        tick: &Tick,
        arrival: &Arrival,
    ) {
        if self.is_twin(index) {
            return;
        }
        if let Some(receiver) = index.checked_sub(self.senders) {
            self.sink.arrived(receiver, ideal_start, tick, arrival);
        }
    }

    fn order_executed(&mut self, number: usize, outcome: &CommandOutcome) {
        // By the number of the event: orders under way at the end of the run have no outcome.
        self.outcomes[number] = Some(*outcome);
    }
}

/// A node of either kind, so that one world holds both.
enum AnyNode {
    Sender(Box<Sender>),
    Receiver(Box<Receiver>),
}

impl Node for AnyNode {
    /// The watcher reads the nodes themselves.
    type Snapshot = ();

    fn receive(&mut self, at: Instant<Local>, subscription: usize, message: &Message<'_>) {
        match self {
            Self::Sender(node) => node.receive(at, subscription, message),
            Self::Receiver(node) => node.receive(at, subscription, message),
        }
    }

    fn execute_with(&mut self, order: &CommandOrder, cargo: &mut OrderCargo) -> CommandOutcome {
        match self {
            Self::Sender(node) => node.execute_with(order, cargo),
            Self::Receiver(node) => node.execute_with(order, cargo),
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        match self {
            Self::Sender(node) => node.cycle(now),
            Self::Receiver(node) => node.cycle(now),
        }
    }

    fn set_subscribed(&mut self, channel: Channel, is_subscribed: bool) {
        match self {
            Self::Sender(node) => node.set_subscribed(channel, is_subscribed),
            Self::Receiver(node) => node.set_subscribed(channel, is_subscribed),
        }
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        match self {
            Self::Sender(node) => node.transmit(),
            Self::Receiver(node) => node.transmit(),
        }
    }

    fn arrival(&mut self) -> Option<Arrival> {
        match self {
            Self::Sender(node) => node.arrival(),
            Self::Receiver(node) => node.arrival(),
        }
    }

    fn next_cycle(&self) -> Instant<Local> {
        match self {
            Self::Sender(node) => node.next_cycle(),
            Self::Receiver(node) => node.next_cycle(),
        }
    }

    fn snapshot(&self) -> &() {
        &()
    }
}
