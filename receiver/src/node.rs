//! The receiver as a node.

use coaxle_clock::cycle::Turn;
use coaxle_clock::time_sync::WrongParameter;
use coaxle_clock::{CycleIndex, Instant, Local, Schedule};
use coaxle_motion::drive::{Drive, WrongDriveParameter};
use coaxle_motion::gear::{LinearGear, RatioZero};
use coaxle_node::frame::{body_capacity, encode_body, sender_id};
use coaxle_node::{Channel, FrameHeader, Message, Node, Outgoing};

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
        };
        let pipeline = Pipeline::new(setup, gear, drive)?;
        Ok(Self {
            schedule: Schedule::new(start, cycle_time),
            pipeline,
            identity: Identity {
                sender: sender_id(&config.name),
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
}

impl Node for Receiver {
    type Snapshot = ReceiverSnapshot;

    fn receive(&mut self, at: Instant<Local>, message: &Message) {
        self.pipeline.store(at, message);
    }

    fn cycle(&mut self, now: Instant<Local>) -> Turn {
        self.turn = self.schedule.take(now);
        self.woke = now;
        self.pipeline.scan(&self.turn);
        let mut body = std::mem::take(&mut self.body);
        self.pending = self.encode_slave(&mut body);
        self.body = body;
        self.turn
    }

    fn transmit(&mut self) -> Option<Outgoing<'_>> {
        let length = self.pending.take()?;
        Some(Outgoing {
            channel: Channel::Slaves,
            ideal_start: self.turn.ideal_start,
            body: &self.body[..length],
        })
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
            slave: self.pipeline.slave(),
            drive: self.pipeline.drive(),
        }
    }
}
