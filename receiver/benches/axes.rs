//! Cost of a scan with many far axes and slaves: `cargo bench -p coaxle-receiver`.

use std::time::Duration;

use coaxle_clock::{CycleIndex, CycleTime, Instant, Local, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_node::{AxisSample, Frame, FrameHeader, Message, Node, PresentAfter};
use coaxle_receiver::{Receiver, ReceiverConfig};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

/// A frame holds at most 128.
const AXES_OF_A_NODE: usize = 100;

/// A receiver of this number of far axes and slaves, and the frames of its far nodes.
struct Bench {
    receiver: Receiver,
    nodes: Vec<Vec<Option<AxisSample>>>,
    cycle: i64,
    /// Time by which the axes are shown later.
    present_after: Option<PresentAfter>,
}

impl Bench {
    fn new(axes: usize, slaves: usize, limits: &str) -> Self {
        Self::shown(axes, slaves, limits, None)
    }

    fn shown(
        axes: usize,
        slaves: usize,
        limits: &str,
        present_after: Option<PresentAfter>,
    ) -> Self {
        let mut text = "name = 'line'\ncycle-time-us = 1000\n".to_owned();
        let mut nodes = Vec::new();
        for first in (0..axes).step_by(AXES_OF_A_NODE) {
            let count = AXES_OF_A_NODE.min(axes - first);
            let node = nodes.len();
            // Without time requests, whose responses would have to be simulated too.
            text += &format!("[[far]]\nnode = 'n{node}'\naxes = ['1-{count}']\ndelay = 'off'\n");
            nodes.push(vec![Some(AxisSample::default()); count]);
        }
        for slave in 0..slaves {
            let (node, axis) = (slave / AXES_OF_A_NODE, slave % AXES_OF_A_NODE + 1);
            text += &format!("[[slave]]\nname = 's{slave}'\nmaster = 'n{node}.{axis}'\n{limits}\n");
        }
        let config: ReceiverConfig = parse("bench", &text).expect("a config");
        let receiver = Receiver::new(&config, Instant::EPOCH, 1).expect("a receiver");
        let mut bench = Self {
            receiver,
            nodes,
            cycle: 0,
            present_after,
        };
        // Until the far clocks are known and all slaves coupled.
        // Three seconds of the receiver: clocks are known after one or two, and slaves couple then.
        (0..3_000).for_each(|_| bench.scan());
        bench
    }

    /// Takes in a frame of each node, runs the cycle, and takes its output.
    fn scan(&mut self) {
        let at: Instant<Local> = Instant::EPOCH + Span::from_millis(self.cycle);
        let header = FrameHeader {
            sender: 1,
            epoch: 1,
            index: CycleIndex::of_count(self.cycle as u64),
            count: self.cycle as u64,
            cycle_time: CycleTime::new(Span::from_millis(1)).expect("in range"),
            present_after: self.present_after,
            send_stamp: None,
        };
        let set = Kinematics {
            position: 0.5 * self.cycle as f64,
            velocity: 500.0,
            acceleration: 0.0,
        };
        for (node, axes) in self.nodes.iter_mut().enumerate() {
            axes.iter_mut().flatten().for_each(|axis| axis.set = set);
            let message = Message::Frame(Frame { header, axes });
            // Two subscriptions per node: its axes, and its time responses.
            self.receiver.receive(at, 2 * node, &message);
        }
        let _ = self.receiver.cycle(at);
        while let Some(outgoing) = self.receiver.transmit() {
            // Otherwise the encoding of an output that nobody reads could be optimised away.
            std::hint::black_box(outgoing.body);
        }
        self.cycle += 1;
    }
}

fn axes(c: &mut Criterion) {
    // High enough for the guard to pass the coupled motion: the cost of passing is the usual one.
    const LIMITS: &str = "limits = { velocity = 2000, acceleration = 100000, jerk = 1e7 }";
    let mut whole = |name: &str, counts: &[usize], bench: fn(usize) -> Bench| {
        let mut group = c.benchmark_group(name);
        for &count in counts {
            group.throughput(Throughput::Elements(count as u64));
            let mut bench = bench(count);
            group.bench_function(BenchmarkId::from_parameter(count), |b| {
                b.iter(|| bench.scan())
            });
        }
        group.finish();
    };
    whole("scan: far axes", &[1, 10, 100, 300, 1000], |n| {
        Bench::new(n, 0, "")
    });
    whole("scan: far axes, shown 20 ms later", &[1, 100], |n| {
        Bench::shown(n, 0, "", PresentAfter::new(Span::from_millis(20)))
    });
    whole(
        "scan: far axes, shown 20 ms later, each with a slave by a gear",
        &[1, 100],
        |n| Bench::shown(n, n, "", PresentAfter::new(Span::from_millis(20))),
    );
    whole(
        "scan: far axes, each with a slave by a gear",
        &[1, 10, 100],
        |n| Bench::new(n, n, ""),
    );
    whole("scan: the same with limits", &[1, 10, 100], |n| {
        Bench::new(n, n, LIMITS)
    });
    whole(
        "scan: 300 far axes of 3 nodes, slaves",
        &[1, 10, 100],
        |n| Bench::new(300, n, ""),
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .sample_size(20);
    targets = axes
}
criterion_main!(benches);
