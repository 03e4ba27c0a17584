//! A sender and a chain of receivers on computed clocks, without a network: each node is woken
//! exactly at its cycles, and a frame takes a fixed time to the next node.

#![allow(dead_code, reason = "each test file takes what it needs")]

mod shown;

use std::collections::VecDeque;

use coaxle_clock::{Instant, Local, Span};
use coaxle_node::config::parse;
use coaxle_node::frame::KeySeal;
use coaxle_node::{AxisSample, Channel, Intake, KeptMessage, Message, Node};
use coaxle_receiver::{Receiver, ReceiverConfig};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;
#[allow(unused_imports, reason = "each test file takes what it needs")]
pub(crate) use shown::{Shown, SlaveShown};

/// Transport time of a frame.
pub(crate) const LATENCY: Span = Span::from_micros(230);

/// The velocity of the sender's axis, u/s.
pub(crate) const VELOCITY: f64 = 500.0;

/// True time, in nanoseconds.
pub(crate) type Nanos = i64;

pub(crate) const SECOND: Nanos = 1_000_000_000;
pub(crate) const MILLISECOND: Nanos = 1_000_000;

/// A clock that runs fast by a constant fraction, and reads 0 at true time 0.
#[derive(Clone, Copy)]
pub(crate) struct Clock {
    pub(crate) ppm: i64,
}

impl Clock {
    pub(crate) fn read(self, truth: Nanos) -> Instant<Local> {
        // In 64 bits, nanoseconds times a million overflow after 2.6 h.
        let local = i128::from(truth) * i128::from(MILLION + self.ppm) / i128::from(MILLION);
        Instant::from_nanos(local as i64)
    }

    /// The first instant at which the clock reads at least `local`.
    pub(crate) fn truth(self, local: Instant<Local>) -> Nanos {
        let rate = i128::from(MILLION + self.ppm);
        let scaled = i128::from(local.as_nanos()) * i128::from(MILLION);
        // Rounded up, so that the clock reads at least `local` then.
        ((scaled + rate - 1) / rate) as i64
    }
}

const MILLION: i64 = 1_000_000;

/// A sender of the one axis 1, moving at [`VELOCITY`].
pub(crate) struct Far {
    clock: Clock,
    node: Sender,
    seal: KeySeal,
}

impl Far {
    /// Creates a sender whose clock runs fast by `ppm` and whose first cycle is at true time `start`.
    pub(crate) fn new(cycle_us: u32, ppm: i64, start: Nanos, epoch: u64) -> Self {
        let program = format!(
            "start-velocity = {VELOCITY:?}, limits = {{ velocity = 1000, acceleration = 1000, jerk \
             = 10000 }}"
        );
        Self::with_program(cycle_us, ppm, start, epoch, &program)
    }

    /// Creates a sender whose axis moves by this program.
    pub(crate) fn with_program(
        cycle_us: u32,
        ppm: i64,
        start: Nanos,
        epoch: u64,
        program: &str,
    ) -> Self {
        let text = format!(
            "name = 'conveyor'\ncycle-time-us = {cycle_us}\n[[axis]]\nid = 1\nname = 'x'\n\
             program = {{ {program} }}\n"
        );
        let config: SenderConfig = parse("sender", &text).expect("valid");
        let clock = Clock { ppm };
        Self {
            clock,
            node: Sender::new(&config, clock.read(start), epoch).expect("valid"),
            seal: KeySeal::new(&config.name.channel_key(Channel::Axes)),
        }
    }

    pub(crate) fn next(&self) -> Nanos {
        self.clock.truth(self.node.next_cycle())
    }

    /// Runs the cycle that is due and returns its frame.
    pub(crate) fn tick(&mut self, truth: Nanos) -> Vec<u8> {
        let _ = self.node.cycle(self.clock.read(truth));
        let outgoing = self.node.transmit().expect("a frame per cycle");
        let mut frame = Vec::new();
        self.seal.seal(outgoing.body, Some(Span::ZERO), &mut frame);
        frame
    }

