//! A chain of nodes that show one instant of a master: each slave is held back by what its followers need.

use std::collections::BinaryHeap;

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{Instant, Span};
use coaxle_node::config::parse;
use coaxle_node::frame::seal;
use coaxle_node::keys::NodeName;
use coaxle_node::{AxisSample, Channel, Frame, FrameHeader, Intake, Message, Node, PresentAfter};
use coaxle_receiver::{Receiver, ReceiverConfig};

use crate::nodes::{self, MILLISECOND, to_and_fro as master};

/// Drift of the master's clock, and of those of the stages.
const DRIFTS: [f64; 4] = [40e-6, -60e-6, 80e-6, -20e-6];

/// A way from one node to the next.
#[derive(Clone, Copy)]
struct Way {
    least: i64,
    jitter: i64,
    loss: u64,
}

/// 20 ± 10 ms, of which one in twenty messages is lost.
const ROUGH: Way = Way {
    least: 10 * MILLISECOND,
    jitter: 20 * MILLISECOND,
    loss: 20,
};
const EVEN: Way = Way {
    least: 2 * MILLISECOND,
    jitter: 2_000,
    loss: u64::MAX,
};

/// A message under way, the first to arrive on top.
#[derive(PartialEq, Eq)]
struct UnderWay {
    at: i64,
    payload: Payload,
}

#[derive(PartialEq, Eq)]
enum Payload {
    Master(u64),
    Slaves(Vec<u8>),
}

impl Ord for UnderWay {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.at.cmp(&self.at)
    }
}

impl PartialOrd for UnderWay {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

struct Stage {
    receiver: Receiver,
    intake: Intake,
    drift: f64,
    inbox: BinaryHeap<UnderWay>,
    /// Time of the master that the set values of each cycle show, s; NaN before.
    labels: Vec<f64>,
    /// The cycle in which the drive is given them.
    due: Vec<f64>,
    first: u64,
}

impl Stage {
    fn new(n: usize, rest: &str, drift: f64) -> Self {
        let before = match n {
            0 => "node = 'a'".to_owned(),
            n => format!("node = 's{}', channel = 'slaves'", n - 1),
        };
        let text = format!(
            "name = 's{n}'\ncycle-time-us = 1000\nmaster = {{ {before} }}\n{rest}\n\
             sync.time-sync = {{ age-of-data-limit = 500, max-cycle-index-difference = 500 }}\n\
             slave = [{{ limits = {{ velocity = 1000, acceleration = 20000, jerk = 5000000 }} }}]"
        );
        let config: ReceiverConfig = parse("s.toml", &text).expect("a config");
        let key = format!("coaxle/s{}/slaves", n.wrapping_sub(1));
        let sender = NodeName::new(format!("s{}", n.wrapping_sub(1)));
        let sender = sender.unwrap_or_else(|_| NodeName::new("none").expect("a name"));
        // Phases of their own.
        let start = MILLISECOND / 7 * (n as i64 + 1);
        let receiver = Receiver::new(&config, Instant::from_nanos(start), 7 + n as u64);
        Self {
            receiver: receiver.expect("a receiver"),
            intake: Intake::new(&key, &sender, &[1]),
            drift,
            inbox: BinaryHeap::with_capacity(1_000),
            labels: Vec::new(),
            due: Vec::new(),
            first: 0,
        }
    }

    /// Own time at a true one, ns, and back.
    fn own(&self, truth: i64) -> i64 {
        truth + (truth as f64 * self.drift) as i64
    }

    fn truth(&self, own: i64) -> i64 {
        (own as f64 / (1.0 + self.drift)) as i64
    }

