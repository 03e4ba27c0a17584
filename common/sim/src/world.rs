//! Nodes on drifting clocks, links between them, one event queue.

mod outages;

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::{LinkConfig, Wrong};
use coaxle_node::faults::{CycleJitter, DeviatedClock, seed_of};
use coaxle_node::{CommandOrder, KeptMessage, Message, Node};

use crate::common_time::SimulatedCommonTime;
use crate::events::EventQueue;
use crate::invariants::{Violation, Watch};
use crate::link::{Link, LinkDeparture};
use crate::network::{Network, RouterTraffic, Transit};
use crate::observer::{CycleSeen, Observer};
use crate::setup::{Factory, LinkSetup, NodeSetup, RouterSetup};
use crate::traffic::Traffic;
use crate::true_time::True;

/// Nodes and links in true time, which flows from event to event.
pub struct World<N> {
    now: Instant<True>,
    queue: EventQueue<WorldEvent>,
    nodes: Vec<SimulatedNode<N>>,
    links: Vec<Link>,
    /// Links of each node as a sender, in order.
    links_of: Vec<Vec<usize>>,
    network: Network,
    /// The frame under way from a node to its links.
    frame: Vec<u8>,
    /// Buffers for messages under way.
    spare: SpareMessages,
    /// Messages delivered to a node, and dropped.
    delivered: u64,
    dropped: u64,
}

/// Boxed and recycled, so that moving an event is cheap.
type SpareMessages = Vec<Box<KeptMessage>>;

struct SimulatedNode<N> {
    name: String,
    clock: DeviatedClock<True>,
    jitter: CycleJitter,
    start_phase: Span,
    send_stamps: bool,
    common_time: Option<SimulatedCommonTime>,
    build: Factory<N>,
    state: SimulatedState<N>,
    /// Orders that wait for its next cycle, with their numbers.
    orders: Vec<(usize, CommandOrder)>,
    /// Number of starts.
    run: u64,
    /// Number of scheduled cycles: only the event of the last one counts.
    scheduled: u64,
    /// End of the delivery of its backlog; messages sent meanwhile wait behind it.
    drained_at: Instant<True>,
    watch: Watch,
}

enum SimulatedState<N> {
    Running(N),
    /// Frozen, with the waiting messages and their links.
    Stopped(N, Vec<(usize, Box<KeptMessage>)>),
    Dead,
}

enum WorldEvent {
    Cycle {
        node: usize,
        scheduled: u64,
    },
    Deliver {
        link: usize,
        message: Box<KeptMessage>,
    },
    /// A message that waited for a node that was frozen.
    Drain {
        link: usize,
        message: Box<KeptMessage>,
    },
    Hop(Transit),
}

impl<N: Node> Default for World<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<N: Node> World<N> {
    /// An empty world at true time zero.
    #[must_use]
    pub fn new() -> Self {
        Self {
            now: Instant::EPOCH,
            queue: EventQueue::new(),
            nodes: Vec::new(),
            links: Vec::new(),
            links_of: Vec::new(),
            network: Network::default(),
            frame: Vec::new(),
            spare: Vec::new(),
            delivered: 0,
            dropped: 0,
        }
    }

    /// Adds a node to the world, starts it and returns its number.
    ///
    /// # Errors
    /// [`Wrong`]: a file that its clock's drift names cannot be used.
    pub fn add_node(&mut self, setup: NodeSetup<N>) -> Result<usize, Wrong> {
        // Streams of their own: a draw more of the jitter leaves the clock's drift as it was.
        let clock_seed = seed_of(setup.seed, "clock");
        let jitter_seed = seed_of(setup.seed, "jitter");
        self.nodes.push(SimulatedNode {
            clock: DeviatedClock::new(&setup.clock, clock_seed, self.now)?,
            jitter: CycleJitter::new(&setup.clock, jitter_seed),
            start_phase: setup.clock.start_phase(),
            common_time: (setup.common_time.as_ref()).map(|config| {
                let seed = seed_of(setup.seed, "common time");
                SimulatedCommonTime::new(config, &setup.clock, seed)
            }),
            name: setup.name,
            send_stamps: setup.send_stamps,
            build: setup.build,
            state: SimulatedState::Dead,
            orders: Vec::new(),
            run: 0,
            scheduled: 0,
            drained_at: Instant::EPOCH,
            watch: Watch::default(),
        });
        self.links_of.push(Vec::new());
        let node = self.nodes.len() - 1;
        self.start(node);
        Ok(node)
    }

