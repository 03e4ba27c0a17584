//! The world of a scenario: its nodes, routers and links, and what its events do to them.

use std::rc::Rc;

use anyhow::Context;
use coaxle_clock::{Instant, Local};
use coaxle_node::Channel;
use coaxle_node::config::LinkConfig;
use coaxle_node::faults::seed_of;
use coaxle_node::keys::NodeName;
use coaxle_node::wiring::{self, Subscription, far_link_seed};
use coaxle_receiver::{Drives, Receiver, ReceiverConfig};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;
use coaxle_sim::{LinkSetup, NodeSetup, RouterSetup, World};
use coaxle_source::AxisSource;

use super::any_node::AnyNode;
use crate::event::EventKind;
use crate::layout::ScenarioLayout;
use crate::scenario::Scenario;
use crate::timeline::{ChangeKind, ChangeTarget, NodeChange};
use crate::topology::Topology;

/// Motion of a sender's axes that is given from outside: the source for a start of the sender at this reading of its clock.
pub type GivenMotion = Rc<dyn Fn(Instant<Local>) -> Box<dyn AxisSource>>;

/// Builds the world of a scenario. `motion` moves the axes of its senders in place of their own sources, if there is one.
///
/// # Errors
/// A node that cannot be built.
pub(super) fn populate(
    scenario: &Scenario,
    topology: &Topology,
    motion: Option<&GivenMotion>,
) -> anyhow::Result<World<AnyNode>> {
    let mut world = World::new();
    for config in &scenario.senders {
        world.add_node(sender(scenario, config, motion)?)?;
    }
    for config in &scenario.receivers {
        world.add_node(receiver(scenario, config)?)?;
    }
    for name in scenario.twins() {
        let senders = scenario.senders.iter();
        let mut setup = match senders.clone().find(|config| config.name == *name) {
            Some(config) => sender(scenario, config, motion)?,
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

fn sender(
    scenario: &Scenario,
    config: &SenderConfig,
    motion: Option<&GivenMotion>,
) -> anyhow::Result<NodeSetup<AnyNode>> {
    let (config, motion) = (config.clone(), motion.cloned());
    let new = move |config: &SenderConfig, start, run| match &motion {
        None => Sender::new(config, start, run),
        Some(motion) => {
            let sources = config.axes.iter().map(|_| motion(start));
            Sender::moved_by(config, sources, start, run)
        }
    };
    // Build once for the error; the factory cannot fail any more.
    new(&config, Instant::EPOCH, 0)?;
    Ok(NodeSetup {
        name: config.name.to_string(),
        seed: scenario.seed_of(&config.name),
        clock: config.clock.clone(),
        common_time: config.time.clone(),
        send_stamps: config.send_stamps,
        build: Box::new(move |start, run| {
            let sender = new(&config, start, run).expect("was built before");
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

/// Lets an event of the scenario happen.
pub(super) fn apply(world: &mut World<AnyNode>, scenario: &Scenario, change: &NodeChange) {
    match change.target {
        ChangeTarget::Node(node) => happen(world, scenario, node, change.what),
        ChangeTarget::Router(router) => happen_to_router(world, router, change.what),
    }
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
