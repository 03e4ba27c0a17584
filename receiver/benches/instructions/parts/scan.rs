//! Whole scans: frames taken in, far axes, slaves, frames sent.

use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node};
use coaxle_receiver::{Receiver, ReceiverConfig};

pub(super) fn one_axis(calls: u32) {
    scans(1, calls);
}

pub(super) fn hundred_axes(calls: u32) {
    scans(100, calls);
}

/// Until the far clock is known and all slaves are coupled.
const LOCKED: i64 = 1_500;

fn scans(axes: usize, calls: u32) {
    let mut text = format!(
        "name = 'line'\ncycle-time-us = 1000\n[[far]]\nnode = 'n0'\naxes = ['1-{axes}']\ndelay = 'off'\n"
    );
    for slave in 1..=axes {
        text += &format!("[[slave]]\nname = 's{slave}'\nmaster = 'n0.{slave}'\n");
    }
    let config: ReceiverConfig = parse("bench", &text).expect("a config");
    let mut receiver = Receiver::new(&config, Instant::EPOCH, 1).expect("a receiver");
    let mut axes = vec![Some(AxisSample::default()); axes];
    for cycle in 0..LOCKED + i64::from(calls) {
        scan(&mut receiver, &mut axes, cycle);
    }
}

fn scan(receiver: &mut Receiver, axes: &mut [Option<AxisSample>], cycle: i64) {
    let at: Instant<Local> = Instant::EPOCH + Span::from_millis(cycle);
    let header = FrameHeader {
        sender: 1,
        epoch: 1,
        index: CycleIndex::of_count(cycle as u64),
        count: cycle as u64,
        cycle_time: CycleTime::new(Span::from_millis(1)).expect("in range"),
        present_after: None,
        send_stamp: None,
    };
    let set = Kinematics {
        position: 0.5 * cycle as f64,
        velocity: 500.0,
        acceleration: 0.0,
    };
    // All axes alike: the cost of an axis does not depend on its values, only the number of axes counts.
    axes.iter_mut().flatten().for_each(|axis| axis.set = set);
    receiver.receive(at, 0, &Message::Frame(Frame { header, axes }));
    let _ = receiver.cycle(at);
    while let Some(outgoing) = receiver.transmit() {
        std::hint::black_box(outgoing.body);
    }
}