    /// Adds a router to the world; returns its number, which counts only routers.
    pub fn add_router(&mut self, setup: RouterSetup) -> usize {
        self.network.add_router(setup)
    }

    /// Connects two routers by a link with this behaviour in both directions, with a seed for each.
    ///
    /// # Errors
    /// [`Wrong`]: a file that its delay names cannot be used.
    pub fn connect_routers(
        &mut self,
        routers: [usize; 2],
        link: &LinkConfig,
        seeds: [u64; 2],
    ) -> Result<(), Wrong> {
        self.network.connect_routers(routers, link, seeds)
    }

    /// Puts a node behind a router, over a link with this behaviour in both directions, with a seed
    /// for each. Links between two such nodes that are added afterwards lead over routers, except
    /// those of beacons.
    ///
    /// # Errors
    /// [`Wrong`]: a file that its delay names cannot be used.
    pub fn place_behind(
        &mut self,
        node: usize,
        router: usize,
        link: &LinkConfig,
        seeds: [u64; 2],
    ) -> Result<(), Wrong> {
        self.network.place(node, router, link, seeds)
    }

    /// Connects a subscriber.
    ///
    /// # Errors
    /// [`Wrong`]: a file that its delay names cannot be used.
    pub fn add_link(&mut self, setup: LinkSetup) -> Result<(), Wrong> {
        let (from, channel, far, to) = (setup.from, setup.channel, setup.far, setup.to);
        let mut link = Link::new(setup)?;
        let number = self.links.len();
        link.flow = self.network.flow_of((from, channel, far), number, to);
        self.links.push(link);
        self.links_of[from].push(number);
        // A node may skip the encoding of a channel that has no subscriber.
        if let Some(node) = self.node_mut(from) {
            node.set_subscribed(channel, true);
        }
        Ok(())
    }

    /// True time now.
    #[must_use]
    pub const fn now(&self) -> Instant<True> {
        self.now
    }

    /// A node, unless it is dead.
    #[must_use]
    pub fn node(&self, index: usize) -> Option<&N> {
        match &self.nodes[index].state {
            SimulatedState::Running(node) | SimulatedState::Stopped(node, _) => Some(node),
            SimulatedState::Dead => None,
        }
    }

    fn node_mut(&mut self, index: usize) -> Option<&mut N> {
        match &mut self.nodes[index].state {
            SimulatedState::Running(node) | SimulatedState::Stopped(node, _) => Some(node),
            SimulatedState::Dead => None,
        }
    }

    /// The reading of a node's clock now.
    pub fn local_now(&mut self, index: usize) -> Instant<Local> {
        self.nodes[index].clock.local_at(self.now)
    }

    /// The drift of a node's clock against true time now, ppm.
    #[must_use]
    pub fn drift_ppm(&self, index: usize) -> f64 {
        self.nodes[index].clock.drift_ppm()
    }

    /// Counts of all messages since the start.
    #[must_use]
    pub fn traffic(&self) -> Traffic {
        let is_message = |event: &&WorldEvent| !matches!(event, WorldEvent::Cycle { .. });
        let waiting = self.nodes.iter().map(|node| match &node.state {
            SimulatedState::Stopped(_, waiting) => waiting.len() as u64,
            SimulatedState::Running(_) | SimulatedState::Dead => 0,
        });
        let mut traffic = Traffic {
            delivered: self.delivered,
            dropped: self.dropped,
            waiting: waiting.sum::<u64>() + self.network.waiting(),
            under_way: self.queue.iter().filter(is_message).count() as u64,
            ..Traffic::default()
        };
        self.network.counts.add_to(&mut traffic);
        for link in &self.links {
            link.counts.add_to(&mut traffic);
        }
        traffic
    }

