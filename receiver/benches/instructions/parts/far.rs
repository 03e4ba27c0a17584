//! Processing of the far node's data, up to a local master.

use std::hint::black_box;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::observer::{ObserverParameters, PhaseObserver};
use coaxle_clock::time_sync::{TimeSync, TimeSyncParameters};
use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Seconds, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, Intake, Node};
use coaxle_remote::{
    AxisSync, AxisSyncParameters, EncoderMaster, EncoderParameters, EncoderSample, FarAxis,
    FarSync, FrameHistory, KnownMotion, ShownLater,
};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;

const CYCLE: Span = Span::from_millis(1);

fn cycle_start(cycle: i64) -> Instant<Local> {
    Instant::EPOCH + CYCLE * cycle
}

pub(super) fn frame(calls: u32) {
    let frame = frame_of_one_axis();
    let name = NodeName::new("master").expect("a name");
    let mut intake = Intake::new(&name.channel_key(Channel::Axes), &name, &[1]);
    for _ in 0..calls {
        let _ = black_box(intake.accept(black_box(&frame)).is_ok());
    }
}

fn frame_of_one_axis() -> Vec<u8> {
    let config: SenderConfig = parse(
        "bench",
        "name = 'master'\ncycle-time-us = 1000\n[[axis]]\nid = 1\nname = 'conveyor'\n[axis.program]\nstart-velocity = 500.0\n\
         limits = { velocity = 1000.0, acceleration = 5000.0, jerk = 50000.0 }",
    )
    .expect("a config");
    let mut sender = Sender::new(&config, Instant::EPOCH, 1).expect("a sender");
    let seal = KeySeal::new("coaxle/master/axes");
    let mut frame = Vec::new();
    let _ = sender.cycle(cycle_start(0));
    while let Some(outgoing) = sender.transmit() {
        // A stamp such as a sender has: a wake-up of some tens of microseconds.
        seal.seal(outgoing.body, Some(Span::from_micros(40)), &mut frame);
    }
    frame
}

/// An index that beats once a second, as at 1000 ppm.
pub(super) fn time_sync(calls: u32) {
    let mut sync = TimeSync::start(CYCLE, TimeSyncParameters::default()).expect("in range");
    for cycle in 0..u64::from(calls) {
        // A beat per thousand cycles: all branches of a beat are in the average.
        let index = CycleIndex::of_count(cycle + cycle / 1_000);
        let _ = black_box(sync.update(black_box(index), 1));
    }
}

/// A deterministic jitter of 0 to 20 µs, so that every branch is taken.
fn jitter(count: u64) -> Span {
    // Both numbers are prime, so that the values do not repeat within 20 011 messages.
    Span::from_nanos((count.wrapping_mul(7_919) % 20_011) as i64)
}

/// An observer that has locked.
fn observer() -> PhaseObserver {
    let cycle_time = CycleTime::new(CYCLE).expect("a cycle time");
    let parameters = ObserverParameters::default();
    let mut observer = PhaseObserver::new(cycle_time, parameters).expect("an observer");
    for count in 0..LOCKED {
        observer.observe(1, count, cycle_start(count as i64) + jitter(count), None);
        let _ = observer.cycle(cycle_start(count as i64 + 1));
    }
    observer
}

// Four seconds: block lengths have been chosen several times and the filters have settled.
const LOCKED: u64 = 4_000;

pub(super) fn observer_messages(calls: u32) {
    let mut observer = observer();
    for count in LOCKED..LOCKED + u64::from(calls) {
        let at = cycle_start(count as i64) + jitter(count);
        observer.observe(1, count, black_box(at), None);
    }
    let _ = black_box(observer.cycle(cycle_start((LOCKED + u64::from(calls)) as i64)));
}

pub(super) fn observer_cycles(calls: u32) {
    let mut observer = observer();
    for cycle in LOCKED..LOCKED + u64::from(calls) {
        let _ = black_box(observer.cycle(black_box(cycle_start(cycle as i64))));
    }
}

pub(super) fn axis_sync(calls: u32) {
    let mut sync = AxisSync::start(CYCLE, AxisSyncParameters::default()).expect("in range");
    let mut axis = NcToPlcAxis::default();
    for cycle in 0..u64::from(calls) {
        axis.set_position = 0.5 * cycle as f64;
        axis.set_velocity = 500.0;
        let index = CycleIndex::of_count(cycle);
        let clock = Some(Seconds(0.3e-3));
        let _ = black_box(sync.update_by_clock(index, black_box(&axis), clock, 1));
    }
}

/// An axis of a far node whose clock is known: extrapolated …
pub(super) fn axis_now(calls: u32) {
    far_axis(calls, None);
}

/// … and shown 20 ms later, between two frames.
pub(super) fn axis_later(calls: u32) {
    far_axis(calls, Some(Seconds(20e-3)));
}

fn far_axis(calls: u32, by: Option<Seconds>) {
    let parameters = AxisSyncParameters::default();
    let mut clock = FarSync::start(CYCLE, &parameters).expect("in range");
    let mut axis = FarAxis::start(CYCLE, &parameters).expect("in range");
    let mut frames = FrameHistory::new(CYCLE);
    // One correction for all cycles: its cost is that of the clock.
    let correction = clock.update_by_clock(CycleIndex(0), Some(Seconds(2.3e-3)), 1);
    for count in 0..u64::from(calls) {
        let set = Kinematics {
            position: 0.5 * count as f64,
            velocity: 500.0,
            acceleration: 0.0,
        };
        if by.is_some() {
            frames.take(count, black_box(&set), Span::from_millis(20));
        }
        let known = KnownMotion {
            later: by.map(|by| ShownLater {
                frames: &frames,
                by,
            }),
            planned: None,
        };
        let _ = black_box(axis.update(black_box(&set), &correction, known, 1));
    }
}

pub(super) fn encoder(calls: u32) {
    let parameters = EncoderParameters {
        increment: 0.01,
        ..EncoderParameters::default()
    };
    let mut master = EncoderMaster::new(&parameters.checked(CYCLE).expect("in range"));
    for cycle in 0..calls {
        // 73 mm/s; no whole number of increments per cycle, so that edges and equal counts alternate.
        let count = (7.3 * f64::from(cycle)) as u64;
        let sample = Some(EncoderSample::next(black_box(count)));
        let _ = black_box(master.update(sample, Seconds(2e-3), 1));
    }
}
