//! A node that records its inputs, and an observer that records its cycles.

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Schedule, Span};
use coaxle_node::command::{NotTaken, OrderCargo};
use coaxle_node::config::{ClockConfig, LinkConfig, parse};
use coaxle_node::frame::{body_capacity, encode_body, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{
    Arrival, Arrived, Channel, CommandOrder, CommandOutcome, FrameHeader, Intake, Message, Node,
    Outgoing, Reader,
};
use coaxle_sim::{CycleSeen, LinkSetup, NodeSetup, Observer, True, World};

/// The one axis of every toy.
const AXIS: u32 = 3;

/// Sends a frame per cycle and remembers what it received.
pub(crate) struct Toy {
    name: NodeName,
    /// Run number of the node.
    pub(crate) run: u64,
    schedule: Schedule,
    /// Channels that it publishes in each cycle.
    sends: Vec<Channel>,
    pending: Vec<Channel>,
    tick: Option<Tick>,
    body: Vec<u8>,
    /// Messages received, with the instant of its own clock.
    pub(crate) received: Vec<(Instant<Local>, Message<'static>)>,
    /// Slaves of the executed orders, with the cycle before each.
    pub(crate) executed: Vec<(String, Option<u64>)>,
    /// Messages since the last cycle.
    arrivals: Vec<Arrival>,
    /// Channels that it was notified to have a subscriber.
    pub(crate) subscribed: Vec<Channel>,
    /// Fault in a tick, or in the due time of the next cycle.
    pub(crate) wrong: Misbehaviour,
}

/// Fault of a toy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Misbehaviour {
    Nothing,
    /// Reports that no cycle passed.
    Miscounts,
    /// Reports the same ideal start for every cycle.
    StandsStill,
    /// Is due again at the ideal start of the last cycle.
    IsDueAtOnce,
    /// Is due again just after the ideal start of the last cycle.
    CatchesUp,
}

impl Toy {
    fn wronged(&self, mut tick: Tick) -> Tick {
        match self.wrong {
            Misbehaviour::Miscounts => tick.elapsed = 0,
            Misbehaviour::StandsStill => tick.ideal_start = Instant::EPOCH,
            Misbehaviour::Nothing | Misbehaviour::IsDueAtOnce | Misbehaviour::CatchesUp => {}
        }
        tick
    }

    /// The counts of the frames it received, and when.
    pub(crate) fn counts(&self) -> Vec<(Instant<Local>, u64)> {
        let count = |(at, message): &(Instant<Local>, Message<'static>)| match message {
            Message::Frame(frame) => (*at, frame.header.count),
            other => panic!("{other:?}"),
        };
        self.received.iter().map(count).collect()
    }

    /// Send stamp of each frame.
    pub(crate) fn send_stamps(&self) -> Vec<Option<Span>> {
        let stamp = |(_, message): &(Instant<Local>, Message<'static>)| match message {
            Message::Frame(frame) => frame.header.send_stamp,
            other => panic!("{other:?}"),
        };
        self.received.iter().map(stamp).collect()
    }
}

impl Node for Toy {
    type Snapshot = ();

    fn receive(&mut self, at: Instant<Local>, _: usize, message: &Message<'_>) {
        self.received.push((at, message.split().0));
        if let Message::Frame(frame) = message {
            let (far, what) = (0, Arrived::Message(frame.header));
            self.arrivals.push(Arrival { far, at, what });
        }
    }

    fn execute_with(&mut self, order: &CommandOrder, _: &mut OrderCargo) -> CommandOutcome {
        let after = self.tick.map(|tick| tick.count);
        self.executed.push((order.addressee().to_owned(), after));
        CommandOutcome::NotTaken(NotTaken::NoSlaves)
    }

    fn set_subscribed(&mut self, channel: Channel, is_subscribed: bool) {
        self.subscribed.retain(|other| *other != channel);
        self.subscribed.extend(is_subscribed.then_some(channel));
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        let tick = self.schedule.take(now);
        self.tick = Some(tick);
        self.pending.clone_from(&self.sends);
        self.wronged(tick)
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let channel = self.pending.pop()?;
        let tick = self.tick?;
        let header = FrameHeader {
            sender: sender_id(&self.name),
            epoch: self.run,
            index: CycleIndex::of_count(tick.count),
            count: tick.count,
            cycle_time: self.schedule.cycle_time(),
            present_after: None,
            send_stamp: None,
        };
        let axis = NcToPlcAxis {
            axis_id: AXIS,
            ..NcToPlcAxis::default()
        };
        self.body.resize(body_capacity(1), 0);
        let length = encode_body(&header, &[axis], &mut self.body).expect("one axis fits");
        Some(Outgoing {
            channel,
            far: 0,
            ideal_start: tick.ideal_start,
            body: &self.body[..length],
        })
    }

    fn arrival(&mut self) -> Option<Arrival> {
        (!self.arrivals.is_empty()).then(|| self.arrivals.remove(0))
    }

    fn next_cycle(&self) -> Instant<Local> {
        match (self.wrong, self.tick) {
            (Misbehaviour::IsDueAtOnce, Some(tick)) => tick.ideal_start,
            (Misbehaviour::CatchesUp, Some(tick)) => tick.ideal_start + Span::from_nanos(1),
            _ => self.schedule.next_start(),
        }
    }

    fn snapshot(&self) -> &() {
        &()
    }
}

/// A toy with a cycle of 1 ms that publishes on these channels.
pub(crate) fn toy(name: &str, clock: &str, sends: &[Channel]) -> NodeSetup<Toy> {
    seeded(name, 1, clock, sends)
}

pub(crate) fn seeded(name: &str, seed: u64, clock: &str, sends: &[Channel]) -> NodeSetup<Toy> {
    let sends = sends.to_vec();
    let node = NodeName::new(name).expect("a test's own input");
    NodeSetup {
        name: name.to_owned(),
        seed,
        clock: parse::<ClockConfig>("clock", clock).expect("a test's own input"),
        common_time: None,
        send_stamps: true,
        build: Box::new(move |start, run| Toy {
            name: node.clone(),
            run,
            schedule: Schedule::new(
                start,
                CycleTime::new(Span::from_millis(1)).expect("a test's own input"),
            ),
            sends: sends.clone(),
            pending: Vec::new(),
            tick: None,
            body: Vec::new(),
            received: Vec::new(),
            executed: Vec::new(),
            arrivals: Vec::new(),
            subscribed: Vec::new(),
            wrong: Misbehaviour::Nothing,
        }),
    }
}

/// Creates a toy with a fault.
pub(crate) fn wrong_toy(name: &str, wrong: Misbehaviour) -> NodeSetup<Toy> {
    let mut setup = toy(name, "", &[]);
    let build = setup.build;
    setup.build = Box::new(move |start, run| Toy {
        wrong,
        ..build(start, run)
    });
    setup
}

/// A link from the axes of the node `belt` to node number `to`.
pub(crate) fn link(from: usize, to: usize, behaviour: &[&str]) -> LinkSetup {
    link_of(Channel::Axes, from, to, behaviour)
}

pub(crate) fn link_of(channel: Channel, from: usize, to: usize, behaviour: &[&str]) -> LinkSetup {
    let belt = NodeName::new("belt").expect("a test's own input");
    let key = belt.channel_key(channel);
    LinkSetup {
        from,
        channel,
        far: 0,
        to,
        subscription: 0,
        reader: Reader::from(Intake::new(&key, &belt, &[AXIS])),
        key,
        behaviour: behaviour
            .iter()
            .zip(1..)
            .map(|(text, seed)| {
                (
                    parse::<LinkConfig>("link", text).expect("a test's own input"),
                    seed,
                )
            })
            .collect(),
    }
}

/// A belt whose axes a saw receives, over links with these behaviours.
pub(crate) fn belt_and_saw(belt: &str, saw: &str, behaviour: &[&str]) -> World<Toy> {
    let mut world = World::new();
    let belt = world
        .add_node(toy("belt", belt, &[Channel::Axes]))
        .expect("no files");
    let saw = world.add_node(toy("saw", saw, &[])).expect("no files");
    world
        .add_link(link(belt, saw, behaviour))
        .expect("no files");
    world
}

pub(crate) const BELT: usize = 0;
pub(crate) const SAW: usize = 1;

/// A cycle as the observer saw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) index: usize,
    pub(crate) run: u64,
    pub(crate) tick: Tick,
    pub(crate) ideal_start: Instant<True>,
    pub(crate) woke: Instant<True>,
    /// Number of arrivals reported before it.
    pub(crate) arrivals: usize,
}

