//! The receiver as a node.

use coaxle_clock::cycle::Turn;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{CycleIndex, Instant, Local, Schedule};
use coaxle_motion::slave::{Accepted, Command, Refusal};
use coaxle_node::command::{MAX_KNOWN_SLAVES, NotTaken, SlaveName};
use coaxle_node::exchange::{QUESTION_CAPACITY, encode_question};
use coaxle_node::frame::{body_capacity, encode_body, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_node::{
    Answering, Arrival, Channel, CommandOrder, CommandOutcome, FrameHeader, Message, Node, Outgoing,
};

use crate::config::ReceiverConfig;
use crate::far_clock::FarClockSetup;
use crate::pipeline::Pipeline;
use crate::slaves::{SlaveNumber, Slaves, WrongSlave};
use crate::snapshot::ReceiverSnapshot;

/// A receiver: follows one far axis and drives slaves with it.
#[derive(Debug)]
pub struct Receiver {
    schedule: Schedule,
    pipeline: Pipeline,
    identity: Identity,
    slave_names: Vec<NodeName>,
    turn: Turn,
    woke: Instant<Local>,
    body: Vec<u8>,
    /// Bytes of `body` that wait to be sent.
    pending: Option<usize>,
    answering: Answering,
    question: [u8; QUESTION_CAPACITY],
    /// Bytes of `question` that wait to be sent.
    asking: Option<usize>,
}

/// What every frame of the slaves says of its sender.
#[derive(Debug)]
struct Identity {
    sender: u32,
    epoch: u64,
}

/// A config that no receiver can run with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReceiverError {
    /// A parameter of the TS5066 blocks.
    #[error("sync: {0}")]
    Sync(#[from] WrongParameter),
    /// A slave.
    #[error(transparent)]
    Slave(#[from] WrongSlave),
}

impl Receiver {
    /// A receiver whose first cycle is due at `start`. `epoch` tells this run from earlier ones.
    ///
    /// # Errors
    /// [`ReceiverError`] names the parameter that is out of its range.
    pub fn new(
        config: &ReceiverConfig,
        start: Instant<Local>,
        epoch: u64,
    ) -> Result<Self, ReceiverError> {
        let cycle_time = config.cycle_time_us.0;
        let setup = FarClockSetup {
            cycle_time,
            mode: config.mode,
            sync: config.sync,
            observer: config.observer,
            delay: config.delay,
            run: epoch,
        };
        let sender = sender_id(&config.name);
        let pipeline = Pipeline::new(setup, Slaves::new(config)?)?;
        Ok(Self {
            schedule: Schedule::new(start, cycle_time),
            pipeline,
            identity: Identity { sender, epoch },
            slave_names: config.slaves.iter().map(|s| s.name.clone()).collect(),
            turn: Turn {
                count: 0,
                ideal_start: start,
                elapsed: 0,
            },
            woke: start,
            body: vec![0; body_capacity(config.slaves.len())],
            pending: None,
            answering: Answering::new(sender, epoch, start, cycle_time),
            question: [0; QUESTION_CAPACITY],
            asking: None,
        })
    }

    /// The slave with a name.
    #[must_use]
    pub fn slave_number(&self, name: &str) -> Option<SlaveNumber> {
        let is_it = |slave: &NodeName| slave.as_str() == name;
        self.slave_names.iter().position(is_it).map(SlaveNumber)
    }

    /// A command to a slave, besides those of its program. It takes effect with the next cycle.
    ///
    /// # Errors
    /// [`Refusal`]: nothing has changed by it.
    ///
    /// # Panics
    /// If the number is one of another receiver's, which has more slaves.
    pub fn command(&mut self, slave: SlaveNumber, command: &Command) -> Result<Accepted, Refusal> {
        self.pipeline.command(slave, command)
    }

    /// The names of its slaves, for somebody who asks for another.
    fn known_slaves(&self) -> [Option<SlaveName>; MAX_KNOWN_SLAVES] {
        let name = |name: &NodeName| SlaveName::new(name.as_str()).ok();
        let mut names = self.slave_names.iter().filter_map(name);
        std::array::from_fn(|_| names.next())
    }

    /// The frame of the slaves in this cycle, if they have anything to say.
    fn encode_slaves(&mut self) -> Option<usize> {
        let header = FrameHeader {
            sender: self.identity.sender,
            epoch: self.identity.epoch,
            index: CycleIndex::of_count(self.turn.count),
            count: self.turn.count,
            cycle_time: self.schedule.cycle_time(),
            send_stamp: None,
        };
        match self.pipeline.slave_axes() {
            [] => None,
            axes => encode_body(&header, axes, &mut self.body).ok(),
        }
    }

    /// The question of this cycle, if one is due.
    fn encode_question(&mut self) -> Option<usize> {
        let number = self.pipeline.ask(&self.turn)?;
        let Identity { sender, epoch, .. } = self.identity;
        let ideal_start = self.turn.ideal_start;
        let body = &mut self.question;
        Some(encode_question(sender, epoch, number, ideal_start, body))
    }
}

impl Node for Receiver {
    type Snapshot = ReceiverSnapshot;

    fn receive(&mut self, at: Instant<Local>, message: &Message) {
        match message {
            Message::Question(question) => self.answering.hear(at, question),
            Message::Answer(answer) => self.pipeline.store_answer(at, answer),
            Message::Sample(_) | Message::Rejected(_) => self.pipeline.store(at, message),
        }
    }

    fn execute(&mut self, order: &CommandOrder) -> CommandOutcome {
        let Some(number) = self.slave_number(order.slave.as_str()) else {
            return CommandOutcome::NotTaken(NotTaken::UnknownSlave {
                received: order.slave,
                known: self.known_slaves(),
            });
        };
        self.pipeline.execute(number, order)
    }

    fn cycle(&mut self, now: Instant<Local>) -> Turn {
        self.turn = self.schedule.take(now);
        self.woke = now;
        self.pipeline.scan(&self.turn);
        self.pending = self.encode_slaves();
        self.answering.answer(&self.turn, now);
        self.asking = self.encode_question();
        self.turn
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let ideal_start = self.turn.ideal_start;
        if let Some(length) = self.pending.take() {
            return Some(Outgoing {
                channel: Channel::Slaves,
                ideal_start,
                body: &self.body[..length],
            });
        }
        if let Some(length) = self.asking.take() {
            return Some(Outgoing {
                channel: Channel::Questions,
                ideal_start,
                body: &self.question[..length],
            });
        }
        self.answering.transmit()
    }

    fn arrival(&mut self) -> Option<Arrival> {
        self.pipeline.arrival()
    }

    fn next_cycle(&self) -> Instant<Local> {
        self.schedule.next_start()
    }

    fn snapshot(&self) -> ReceiverSnapshot {
        ReceiverSnapshot {
            cycle: self.turn.count,
            ideal_start: self.turn.ideal_start,
            woke: self.woke,
            overruns: self.schedule.overruns(),
            health: self.pipeline.health(),
            counters: self.pipeline.counters(),
            data_cycle_time: self.pipeline.data_cycle_time(),
            master: self.pipeline.master(),
            observer: self.pipeline.observer(),
            delay: self.pipeline.delay(),
            questions: self.answering.counters(),
            slaves: self.pipeline.slaves(),
        }
    }
}