    /// The count of the newest cycle.
    pub(crate) fn count(&self) -> u64 {
        self.node.snapshot().signals.node.cycle
    }
}

/// Changes a message just before the receiver gets it.
pub(crate) type Tweak = Box<dyn FnMut(Nanos, &mut AxisSample)>;

/// A receiver with its mailbox.
pub(crate) struct Near {
    clock: Clock,
    pub(crate) node: Receiver,
    intake: Intake,
    seal: KeySeal,
    mailbox: VecDeque<(Nanos, KeptMessage)>,
    /// End of its sleep.
    asleep_until: Nanos,
    /// Number of waiting messages that the network hands in per cycle, stamped as they are handed in.
    pub(crate) piece: Option<usize>,
    /// Number of messages that can wait for a sleeping receiver; later ones are lost.
    pub(crate) room: usize,
    pub(crate) tweak: Option<Tweak>,
    /// Start of its sender's index, instead of 0.
    pub(crate) first_index: Option<u16>,
    /// Snapshots, a snapshot per cycle.
    pub(crate) snapshots: Vec<Shown>,
    /// True time of each cycle.
    pub(crate) truths: Vec<Nanos>,
    /// The newest frame of its slave.
    pub(crate) slave_frame: Option<Vec<u8>>,
}

impl Near {
    /// Creates a receiver of the sender's axis. `rest` is the rest of its config; its clock runs
    /// fast by `ppm` and its first cycle is half a millisecond after the sender's.
    pub(crate) fn new(cycle_us: u32, ppm: i64, rest: &str) -> Self {
        let head = format!("name = 'saw'\nmaster.node = 'conveyor'\ncycle-time-us = {cycle_us}\n");
        Self::of(
            &parse("receiver", &format!("{head}{rest}")).expect("valid"),
            ppm,
        )
    }

    /// Creates a receiver with further fields of its master, such as `modulo = 360`.
    pub(crate) fn with_master(cycle_us: u32, ppm: i64, master: &str, rest: &str) -> Self {
        let text = format!(
            "name = 'saw'\nmaster = {{ node = 'conveyor', {master} }}\ncycle-time-us = {cycle_us}\n{rest}\n"
        );
        Self::of(&parse("receiver", &text).expect("valid"), ppm)
    }

    /// Creates a receiver of the slave of the one before.
    pub(crate) fn chained(cycle_us: u32, ppm: i64, rest: &str) -> Self {
        let head = format!(
            "name = 'stamp'\nmaster = {{ node = 'saw', channel = 'slaves', axis = 4 }}\n\
             cycle-time-us = {cycle_us}\n"
        );
        Self::of(
            &parse("receiver", &format!("{head}{rest}")).expect("valid"),
            ppm,
        )
    }

    fn of(config: &ReceiverConfig, ppm: i64) -> Self {
        let clock = Clock { ppm };
        let start = clock.read(MILLISECOND / 2);
        let far = &config.far[0];
        let key = far.node.channel_key(far.channel.into());
        Self {
            clock,
            node: Receiver::new(config, start, 77).expect("valid"),
            intake: Intake::new(&key, &far.node, &far.axes.ids()),
            seal: KeySeal::new(&config.name.channel_key(Channel::Slaves)),
            mailbox: VecDeque::new(),
            asleep_until: 0,
            piece: None,
            room: usize::MAX,
            tweak: None,
            first_index: None,
            snapshots: Vec::new(),
            truths: Vec::new(),
            slave_frame: None,
        }
    }

    pub(crate) fn next(&self) -> Nanos {
        let due = self.clock.truth(self.node.next_cycle());
        due.max(self.asleep_until)
    }

    /// Stops it: messages that arrive meanwhile are stamped only when it wakes.
    pub(crate) fn sleep_until(&mut self, truth: Nanos) {
        self.asleep_until = truth;
    }