    /// Time of the master that is shown at a fraction of a cycle.
    fn label(&self, cycle: f64) -> Option<f64> {
        let since = cycle - self.first as f64;
        let n = since.floor();
        let pair = self.labels.get(n as usize..n as usize + 2)?;
        (since >= 0.0).then(|| pair[0] + (pair[1] - pair[0]) * (since - n))
    }
}

impl Stage {
    /// Time of the master that the drive shows in a cycle.
    fn shown_label(&self, cycle: f64) -> f64 {
        let after = self.due.partition_point(|due| *due < cycle);
        if self.due[after] == cycle {
            return self.labels[after];
        }
        let (before, gap) = (after - 1, self.due[after] - self.due[after - 1]);
        let share = (cycle - self.due[before]) / gap;
        self.labels[before] + (self.labels[after] - self.labels[before]) * share
    }
}

struct Chain {
    stages: Vec<Stage>,
    way: Way,
    delay: Span,
    next: u64,
    random: u64,
    /// The largest distances of a drive from the master at the instant that it shows, and of that instant from the one
    /// that it is to show, after `judged_from`.
    off: f64,
    label_off: f64,
    judged_from: f64,
    judged: usize,
    /// The last positions shown, for their accelerations.
    shown: Vec<[f64; 3]>,
    hardest: f64,
}

impl Chain {
    fn new(lags: &[&str], way: Way, delay: Span) -> Self {
        let fixed = way.least as f64 / 1e3;
        let rest = |lag: &str| format!("delay = {{ fixed-us = {fixed} }}\nlag-ms = {lag}");
        let stages: Vec<_> = (lags.iter().enumerate())
            .map(|(n, lag)| Stage::new(n, &rest(lag), DRIFTS[n + 1]))
            .collect();
        Self {
            shown: vec![[0.0; 3]; stages.len()],
            stages,
            way,
            delay,
            next: 0,
            random: 1,
            off: 0.0,
            label_off: 0.0,
            judged_from: f64::MAX,
            judged: 0,
            hardest: 0.0,
        }
    }

    fn draw(&mut self) -> u64 {
        // Knuth's MMIX generator, whose upper bits are random.
        self.random = (self.random)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        self.random >> 33
    }

    fn send(&mut self, to: usize, truth: i64, payload: Payload) {
        let (lost, jitter) = (self.draw(), self.draw());
        if lost.is_multiple_of(self.way.loss) && self.way.loss != u64::MAX {
            return;
        }
        let at = truth + self.way.least + (jitter % self.way.jitter as u64) as i64;
        self.stages[to].inbox.push(UnderWay { at, payload });
    }

    fn run(&mut self, until_s: f64) {
        loop {
            let next = |stage: &Stage| stage.truth(stage.receiver.next_cycle().as_nanos());
            let times = self.stages.iter().map(next).enumerate();
            let (n, truth) = times.min_by_key(|(_, at)| *at).expect("stages");
            if truth as f64 > until_s * 1e9 {
                return;
            }
            loop {
                let sent = (self.next as f64 * 1e6 / (1.0 + DRIFTS[0])) as i64;
                if sent > truth {
                    break;
                }
                let count = self.next;
                self.next += 1;
                self.send(0, sent, Payload::Master(count));
            }
            self.cycle(n, truth);
        }
    }

    fn cycle(&mut self, n: usize, truth: i64) {
        let stage = &mut self.stages[n];
        while stage
            .inbox
            .peek()
            .is_some_and(|message| message.at <= truth)
        {
            let Some(UnderWay { at, payload }) = stage.inbox.pop() else {
                break;
            };
            let at = Instant::from_nanos(stage.own(at));
            match payload {
                Payload::Slaves(bytes) => {
                    let message = stage.intake.message(&bytes);
                    stage.receiver.receive(at, 0, &message);
                }
                Payload::Master(count) => {
                    let header = FrameHeader {
                        present_after: PresentAfter::new(self.delay),
                        send_stamp: Some(Span::ZERO),
                        ..nodes::header_of(count)
                    };
                    let set = master(count as f64 * 1e-3);
                    let axes = &[Some(AxisSample {
                        set,
                        ..AxisSample::default()
                    })];
                    let message = Message::Frame(Frame { header, axes });
                    stage.receiver.receive(at, 0, &message);
                }
            }
        }
        let now = stage.receiver.next_cycle();
        let receiver = &mut stage.receiver;
        let _ = assert_no_alloc(|| receiver.cycle(now));
        let mut frame = None;
        while let Some(outgoing) = stage.receiver.transmit() {
            if outgoing.channel == Channel::Slaves {
                let sealed = frame.insert(Vec::new());
                let key = format!("coaxle/s{n}/slaves");
                seal(&key, outgoing.body, Some(Span::ZERO), sealed);
            }
        }
        self.note(n);
        if let Some(frame) = frame
            && n + 1 < self.stages.len()
        {
            self.send(n + 1, truth, Payload::Slaves(frame));
        }
        self.judge(n, truth);
    }

