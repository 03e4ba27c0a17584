//! The receiver as a node.

use coaxle_clock::cycle::Turn;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{CycleIndex, Instant, Local, Schedule};
use coaxle_motion::drive::{Drive, WrongDriveParameter};
use coaxle_motion::gear::{LinearGear, RatioZero};
use coaxle_node::exchange::{QUESTION_CAPACITY, encode_question};
use coaxle_node::frame::{body_capacity, encode_body, sender_id};
use coaxle_node::{Answering, Channel, FrameHeader, Message, Node, Outgoing};

use crate::config::ReceiverConfig;
use crate::far_clock::FarClockSetup;
use crate::pipeline::Pipeline;
use crate::slave;
use crate::snapshot::ReceiverSnapshot;

/// A receiver: follows one far axis and drives one slave with it.
#[derive(Debug)]
pub struct Receiver {
    schedule: Schedule,
    pipeline: Pipeline,
    identity: Identity,
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

/// What every frame of the slave says of its sender.
#[derive(Debug)]
struct Identity {
    sender: u32,
    epoch: u64,
    slave_id: u32,
}

/// A config that no receiver can run with.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ReceiverError {
    /// A parameter of the TS5066 blocks.
    #[error("sync: {0}")]
    Sync(#[from] WrongParameter),
    /// The gear.
    #[error("gear: {0}")]
    Gear(#[from] RatioZero),
    /// The drive.
    #[error("drive: {0}")]
    Drive(#[from] WrongDriveParameter),
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
        let gear = LinearGear::new(config.gear.ratio, config.gear.offset)?;
        let drive = Drive::new(config.drive)?;
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
        let pipeline = Pipeline::new(setup, gear, drive)?;
        Ok(Self {
            schedule: Schedule::new(start, cycle_time),
            pipeline,
            identity: Identity {
                sender,
                epoch,
                slave_id: config.slave.id,
            },
            turn: Turn {
                count: 0,
                ideal_start: start,
                elapsed: 0,
            },
            woke: start,
            body: vec![0; body_capacity(1)],
            pending: None,
            answering: Answering::new(sender, epoch, start, cycle_time),
            question: [0; QUESTION_CAPACITY],
            asking: None,
        })
    }

    /// The slave's frame of this cycle. A slave that was never coupled has nothing to say.
    fn encode_slave(&self, body: &mut [u8]) -> Option<usize> {
        let set = self.pipeline.slave()?;
        let master = self.pipeline.master();
        let drive = self.pipeline.drive();
        let axis = slave::axis_of(self.identity.slave_id, &set, master.as_ref(), &drive);
        let header = FrameHeader {
            sender: self.identity.sender,
            epoch: self.identity.epoch,
            index: CycleIndex::of_count(self.turn.count),
            count: self.turn.count,
            cycle_time: self.schedule.cycle_time(),
            send_stamp: None,
        };
        encode_body(&header, &[axis], body).ok()
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

    fn cycle(&mut self, now: Instant<Local>) -> Turn {
        self.turn = self.schedule.take(now);
        self.woke = now;
        self.pipeline.scan(&self.turn);
        let mut body = std::mem::take(&mut self.body);
        self.pending = self.encode_slave(&mut body);
        self.body = body;
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
            slave: self.pipeline.slave(),
            drive: self.pipeline.drive(),
        }
    }
}
