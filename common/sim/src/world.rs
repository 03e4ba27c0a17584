//! The world: nodes on drifting clocks, links between them, one event queue.

use coaxle_clock::cycle::Turn;
use coaxle_clock::{Domain, Instant, Local, Span};
use coaxle_node::config::{ClockConfig, LinkConfig};
use coaxle_node::faults::{CycleJitter, DeviatedClock, LinkModel, seed_of};
use coaxle_node::frame::KeySeal;
use coaxle_node::{Arrival, Channel, CommandOrder, CommandOutcome, Message, Node, Reader};

use crate::events::EventQueue;
use crate::invariants::{Violation, Watch};

/// True time, which only the world knows.
pub enum True {}

impl Domain for True {
    const NAME: &'static str = "true";
}

/// Builds a node whose first cycle is due at a local instant, in its n-th run.
pub type Factory<N> = Box<dyn Fn(Instant<Local>, u64) -> N>;

/// A node to put into the world.
pub struct NodeSetup<N> {
    /// Its name, for messages.
    pub name: String,
    /// Seed of everything random in it, as the real world would have it.
    pub seed: u64,
    /// Its clock.
    pub clock: ClockConfig,
    /// Whether its frames of axes say when they left.
    pub send_stamps: bool,
    /// Makes the node, at the start and after each restart.
    pub build: Factory<N>,
}

/// A link to put into the world: one subscription.
pub struct LinkSetup {
    /// Number of the node that publishes.
    pub from: usize,
    /// What it publishes.
    pub channel: Channel,
    /// The key that travels under.
    pub key: String,
    /// Number of the node that subscribes.
    pub to: usize,
    /// What the subscriber makes of it.
    pub reader: Reader,
    /// What the link does to messages, one behaviour after the other, and the seed of each.
    pub behaviour: Vec<(LinkConfig, u64)>,
}

/// One cycle of a node, as the world saw it.
#[derive(Debug)]
pub struct CycleSeen<'a, N> {
    /// Number of the node.
    pub index: usize,
    /// The node, after its cycle.
    pub node: &'a N,
    /// Which cycle it was.
    pub turn: Turn,
    /// When that ideally started, in true time.
    pub ideal_start: Instant<True>,
    /// When it really did.
    pub woke: Instant<True>,
}

/// Watches the world from outside.
pub trait Observer<N> {
    /// After every cycle of every node.
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, N>);

    /// After every cycle, before [`Self::cycle_seen`]: each thing that a node took in during the cycle
    /// `turn`, which ideally started at `ideal_start`.
    fn arrived(
        &mut self,
        index: usize,
        ideal_start: Instant<True>,
        turn: &Turn,
        arrival: &Arrival,
    ) {
        let _ = (index, ideal_start, turn, arrival);
    }

    /// After every order, with the number it was sent under.
    fn order_executed(&mut self, number: usize, outcome: &CommandOutcome) {
        let _ = (number, outcome);
    }
}

/// The pretend world.
pub struct World<N> {
    now: Instant<True>,
    queue: EventQueue<Event>,
    nodes: Vec<Inhabitant<N>>,
    links: Vec<Link>,
    /// The frame under way from a node to its links.
    frame: Vec<u8>,
}

struct Inhabitant<N> {
    name: String,
    clock: DeviatedClock<True>,
    jitter: CycleJitter,
    start_phase: Span,
    send_stamps: bool,
    build: Factory<N>,
    state: State<N>,
    /// The orders that wait for its next cycle, with their numbers.
    orders: Vec<(usize, CommandOrder)>,
    /// How often it was started; older cycle events mean nothing.
    run: u64,
    watch: Watch,
}

enum State<N> {
    Running(N),
    /// Frozen, with the messages that wait for it.
    Stopped(N, Vec<Message>),
    Dead,
}

struct Link {
    from: usize,
    channel: Channel,
    to: usize,
    seal: KeySeal,
    reader: Reader,
    models: Vec<LinkModel>,
    /// What the frame under way says.
    messages: Vec<Message>,
}

enum Event {
    Cycle { node: usize, run: u64 },
    Deliver { node: usize, message: Message },
}