    /// Notes which time of the master the set values of this cycle show.
    fn note(&mut self, n: usize) {
        let signals = &self.stages[n].receiver.snapshot().signals;
        let (cycle, far) = (signals.node.cycle, signals.axes[0].far_time_ns);
        let hold_back = signals.node.hold_back_us;
        let label = match (far, n) {
            (None, _) => None,
            (Some(far), 0) => Some(far as f64 * 1e-9),
            (Some(far), n) => self.stages[n - 1].label(far as f64 * 1e-6),
        };
        let stage = &mut self.stages[n];
        if stage.labels.is_empty() {
            stage.first = cycle;
        }
        stage.labels.push(label.unwrap_or(f64::NAN));
        stage.due.push(cycle as f64 + hold_back / 1e3);
    }

    fn judge(&mut self, n: usize, truth: i64) {
        let stage = &self.stages[n];
        let signals = &stage.receiver.snapshot().signals;
        let Some(shown) = signals.slaves[0].shown_position else {
            return;
        };
        let before = self.shown[n];
        self.shown[n] = [before[1], before[2], shown];
        if (truth as f64) < self.judged_from * 1e9 {
            return;
        }
        let acceleration = (shown - 2.0 * before[2] + before[1]) * 1e6;
        self.hardest = self.hardest.max(acceleration.abs());
        let label = stage.shown_label(signals.node.cycle as f64);
        self.off = self.off.max((shown - master(label).position).abs());
        let wanted = truth as f64 * 1e-9 * (1.0 + DRIFTS[0]) - self.delay.as_secs_f64();
        self.label_off = self.label_off.max((label - wanted).abs());
        self.judged += 1;
    }

