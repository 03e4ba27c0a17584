//! Far nodes as seen by a receiver, on computed clocks, without a network.

#![allow(dead_code, reason = "each test file takes what it needs")]

use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node};
use coaxle_receiver::{Receiver, ReceiverConfig, SignalRow};

pub(crate) const MILLISECOND: i64 = 1_000_000;

/// A master that goes to and fro with up to 5 000 u/s² and 100 000 u/s³, at a time of its own clock, s.
pub(crate) fn to_and_fro(t: f64) -> Kinematics {
    const W: f64 = 20.0;
    const A: f64 = 5_000.0 / (W * W);
    Kinematics {
        position: 400.0 * t + A * (W * t).sin(),
        velocity: 400.0 + A * W * (W * t).cos(),
        acceleration: -A * W * W * (W * t).sin(),
    }
}

/// A far node as seen by the receiver, with a delay of 200 µs and up to 1 µs more.
pub(crate) struct Far {
    pub(crate) subscription: usize,
    pub(crate) epoch: u64,
    /// Nanoseconds of the receiver's clock from cycle to cycle.
    pub(crate) cycle: i64,
    pub(crate) next: u64,
    /// Velocity of each axis; none leaves it out of the frames.
    pub(crate) axes: Vec<Option<f64>>,
    /// Offset added to each axis's position.
    pub(crate) offsets: Vec<f64>,
    pub(crate) silent: bool,
    samples: Vec<Option<AxisSample>>,
}

/// The subscription to a far node's axes. Far nodes have two: the other is to their time responses.
pub(crate) const fn of(far: usize) -> usize {
    2 * far
}

impl Far {
    pub(crate) fn new(far: usize, cycle: i64, axes: &[f64]) -> Self {
        Self {
            subscription: of(far),
            epoch: 1,
            cycle,
            next: 0,
            axes: axes.iter().copied().map(Some).collect(),
            offsets: vec![0.0; axes.len()],
            silent: false,
            samples: Vec::with_capacity(axes.len()),
        }
    }

    pub(crate) fn position(velocity: f64, count: f64) -> f64 {
        velocity * count * 1e-3
    }

    /// Sends the frames that arrive until `now`. This does not allocate.
    pub(crate) fn send_until(&mut self, now: Instant<Local>, receiver: &mut Receiver) {
        loop {
            // Primes: 997 messages in sequence have different jitters.
            let jitter = (self.next * 7_919 % 997) as i64;
            let at = Instant::from_nanos(self.next as i64 * self.cycle + 200_000 + jitter);
            if at > now {
                return;
            }
            let count = self.next;
            self.next += 1;
            // A silent node goes on counting, as its cycles run.
            if self.silent {
                continue;
            }
            let header = FrameHeader {
                epoch: self.epoch,
                ..header_of(count)
            };
            let axes = self.axes.iter().zip(&self.offsets);
            self.samples.clear();
            self.samples.extend(axes.map(|(velocity, offset)| {
                let velocity = (*velocity)?;
                Some(AxisSample {
                    set: Kinematics {
                        position: Self::position(velocity, count as f64) + offset,
                        velocity,
                        acceleration: 0.0,
                    },
                    ..AxisSample::default()
                })
            }));
            let axes = &self.samples;
            let message = Message::Frame(Frame { header, axes });
            receiver.receive(at, self.subscription, &message);
        }
    }
}

pub(crate) fn receiver(text: &str) -> Receiver {
    let text = format!("name = 'line'\ncycle-time-us = 1000\n{text}");
    let config: ReceiverConfig = parse("r.toml", &text).expect("a config");
    Receiver::new(&config, Instant::from_nanos(MILLISECOND / 2), 7).expect("a receiver")
}

/// Runs until the receiver's clock shows `until`, and passes on each cycle.
pub(crate) fn run(
    receiver: &mut Receiver,
    far: &mut [Far],
    until: i64,
    mut each: impl FnMut(&SignalRow, i64),
) {
    while receiver.next_cycle().as_nanos() < until {
        let now = receiver.next_cycle();
        for far in &mut *far {
            far.send_until(now, receiver);
        }
        let _ = receiver.cycle(now);
        while receiver.transmit().is_some() {}
        each(&receiver.snapshot().signals, now.as_nanos());
    }
}

/// The header of a master's frame, of its first run with a cycle of 1 ms.
pub(crate) fn header_of(count: u64) -> FrameHeader {
    FrameHeader {
        sender: 1,
        epoch: 1,
        index: CycleIndex::of_count(count),
        count,
        cycle_time: CycleTime::new(Span::from_millis(1)).expect("in range"),
        present_after: None,
        send_stamp: None,
    }
}