/// Remembers every cycle of every node.
#[derive(Default)]
pub(crate) struct Memory {
    pub(crate) cycles: Vec<Seen>,
    pub(crate) arrived: Vec<(usize, Instant<True>, Tick, Arrival)>,
    pub(crate) orders: Vec<usize>,
}

impl Memory {
    pub(crate) fn of(&self, index: usize) -> Vec<Seen> {
        let cycles = self.cycles.iter().copied();
        cycles.filter(|seen| seen.index == index).collect()
    }
}

impl Observer<Toy> for Memory {
    fn cycle_seen(&mut self, seen: &CycleSeen<'_, Toy>) {
        self.cycles.push(Seen {
            index: seen.index,
            run: seen.node.run,
            tick: seen.tick,
            ideal_start: seen.ideal_start,
            woke: seen.woke,
            arrivals: self.arrived.len(),
        });
    }

    fn arrived(
        &mut self,
        index: usize,
        ideal_start: Instant<True>,
        tick: &Tick,
        arrival: &Arrival,
    ) {
        self.arrived.push((index, ideal_start, *tick, *arrival));
    }

    fn order_executed(&mut self, number: usize, _outcome: &CommandOutcome) {
        self.orders.push(number);
    }
}

/// An instant of true time.
pub(crate) fn at(micros: i64) -> Instant<True> {
    Instant::from_nanos(micros * 1_000)
}

/// Lets true time flow until `micros`.
pub(crate) fn run(world: &mut World<Toy>, micros: i64, memory: &mut Memory) {
    world
        .run_until(at(micros), memory)
        .expect("toys keep the contract");
}

/// An order that is distinguished from others by its slave.
pub(crate) fn order(slave: &str) -> CommandOrder {
    let json = format!(r#"{{ "version": 1, "slave": "{slave}", "command": {{ "reset": {{}} }} }}"#);
    CommandOrder::from_json(json.as_bytes()).expect("an order")
}
