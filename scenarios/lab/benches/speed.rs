//! Cost of a frame, a cycle and a virtual second: `cargo bench -p coaxle-lab`.

use std::hint::black_box;
use std::time::Duration;

use coaxle_clock::observer::{ObserverParameters, PhaseObserver};
use coaxle_clock::{CycleTime, Instant, Local, Span};
use coaxle_lab::virtual_time;
use coaxle_node::config::parse;
use coaxle_node::frame::KeySeal;
use coaxle_node::keys::NodeName;
use coaxle_node::{Channel, Intake, KeptMessage, Node};
use coaxle_receiver::{Receiver, ReceiverConfig};
use coaxle_sender::Sender;
use coaxle_sender::config::SenderConfig;
use criterion::{Criterion, criterion_group, criterion_main};

const CYCLE: Span = Span::from_millis(1);

fn sender() -> Sender {
    let config: SenderConfig = parse(
        "bench",
        r#"
        name = "master"
        cycle-time-us = 1000
        [[axis]]
        id = 1
        name = "conveyor"
        [axis.program]
        start-velocity = 500.0
        limits = { velocity = 1000.0, acceleration = 5000.0, jerk = 50000.0 }
        "#,
    )
    .expect("a config");
    Sender::new(&config, Instant::EPOCH, 1).expect("a sender")
}

fn receiver() -> Receiver {
    let config: ReceiverConfig = parse(
        "bench",
        "name = \"saw\"\ncycle-time-us = 1000\nmaster = { node = \"master\" }",
    )
    .expect("a config");
    Receiver::new(&config, Instant::EPOCH, 1).expect("a receiver")
}

fn cycle_start(cycle: i64) -> Instant<Local> {
    Instant::EPOCH + CYCLE * cycle
}

/// The frames of the first cycles of a sender.
fn frames(count: i64) -> Vec<Vec<u8>> {
    let seal = KeySeal::new("coaxle/master/axes");
    let mut sender = sender();
    (0..count)
        .map(|cycle| {
            let _ = sender.cycle(cycle_start(cycle));
            let mut frame = Vec::new();
            while let Some(outgoing) = sender.transmit() {
                seal.seal(outgoing.body, Some(Span::from_micros(40)), &mut frame);
            }
            frame
        })
        .collect()
}

fn frame_and_cycles(c: &mut Criterion) {
    // Twenty seconds: the observer is locked for most of them, so that the usual branches are measured.
    let frames = frames(20_000);
    let name = NodeName::new("master").expect("a name");
    let mut intake = Intake::new(&name.channel_key(Channel::Axes), &name, &[1]);
    c.bench_function("accept a frame of one axis", |b| {
        b.iter(|| intake.accept(black_box(&frames[7])).is_ok());
    });

    let mut sender = sender();
    let mut cycle = 0;
    c.bench_function("sender: cycle with one axis, frame encoded", |b| {
        b.iter(|| {
            let _ = sender.cycle(cycle_start(cycle));
            cycle += 1;
            while let Some(outgoing) = sender.transmit() {
                black_box(outgoing.body);
            }
        });
    });

    let kept = frames
        .iter()
        .map(|frame| KeptMessage::new(&intake.message(frame)));
    let messages: Vec<KeptMessage> = kept.collect();
    c.bench_function("receiver: 20 000 messages and cycles, slave encoded", |b| {
        b.iter_batched_ref(
            receiver,
            |receiver| {
                for (cycle, message) in messages.iter().enumerate() {
                    let at = cycle_start(cycle as i64);
                    receiver.receive(at, 0, &message.get());
                    let _ = receiver.cycle(at);
                    while let Some(outgoing) = receiver.transmit() {
                        black_box(outgoing.body);
                    }
                }
            },
            criterion::BatchSize::LargeInput,
        );
    });
}

fn observer(c: &mut Criterion) {
    let cycle_time = CycleTime::new(CYCLE).expect("a cycle time");
    let mut observer =
        PhaseObserver::new(cycle_time, ObserverParameters::default()).expect("an observer");
    // A deterministic jitter of 0 to 20 µs, so that every branch is taken.
    let jitter = |count: u64| Span::from_nanos((count.wrapping_mul(7_919) % 20_011) as i64);
    let mut count = 0_u64;
    c.bench_function("phase observer: one message", |b| {
        b.iter(|| {
            let at = cycle_start(count as i64) + jitter(count);
            observer.observe(1, count, at, None);
            count += 1;
        });
    });
    let mut cycle = count as i64;
    c.bench_function("phase observer: one cycle", |b| {
        b.iter(|| {
            cycle += 1;
            black_box(observer.cycle(cycle_start(cycle)))
        });
    });
}

fn virtual_time(c: &mut Criterion) {
    let mut scenario = coaxle_lab::catalog::find("beat")
        .and_then(|source| source.read(&["duration-s=10".to_owned()]))
        .expect("a scenario of the catalogue");
    scenario
        // A single receiver, so that the figure is the cost of one.
        .keep_receivers(&["sync".to_owned()])
        .expect("a receiver of the scenario");
    c.bench_function("ten virtual seconds of one sender and one receiver", |b| {
        b.iter(|| virtual_time::run(&scenario, &mut (), &mut ()));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().measurement_time(Duration::from_secs(3)).sample_size(20);
    targets = frame_and_cycles, observer, virtual_time
}
criterion_main!(benches);