    fn hold_backs_ms(&self) -> Vec<f64> {
        let by = |stage: &Stage| stage.receiver.snapshot().signals.node.hold_back_us / 1e3;
        self.stages.iter().map(by).collect()
    }
}

#[test]
fn over_rough_ways_all_drives_show_one_instant() {
    let delay = Span::from_millis(150);
    let mut chain = Chain::new(&["40", "40", "40"], ROUGH, delay);
    chain.run(40.0);
    assert_eq!(chain.hold_backs_ms(), [110.0, 70.0, 30.0]);
    chain.judged_from = 40.0;
    chain.run(55.0);
    assert!(chain.judged > 44_000, "{}", chain.judged);
    // Each behind its own time error, which the labels contain: a nanometre.
    assert!(chain.off < 1e-3, "{}", chain.off);
    // The errors of three clocks, of ways that vary by 20 ms.
    assert!(chain.label_off < 2e-3, "{}", chain.label_off);
    assert!(chain.hardest < 5_200.0, "{}", chain.hardest);
}

/// What a hold-back has in the own time is converted into that of the far clock: 100 ppm of 140 ms would be 14 µs.
#[test]
fn over_even_ways_the_instant_is_that_of_the_master() {
    let mut chain = Chain::new(&["10", "10", "'full'"], EVEN, Span::from_millis(150));
    chain.run(15.0);
    assert_eq!(chain.hold_backs_ms(), [140.0, 130.0, 0.0]);
    chain.judged_from = 15.0;
    chain.run(25.0);
    assert!(chain.off < 1e-4, "{}", chain.off);
    assert!(chain.label_off < 4e-6, "{}", chain.label_off);
}

#[test]
fn a_lag_finds_what_the_frames_need() {
    let mut chain = Chain::new(
        &["'auto'", "'auto'", "'full'"],
        ROUGH,
        Span::from_millis(150),
    );
    // Each stage is in sync only after the one before.
    chain.run(90.0);
    let [first, second, last] = chain.hold_backs_ms()[..] else {
        panic!("three stages");
    };
    // Of some twenty frames under way the first to arrive counts: 10 ms, some more, and a margin.
    assert!((100.0..135.0).contains(&first), "{first}");
    assert!((60.0..120.0).contains(&second), "{second}");
    assert_eq!(last, 0.0);
    chain.judged_from = 90.0;
    chain.run(100.0);
    assert!(chain.off < 1e-3, "{}", chain.off);
    assert!(chain.hardest < 5_600.0, "{}", chain.hardest);
}

#[test]
fn a_delay_below_the_hold_back_and_another_one_are_no_step_of_a_drive() {
    let mut chain = Chain::new(&["5"], EVEN, Span::from_millis(50));
    chain.run(5.0);
    assert_eq!(chain.hold_backs_ms(), [45.0]);
    chain.judged_from = f64::MAX;
    for (until, millis) in [(8.0, 20), (11.0, 0), (14.0, 80)] {
        chain.delay = Span::from_millis(millis);
        chain.run(until);
        let signals = &chain.stages[0].receiver.snapshot().signals;
        assert_eq!(signals.slaves[0].error, 0, "{millis}");
    }
}

/// The root of a line: its own slaves are held back, and their followers have the time for their way.
#[test]
fn slaves_of_a_virtual_axis_are_held_back_by_it() {
    let text = "name = 'root'\ncycle-time-us = 1000\n[[virtual-axis]]\nid = 1\nname = 'shaft'\npresent-after-ms = 8.4\n\
        [virtual-axis.program]\nlimits = { velocity = 500, acceleration = 4000, jerk = 100000 }\n\
        steps = [{ enable = true }, { dwell = { for-s = 0.1 } }, { velocity = { value = 400, for-s = 1 } }, { velocity = { value = 0 } }]\n\
        [[slave]]\nmaster = 'shaft'\nlimits = { velocity = 1000, acceleration = 6000, jerk = 120000 }";
    let config: ReceiverConfig = parse("root.toml", text).expect("a config");
    let start = Instant::from_nanos(MILLISECOND);
    let mut receiver = Receiver::new(&config, start, 7).expect("a receiver");
    let (mut positions, mut stated) = (Vec::new(), None);
    for _ in 0..3_000 {
        let now = receiver.next_cycle();
        let _ = assert_no_alloc(|| receiver.cycle(now));
        while let Some(outgoing) = receiver.transmit() {
            if outgoing.channel == Channel::Slaves {
                let mut sealed = Vec::new();
                seal("coaxle/root/slaves", outgoing.body, None, &mut sealed);
                let name = NodeName::new("root").expect("a name");
                let mut intake = Intake::new("coaxle/root/slaves", &name, &[1]);
                if let Message::Frame(frame) = intake.message(&sealed) {
                    stated = frame.header.present_after.map(PresentAfter::span);
                }
            }
        }
        let signals = &receiver.snapshot().signals;
        let slave = &signals.slaves[0];
        positions.push((slave.position, slave.shown_position));
        // It lags by what is no whole cycle.
        assert_eq!(signals.node.hold_back_us, 8_000.0);
    }
    assert_eq!(stated, Some(Span::from_millis(8)));
    let moved = positions.last().expect("cycles").0.expect("coupled");
    assert!(moved > 300.0, "{moved}");
    for pair in positions.windows(9).skip(20) {
        assert_eq!(pair[8].1, pair[0].0);
    }
}