    /// Traffic of each router since the start, in insertion order.
    #[must_use]
    pub fn router_traffic(&self) -> Vec<RouterTraffic> {
        self.network.traffic()
    }

    /// Lets true time flow until `end`.
    ///
    /// # Errors
    /// [`Violation`] when a node breaks its contract.
    pub fn run_until(
        &mut self,
        end: Instant<True>,
        observer: &mut impl Observer<N>,
    ) -> Result<(), Violation> {
        // An event exactly at the end belongs to the next call: each event runs once, however a run is divided.
        while self.queue.next_at().is_some_and(|at| at < end) {
            let Some((at, event)) = self.queue.pop() else {
                break;
            };
            self.now = at;
            match event {
                WorldEvent::Cycle { node, scheduled } => self.cycle(node, scheduled, observer)?,
                WorldEvent::Deliver { link, message } => self.deliver(link, message),
                WorldEvent::Drain { link, message } => self.give(link, message),
                WorldEvent::Hop(transit) => self.hop(transit),
            }
        }
        // Time passes even without events.
        self.now = end;
        Ok(())
    }

    /// Sends an order to one of a node's slaves, for execution in the node's next cycle, unless the
    /// node is dead.
    pub fn order(&mut self, node: usize, number: usize, order: CommandOrder) {
        let simulated = &mut self.nodes[node];
        if !matches!(simulated.state, SimulatedState::Dead) {
            simulated.orders.push((number, order));
        }
    }

    fn schedule(&mut self, node: usize) {
        let simulated = &mut self.nodes[node];
        if let SimulatedState::Running(running) = &simulated.state {
            let wake = running.next_cycle() + simulated.jitter.next();
            // A node that was frozen is due in the past, and true time does not run back.
            let at = simulated.clock.reference_at(wake).max(self.now);
            // An event in the queue cannot be withdrawn; the number makes an older one void.
            simulated.scheduled += 1;
            let scheduled = simulated.scheduled;
            self.queue.add(at, WorldEvent::Cycle { node, scheduled });
        }
    }

    fn cycle(
        &mut self,
        index: usize,
        scheduled: u64,
        observer: &mut impl Observer<N>,
    ) -> Result<(), Violation> {
        let now = self.now;
        let simulated = &mut self.nodes[index];
        let SimulatedState::Running(node) = &mut simulated.state else {
            return Ok(());
        };
        // A node stopped and resumed within one cycle would otherwise have two.
        if scheduled != simulated.scheduled {
            return Ok(());
        }
        let local = simulated.clock.local_at(now);
        for (number, order) in simulated.orders.drain(..) {
            // Before the cycle, so that an order acts in the one that follows it.
            observer.order_executed(number, &node.execute(&order));
        }
        let tick = node.cycle(local);
        simulated.watch.check(&simulated.name, node, tick, local)?;
        while let Some(outgoing) = node.transmit() {
            let stamped = simulated.send_stamps;
            let common_time = (simulated.common_time.as_mut())
                .filter(|_| outgoing.channel.is_timing())
                .and_then(|common| common.read(now, local));
            let departure = LinkDeparture {
                left: local,
                stamped,
                common_time,
            };
            for &link in &self.links_of[index] {
                let by = &mut self.links[link];
                // A frame behind a router leaves its node once for all subscribers; the routers multiply it.
                let is_sent = by.flow.is_none_or(|flow| self.network.is_first(flow, link));
                if !(is_sent && by.takes(index, &outgoing)) {
                    continue;
                }
                let Some(frame) = by.seal(&outgoing, &departure, &mut self.frame) else {
                    continue;
                };
                let (queue, dropped) = (&mut self.queue, &mut self.dropped);
                if let Some(flow) = by.flow {
                    let mut on_its_way =
                        |at, transit| add(queue, dropped, at, WorldEvent::Hop(transit));
                    self.network.publish(now, flow, frame, &mut on_its_way);
                    continue;
                }
                let spare = &mut self.spare;
                by.send(now, frame, |at, message| {
                    deliver_later(queue, dropped, spare, at, link, message);
                });
            }
        }
        // The ideal start, not the actual one: truth is judged without the jitter of waking.
        let ideal_start = simulated.clock.reference_at(tick.ideal_start);
        while let Some(arrival) = node.arrival() {
            observer.arrived(index, ideal_start, &tick, &arrival);
        }
        observer.cycle_seen(&CycleSeen {
            index,
            node,
            tick,
            ideal_start,
            woke: now,
        });
        // Last, because only the finished cycle decides on the start of the next one.
        self.schedule(index);
        Ok(())
    }