impl<N: Node> Default for World<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<N: Node> World<N> {
    /// An empty world at true time zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            now: Instant::EPOCH,
            queue: EventQueue::new(),
            nodes: Vec::new(),
            links: Vec::new(),
            frame: Vec::new(),
        }
    }

    /// Puts a node into the world and starts it. Gives its number.
    pub fn add_node(&mut self, setup: NodeSetup<N>) -> usize {
        let clock_seed = seed_of(setup.seed, "clock");
        let jitter_seed = seed_of(setup.seed, "jitter");
        self.nodes.push(Inhabitant {
            clock: DeviatedClock::new(&setup.clock, clock_seed, self.now),
            jitter: CycleJitter::new(&setup.clock, jitter_seed),
            start_phase: setup.clock.start_phase(),
            name: setup.name,
            send_stamps: setup.send_stamps,
            build: setup.build,
            state: State::Dead,
            orders: Vec::new(),
            run: 0,
            watch: Watch::default(),
        });
        let node = self.nodes.len() - 1;
        self.start(node);
        node
    }

    /// Connects a subscriber.
    pub fn add_link(&mut self, setup: LinkSetup) {
        let models = setup
            .behaviour
            .iter()
            .map(|(config, seed)| LinkModel::new(config, *seed))
            .collect();
        self.links.push(Link {
            from: setup.from,
            channel: setup.channel,
            to: setup.to,
            seal: KeySeal::new(&setup.key),
            reader: setup.reader,
            models,
            messages: Vec::new(),
        });
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
            State::Running(node) | State::Stopped(node, _) => Some(node),
            State::Dead => None,
        }
    }

    /// The drift of a node's clock against true time now, ppm.
    #[must_use]
    pub fn drift_ppm(&self, index: usize) -> f64 {
        self.nodes[index].clock.drift_ppm()
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
        while self.queue.next_at().is_some_and(|at| at < end) {
            let Some((at, event)) = self.queue.pop() else {
                break;
            };
            self.now = at;
            match event {
                Event::Cycle { node, run } => self.cycle(node, run, observer)?,
                Event::Deliver { node, message } => self.deliver(node, &message),
            }
        }
        self.now = end;
        Ok(())
    }

    /// Ends a node at once, as a power cut does.
    pub fn kill(&mut self, node: usize) {
        self.nodes[node].state = State::Dead;
        self.nodes[node].orders.clear();
    }

    /// Sends an order to one of a node's slaves. It is executed in the node's next cycle, unless
    /// the node is dead.
    pub fn order(&mut self, node: usize, number: usize, order: CommandOrder) {
        let inhabitant = &mut self.nodes[node];
        if !matches!(inhabitant.state, State::Dead) {
            inhabitant.orders.push((number, order));
        }
    }

    /// Starts a dead node anew, on the same clock.
    pub fn start(&mut self, node: usize) {
        let now = self.now;
        let inhabitant = &mut self.nodes[node];
        inhabitant.run += 1;
        inhabitant.watch = Watch::default();
        let start = inhabitant.clock.local_at(now) + inhabitant.start_phase;
        inhabitant.state = State::Running((inhabitant.build)(start, inhabitant.run));
        self.schedule(node);
    }

    /// Freezes a node, as a debugger does. Messages wait for it.
    pub fn stop(&mut self, node: usize) {
        let state = &mut self.nodes[node].state;
        *state = match std::mem::replace(state, State::Dead) {
            State::Running(node) => State::Stopped(node, Vec::new()),
            other => other,
        };
    }

    /// Lets a frozen node go on. What waited for it arrives now.
    pub fn resume(&mut self, node: usize) {
        let state = &mut self.nodes[node].state;
        match std::mem::replace(state, State::Dead) {
            State::Stopped(frozen, waiting) => {
                *state = State::Running(frozen);
                for message in &waiting {
                    self.deliver(node, message);
                }
                self.schedule(node);
            }
            other => *state = other,
        }
    }

    fn schedule(&mut self, node: usize) {
        let inhabitant = &mut self.nodes[node];
        if let State::Running(running) = &inhabitant.state {
            let wake = running.next_cycle() + inhabitant.jitter.next();
            let at = inhabitant.clock.reference_at(wake).max(self.now);
            let run = inhabitant.run;
            self.queue.add(at, Event::Cycle { node, run });
        }
    }

    fn cycle(
        &mut self,
        index: usize,
        run: u64,
        observer: &mut impl Observer<N>,
    ) -> Result<(), Violation> {
        let now = self.now;
        let inhabitant = &mut self.nodes[index];
        let State::Running(node) = &mut inhabitant.state else {
            return Ok(());
        };
        if run != inhabitant.run {
            return Ok(());
        }
        let local = inhabitant.clock.local_at(now);
        for (number, order) in inhabitant.orders.drain(..) {
            observer.order_executed(number, &node.execute(&order));
        }
        let turn = node.cycle(local);
        inhabitant
            .watch
            .check(&inhabitant.name, node, turn, local)?;
        while let Some(outgoing) = node.transmit() {
            let stamped = inhabitant.send_stamps || !outgoing.channel.carries_axes();
            let stamp = stamped.then(|| local - outgoing.ideal_start);
            for link in &mut self.links {
                if link.from == index && link.channel == outgoing.channel {
                    link.seal.seal(outgoing.body, stamp, &mut self.frame);
                    link.send(now, &self.frame, &mut self.queue);
                }
            }
        }
        let ideal_start = inhabitant.clock.reference_at(turn.ideal_start);
        while let Some(arrival) = node.arrival() {
            observer.arrived(index, ideal_start, &turn, &arrival);
        }
        observer.cycle_seen(&CycleSeen {
            index,
            node,
            turn,
            ideal_start,
            woke: now,
        });
        self.schedule(index);
        Ok(())
    }

    fn deliver(&mut self, node: usize, message: &Message) {
        let now = self.now;
        let inhabitant = &mut self.nodes[node];
        match &mut inhabitant.state {
            State::Running(node) => node.receive(inhabitant.clock.local_at(now), message),
            State::Stopped(_, waiting) => waiting.push(*message),
            State::Dead => {}
        }
    }
}

impl Link {
    fn send(&mut self, now: Instant<True>, frame: &[u8], queue: &mut EventQueue<Event>) {
        self.messages.clear();
        let messages = &mut self.messages;
        self.reader.read(frame, |message| messages.push(message));
        let sent = now.since_epoch();
        self.pass(0, sent, sent, queue);
    }

    /// Through one model after the other: the delays of the first are the sending times of the
    /// next.
    fn pass(&mut self, stage: usize, sent: Span, at: Span, queue: &mut EventQueue<Event>) {
        let Some(model) = self.models.get_mut(stage) else {
            for message in &self.messages {
                let event = Event::Deliver {
                    node: self.to,
                    message: *message,
                };
                queue.add(Instant::EPOCH + at, event);
            }
            return;
        };
        for delay in model.offer(sent) {
            self.pass(stage + 1, sent, at + delay, queue);
        }
    }
}