    /// Posts a frame that was sent at this instant.
    pub(crate) fn post(&mut self, sent: Nanos, frame: &[u8]) {
        if self.mailbox.len() >= self.room {
            return;
        }
        let mut message = KeptMessage::new(&self.intake.message(frame));
        if let Some(tweak) = &mut self.tweak {
            message
                .axes_mut()
                .iter_mut()
                .flatten()
                .for_each(|axis| tweak(sent, axis));
        }
        if let Some(first) = self.first_index {
            message = counted_from(first, &message);
        }
        let arrival = sent + LATENCY.as_nanos();
        // Messages to a sleeping receiver are stamped on waking.
        self.mailbox
            .push_back((arrival.max(self.asleep_until), message));
    }

    /// Runs the cycle that is due; returns the slave's frame, if there is one.
    pub(crate) fn tick(&mut self, truth: Nanos) -> Option<Vec<u8>> {
        let mut taken = 0;
        while let Some((arrival, message)) = self.mailbox.front()
            && *arrival <= truth
            && self.piece.is_none_or(|piece| taken < piece)
        {
            // A message that waited for its piece is stamped when handed in.
            let waited = self.piece.is_some() && truth - arrival > MILLISECOND;
            let at = if waited { truth } else { *arrival };
            self.node.receive(self.clock.read(at), 0, &message.get());
            self.mailbox.pop_front();
            taken += 1;
        }
        let _ = self.node.cycle(self.clock.read(truth));
        self.snapshots.push(Shown::of(self.node.snapshot()));
        self.truths.push(truth);
        let mut frame = None;
        while let Some(outgoing) = self.node.transmit() {
            if outgoing.channel == Channel::Slaves {
                let sealed = frame.insert(Vec::new());
                self.seal.seal(outgoing.body, Some(Span::ZERO), sealed);
            }
        }
        self.slave_frame = frame.clone().or(self.slave_frame.take());
        frame
    }

    pub(crate) fn last(&self) -> &Shown {
        self.snapshots.last().expect("a cycle ran")
    }

    /// The snapshots of the last `count` cycles.
    pub(crate) fn newest(&self, count: usize) -> &[Shown] {
        &self.snapshots[self.snapshots.len() - count..]
    }
}

/// Runs a sender, if there is one, and a chain of receivers, each fed by the one before, to the
/// true time `until`.
pub(crate) fn run(mut far: Option<&mut Far>, chain: &mut [Near], until: Nanos) {
    loop {
        let (k, due) = chain
            .iter()
            .map(Near::next)
            .enumerate()
            .min_by_key(|(_, due)| *due)
            .expect("a receiver");
        match &mut far {
            // The order at equal times does not matter: a frame takes its LATENCY.
            Some(far) if far.next() <= due && far.next() < until => {
                let now = far.next();
                let frame = far.tick(now);
                chain[0].post(now, &frame);
            }
            _ if due < until => {
                let frame = chain[k].tick(due);
                if let (Some(frame), Some(after)) = (frame, chain.get_mut(k + 1)) {
                    after.post(due, &frame);
                }
            }
            _ => return,
        }
    }
}

/// Runs a sender and one receiver.
pub(crate) fn run_pair(far: &mut Far, near: &mut Near, until: Nanos) {
    run(Some(far), std::slice::from_mut(near), until);
}

/// The largest relative deviation of the slave's step per cycle from that of `velocity`.
pub(crate) fn ripple(snapshots: &[Shown], cycle_s: f64, velocity: f64) -> f64 {
    snapshots
        .windows(2)
        .map(|pair| {
            let [before, after] = [0, 1].map(|k| pair[k].slave().expect("coupled").position);
            (((after - before) / cycle_s - velocity) / velocity).abs()
        })
        .fold(0.0, f64::max)
}

/// The message with another index.
fn counted_from(first: u16, message: &KeptMessage) -> KeptMessage {
    match message.get() {
        Message::Frame(mut frame) => {
            frame.header.index.0 = frame.header.index.0.wrapping_add(first);
            KeptMessage::new(&Message::Frame(frame))
        }
        other => KeptMessage::new(&other),
    }
}