    fn hop(&mut self, transit: Transit) {
        let (nodes, queue, dropped) = (&self.nodes, &mut self.queue, &mut self.dropped);
        let lives = |node: usize| !matches!(nodes[node].state, SimulatedState::Dead);
        let mut on_its_way = |at, transit| add(queue, dropped, at, WorldEvent::Hop(transit));
        let arrived = self
            .network
            .arrive(self.now, transit, lives, &mut on_its_way);
        let Some((node, flow, frame)) = arrived else {
            return;
        };
        let (queue, dropped, spare) = (&mut self.queue, &mut self.dropped, &mut self.spare);
        let mut messages = 0;
        for link in self.network.links_to(flow, node) {
            messages += 1;
            self.links[link].pass_on(self.now, &frame, |at, message| {
                deliver_later(queue, dropped, spare, at, link, message);
            });
        }
        self.network.counts.became(messages);
    }

    fn deliver(&mut self, link: usize, message: Box<KeptMessage>) {
        let until = self.nodes[self.links[link].to].drained_at;
        // Behind a backlog that is still being delivered.
        if self.now < until {
            self.queue.add(until, WorldEvent::Drain { link, message });
        } else {
            self.give(link, message);
        }
    }

    fn give(&mut self, link: usize, message: Box<KeptMessage>) {
        let now = self.now;
        let Link {
            to, subscription, ..
        } = self.links[link];
        let simulated = &mut self.nodes[to];
        match &mut simulated.state {
            SimulatedState::Running(node) => {
                let at = simulated.clock.local_at(now);
                node.receive(at, subscription, &message.get());
                self.spare.push(message);
                self.delivered += 1;
            }
            SimulatedState::Stopped(_, waiting) if waiting.len() < MOST_WAITING => {
                waiting.push((link, message));
            }
            SimulatedState::Stopped(..) | SimulatedState::Dead => {
                self.spare.push(message);
                self.dropped += 1;
            }
        }
    }
}

/// Greatest number of messages that wait for a frozen node: no socket holds more, and further ones
/// are lost.
const MOST_WAITING: usize = 50_000;

/// Greatest number of messages under way at once: no network holds more, and further ones are lost.
const MOST_UNDER_WAY: usize = 200_000;

/// Adds an event under way, unless there are too many.
fn add(
    queue: &mut EventQueue<WorldEvent>,
    dropped: &mut u64,
    at: Instant<True>,
    event: WorldEvent,
) {
    if queue.len() >= MOST_UNDER_WAY {
        *dropped += 1;
    } else {
        queue.add(at, event);
    }
}

fn deliver_later(
    queue: &mut EventQueue<WorldEvent>,
    dropped: &mut u64,
    spare: &mut SpareMessages,
    at: Instant<True>,
    link: usize,
    message: &Message<'_>,
) {
    // Checked before the copy: a flood must not cost memory.
    if queue.len() >= MOST_UNDER_WAY {
        *dropped += 1;
        return;
    }
    let message = kept(message, spare);
    queue.add(at, WorldEvent::Deliver { link, message });
}

/// Copies the message, into a recycled buffer if there is one.
fn kept(message: &Message<'_>, spare: &mut SpareMessages) -> Box<KeptMessage> {
    match spare.pop() {
        Some(mut kept) => {
            kept.replace(message);
            kept
        }
        None => Box::new(KeptMessage::new(message)),
    }
}
