//! A node for tests: sends a body each cycle and remembers what it received.

use coaxle_axis::{Awaits, AxisStatus};
use coaxle_clock::cycle::Tick;
use coaxle_clock::{CycleTime, Instant, Local, Schedule};
use coaxle_node::command::{OrderCargo, SlaveView};
use coaxle_node::{
    Arrival, Arrived, Channel, CommandOrder, CommandOutcome, Message, Node, Outgoing,
};
use coaxle_slave::{Command, Refusal};

/// The smallest possible node.
pub(crate) struct Toy {
    schedule: Schedule,
    body: Vec<u8>,
    pending: Option<Instant<Local>>,
    arrival: Option<Arrival>,
    snapshot: ToySnapshot,
}

/// Snapshot of a toy.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ToySnapshot {
    pub(crate) samples: u64,
    pub(crate) rejected: u64,
    pub(crate) commands: u16,
    pub(crate) last_arrival: Instant<Local>,
}

impl Toy {
    pub(crate) fn new(start: Instant<Local>, cycle_time: CycleTime, fill: u8) -> Self {
        Self::sending(start, cycle_time, vec![fill; 100])
    }

    pub(crate) fn sending(start: Instant<Local>, cycle_time: CycleTime, body: Vec<u8>) -> Self {
        Self {
            schedule: Schedule::new(start, cycle_time),
            body,
            pending: None,
            arrival: None,
            snapshot: ToySnapshot::default(),
        }
    }
}

impl Node for Toy {
    type Snapshot = ToySnapshot;

    fn receive(&mut self, at: Instant<Local>, _: usize, message: &Message<'_>) {
        self.snapshot.last_arrival = at;
        match message {
            Message::Frame(frame) => {
                self.snapshot.samples += 1;
                let (far, what) = (0, Arrived::Message(frame.header));
                self.arrival = Some(Arrival { far, at, what });
            }
            Message::Rejected(_) => self.snapshot.rejected += 1,
            Message::TimeRequest(_)
            | Message::TimeResponse(_)
            | Message::BeaconRequest(_)
            | Message::BeaconResponse(_)
            | Message::PlannedPiece(_)
            | Message::PlanRefused(_)
            | Message::FollowerReport(_) => {}
        }
    }

    /// Executes an order for its slave `toy`, which accepts a new position and no other command.
    fn execute_with(&mut self, order: &CommandOrder, _: &mut OrderCargo) -> CommandOutcome {
        let order = match order {
            CommandOrder::Slave(order) if order.addressee.as_str() == "toy" => order,
            other => return other.without_addressee(),
        };
        let mut slave = SlaveView {
            status: AxisStatus::Standstill,
            coupling: None,
            position: 0.0,
            velocity: 0.0,
        };
        let Command::Home { position } = order.command else {
            let refusal = Refusal::NoMaster;
            return CommandOutcome::Refused {
                refusal,
                slave,
                saw: None,
            };
        };
        slave.position = position;
        self.snapshot.commands += 1;
        CommandOutcome::Accepted {
            job: Some(self.snapshot.commands.into()),
            awaits: Awaits::empty(),
            slave,
            sync_positions: None,
            saw: None,
        }
    }

    fn cycle(&mut self, now: Instant<Local>) -> Tick {
        let tick = self.schedule.take(now);
        self.pending = Some(tick.ideal_start);
        tick
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        self.pending.take().map(|ideal_start| Outgoing {
            channel: Channel::Axes,
            far: 0,
            ideal_start,
            body: &self.body,
        })
    }

    fn arrival(&mut self) -> Option<Arrival> {
        self.arrival.take()
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.schedule.next_start()
    }

    fn snapshot(&self) -> &ToySnapshot {
        &self.snapshot
    }
}
