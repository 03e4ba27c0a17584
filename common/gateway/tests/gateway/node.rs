//! The gateway node in virtual time: a PLC with a clock of its own, polled or notifying, and a receiver's far clock behind.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use coaxle_axis::NcToPlcAxis;
use coaxle_clock::far_clock::DelaySource;
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleIndex, CycleTime, FarClock, Instant, Local, Span};
use coaxle_gateway::config::GatewayConfig;
use coaxle_gateway::polled::PollPauses;
use coaxle_gateway::{Gateway, LinkState, PlcOutput, PlcSample, Port};
use coaxle_node::config::parse;
use coaxle_node::frame::{FrameHeader, KeySeal, sender_id};
use coaxle_node::{AxisSample, Channel, Frame, Message, Node, TimeRequest};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

const CYCLE: i64 = 1_000_000;

fn config() -> GatewayConfig {
    let text = "name = 'plc'\ncycle-time-us = 1000\n[pipe]\n[[axis]]\nid = 7\nname = 'belt'\n\
                [[output]]\nnode = 'saw'\n[[output.axis]]\nid = 3\n";
    let config: GatewayConfig = parse("g", text).expect("it is there");
    config.check().expect("it is there");
    config
}

/// Messages between a PLC and the node.
struct Wires {
    samples: VecDeque<PlcSample>,
    given: Given,
}

/// Outputs to the PLC.
type Given = Rc<RefCell<Vec<(u16, Option<NcToPlcAxis>)>>>;

impl Port for Wires {
    fn receive(&mut self, now: Instant<Local>, sample: &mut PlcSample) -> bool {
        // The node gets nothing before its time.
        // Half of the cycle of 1 ms.
        let scan = Span::from_micros(500);
        if self.samples.front().is_none_or(|next| next.at > now + scan) {
            return false;
        }
        let next = self.samples.pop_front().expect("it is there");
        sample.replace(&next);
        true
    }

    fn send(&mut self, output: &PlcOutput<'_>) {
        let output = (output.index.0, output.axes[0]);
        self.given.borrow_mut().push(output);
    }

    fn state(&self) -> LinkState {
        LinkState {
            is_up: true,
            connections: 1,
            ..LinkState::default()
        }
    }
}

fn random(source: &mut Xoshiro256PlusPlus, below: f64) -> f64 {
    // The upper 53 bits: as many as a float has.
    below * (source.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A PLC with a clock slow by this drift, and cycles that begin at 0.
#[derive(Clone, Copy)]
struct Plc {
    drift_ppm: f64,
    first_index: u16,
}

impl Plc {
    /// Returns the real start of its cycle number `n`, ns.
    fn start(&self, n: i64) -> f64 {
        (n * CYCLE) as f64 * (1.0 + self.drift_ppm * 1e-6)
    }

    fn cycle_at(&self, at: f64) -> i64 {
        (at / (CYCLE as f64 * (1.0 + self.drift_ppm * 1e-6))).floor() as i64
    }

    fn sample(&self, n: i64, at: f64, connection: u32) -> PlcSample {
        let axis = NcToPlcAxis {
            set_position: n as f64,
            ..NcToPlcAxis::default()
        };
        PlcSample {
            at: Instant::from_nanos(at as i64),
            index: CycleIndex(self.first_index.wrapping_add(n as u16)),
            connection,
            axes: vec![axis].into(),
        }
    }

    /// Returns samples polled at half of its cycle; a read takes 60 µs.
    fn polled(&self, seconds: i64) -> VecDeque<PlcSample> {
        let (mut pauses, mut at, mut before) = (PollPauses::default(), 250_000.0, -1);
        let mut samples = VecDeque::new();
        while at < seconds as f64 * 1e9 {
            let n = self.cycle_at(at);
            if n != before {
                before = n;
                samples.push_back(self.sample(n, at + 60_000.0, 1));
            }
            // Parts of half a cycle.
            at += 500_000.0 * pauses.next_part();
        }
        samples
    }

    /// Returns samples sent in each cycle; that takes 80 µs, and up to 40 more.
    fn notifying(&self, seconds: i64) -> VecDeque<PlcSample> {
        let mut random_numbers = Xoshiro256PlusPlus::seed_from_u64(1);
        let cycles = 0..self.cycle_at(seconds as f64 * 1e9);
        let sample = |n| {
            let late = 80_000.0 + random(&mut random_numbers, 40_000.0);
            self.sample(n, self.start(n) + late, 1)
        };
        cycles.map(sample).collect()
    }
}

/// A frame that was sent, with its stamp.
struct Sent {
    header: FrameHeader,
    axis: NcToPlcAxis,
    /// Ideal start of its cycle, by the gateway's clock.
    start: Instant<Local>,
    at: Instant<Local>,
}

/// Runs the node for this time, woken 20 µs late in each cycle; returns the published frames.
fn run(gateway: &mut Gateway<Wires>, seconds: i64) -> Vec<Sent> {
    run_woken(gateway, seconds, || Span::from_micros(20))
}

/// Runs the node for this time, woken that much after the ideal start of each cycle.
fn run_woken(
    gateway: &mut Gateway<Wires>,
    seconds: i64,
    mut lateness: impl FnMut() -> Span,
) -> Vec<Sent> {
    let seal = KeySeal::new("coaxle/plc/axes");
    let (mut sent, mut bytes) = (Vec::new(), Vec::new());
    let end = Instant::EPOCH + Span::from_secs(seconds);
    while gateway.next_cycle() < end {
        let now = gateway.next_cycle() + lateness();
        let _ = gateway.cycle(now);
        while let Some(outgoing) = gateway.transmit() {
            if outgoing.channel != Channel::Axes {
                continue;
            }
            let at = now + Span::from_micros(15);
            seal.seal(outgoing.body, Some(at - outgoing.ideal_start), &mut bytes);
            let mut axis = NcToPlcAxis::default();
            let header = seal.open(&bytes, |of| axis = *of).expect("it is there");
            let start = outgoing.ideal_start;
            sent.push(Sent {
                header,
                axis,
                start,
                at,
            });
        }
    }
    sent
}

fn gateway(samples: VecDeque<PlcSample>) -> Gateway<Wires> {
    gateway_that_gives(samples, Given::default())
}

fn gateway_that_gives(samples: VecDeque<PlcSample>, given: Given) -> Gateway<Wires> {
    let wires = Wires { samples, given };
    Gateway::new(&config(), wires, Instant::EPOCH, 1_000)
}

#[test]
fn each_cycle_of_the_plc_is_published_once_with_its_count_and_index() {
    let plc = Plc {
        drift_ppm: 80.0,
        first_index: 65_000,
    };
    let mut gateway = gateway(plc.notifying(5));
    let sent = run(&mut gateway, 5);
    let newest = sent.last().expect("it is there");
    // 5000 cycles, less those of the first second, in which the clock becomes known.
    assert!(sent.len() > 3_500, "{}", sent.len());
    for frame in &sent {
        let header = frame.header;
        assert_eq!(header.count, 65_000 + frame.axis.set_position as u64);
        assert_eq!(header.index, CycleIndex::of_count(header.count));
        assert_eq!((header.epoch, frame.axis.axis_id), (1_000, 7));
        assert_eq!(header.cycle_time.span(), Span::from_nanos(CYCLE));
    }
    let counts: Vec<_> = sent.iter().map(|frame| frame.header.count).collect();
    assert!(counts.windows(2).all(|pair| pair[1] > pair[0]));
    let signals = gateway.snapshot().signals.node;
    assert_eq!(signals.plc_count, newest.header.count);
    assert!((signals.plc_drift_ppm.expect("it is there") + 80.0).abs() < 1.0);
    assert_eq!(signals.plc_missed, 0);
}

/// The lines on which the cycles lie are those of the samples: waking late or early moves none of them.
#[test]
fn the_jitter_of_its_own_wake_ups_is_not_in_the_starts_of_the_plcs_cycles() {
    let plc = Plc {
        drift_ppm: 80.0,
        first_index: 0,
    };
    let mut random_numbers = Xoshiro256PlusPlus::seed_from_u64(3);
    // Early wake-ups too: cycle jitter has both signs. Less than half a scan of 500 µs, so that none is missed.
    let jitter = || Span::from_micros_f64(random(&mut random_numbers, 400.0) - 100.0);
    let punctual = run(&mut gateway(plc.notifying(5)), 5);
    let jittered = run_woken(&mut gateway(plc.notifying(5)), 5, jitter);
    assert!(punctual.len() > 3_500, "{}", punctual.len());
    let starts = |sent: &[Sent]| -> Vec<_> {
        let of_frame = |frame: &Sent| (frame.header.count, frame.start);
        sent.iter().map(of_frame).collect()
    };
    assert_eq!(starts(&punctual), starts(&jittered));
}

#[test]
fn a_plc_that_starts_anew_or_comes_over_another_connection_is_another_run() {
    let plc = Plc {
        drift_ppm: -20.0,
        first_index: 40_000,
    };
    let mut samples: VecDeque<_> = plc.notifying(8);
    for sample in &mut samples {
        let seconds = sample.at.as_nanos() / 1_000_000_000;
        if seconds >= 3 {
            // 20 000 cycles are 20 s of difference: far beyond the tolerance of 0.1 s.
            sample.index = CycleIndex(sample.index.0.wrapping_sub(20_000));
        }
        if seconds >= 5 {
            sample.connection = 2;
        }
    }
    let sent = run(&mut gateway(samples), 8);
    let mut epochs: Vec<_> = sent.iter().map(|frame| frame.header.epoch).collect();
    epochs.dedup();
    assert_eq!(epochs, [1_000, 1_001, 1_002]);
}

#[test]
fn a_plc_that_falls_silent_publishes_nothing_and_nothing_is_replayed() {
    let plc = Plc {
        drift_ppm: 0.0,
        first_index: 0,
    };
    let mut samples = plc.notifying(4);
    samples.retain(|sample| sample.at.as_nanos() < 2_000_000_000);
    let mut gateway = gateway(samples);
    let sent = run(&mut gateway, 4);
    let last = sent.last().expect("it is there");
    // The last sample may be taken by the next scan, and published 20 µs later.
    assert!(last.at < Instant::from_nanos(2_002_000_000));
}

#[test]
fn time_responses_are_about_the_clock_of_the_plc() {
    let plc = Plc {
        drift_ppm: 80.0,
        first_index: 500,
    };
    let mut gateway = gateway(plc.notifying(4));
    let request = TimeRequest {
        requester: 5,
        run: 6,
        number: 7,
        requested: 8,
    };
    let asked = |gateway: &mut Gateway<Wires>, at| {
        gateway.receive(at, 0, &Message::TimeRequest(request));
    };
    // Before its clock is known there is no response.
    asked(&mut gateway, Instant::EPOCH);
    let _ = run(&mut gateway, 3);
    assert_eq!(gateway.snapshot().signals.node.requests_answered, 0);
    let at = gateway.next_cycle() - Span::from_micros(130);
    asked(&mut gateway, at);
    let now = gateway.next_cycle();
    let _ = gateway.cycle(now);
    let seal = KeySeal::new("coaxle/plc/time-responses");
    let (mut bytes, mut responses) = (Vec::new(), Vec::new());
    while let Some(outgoing) = gateway.transmit() {
        if outgoing.channel == Channel::TimeResponses {
            let stamp = now - outgoing.ideal_start;
            seal.seal(outgoing.body, Some(stamp), &mut bytes);
            let sender = sender_id(&config().name);
            seal.open_time_responses(&bytes, sender, 5, |response| responses.push(*response))
                .expect("it is there");
        }
    }
    let [response] = responses[..] else {
        panic!("{responses:?}");
    };
    assert_eq!((response.epoch, response.number), (1_000, 7));
    // Reading takes 100 µs on average, which counts as part of the PLC.
    let shows = |at: Instant<Local>| {
        let since = at.as_nanos() as f64 / (1.0 + plc.drift_ppm * 1e-6);
        // 80 µs, and 20 of the 40 that vary.
        since + (500 * CYCLE) as f64 - 100_000.0
    };
    let received = response.received.as_nanos() as f64 - shows(at);
    let responded = response.responded.as_nanos() as f64 - shows(now);
    // The jitter of reading is ±20 µs about its mean.
    assert!(received.abs() < 25_000.0, "{received}");
    assert!(responded.abs() < 25_000.0, "{responded}");
    // Both lie on one line: only its slope counts over the 130 µs between them.
    assert!((received - responded).abs() < 500.0);
}

#[test]
fn what_a_receiver_sends_is_handed_to_the_plc() {
    let given = Given::default();
    let mut gateway = gateway_that_gives(VecDeque::new(), Rc::clone(&given));
    let sample = AxisSample {
        error_code: 9,
        ..AxisSample::default()
    };
    let header = FrameHeader {
        sender: 0,
        epoch: 1,
        index: CycleIndex(77),
        count: 77,
        cycle_time: CycleTime::new(Span::from_nanos(CYCLE)).expect("it is there"),
        present_after: None,
        send_stamp: None,
    };
    let axes = [Some(sample)];
    let frame = Message::Frame(Frame {
        header,
        axes: &axes,
    });
    gateway.receive(Instant::EPOCH, 1, &frame);
    let _ = gateway.cycle(Instant::EPOCH);
    let _ = gateway.cycle(Instant::EPOCH + Span::from_micros(500));
    let signals = gateway.snapshot().signals.node;
    assert_eq!((signals.outputs, signals.plc_is_up), (1, true));
    let given = given.borrow();
    assert_eq!(given.len(), 1, "each frame once");
    let (index, axis) = given[0];
    assert_eq!((index, axis.expect("it is there").axis_id), (77, 3));
    assert_eq!(axis.expect("it is there").error_code, 9);
}

/// Returns the rms of numbers around their mean.
fn scatter(numbers: &[f64]) -> f64 {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    (numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Returns the error of the far time of a receiver behind the gateway, µs rms around its mean, and of the
/// gateway's own.
fn errors(plc: Plc, samples: VecDeque<PlcSample>, seconds: i64) -> (f64, f64) {
    let sent = run(&mut gateway(samples), seconds);
    let mut random_numbers = Xoshiro256PlusPlus::seed_from_u64(2);
    let cycle_time = CycleTime::new(Span::from_nanos(CYCLE)).expect("it is there");
    let parameters = ObserverParameters::default();
    let mut clock =
        FarClock::new(cycle_time, parameters, DelaySource::Off, 1).expect("it is there");
    let (mut at_gateway, mut at_receiver) = (Vec::new(), Vec::new());
    for frame in &sent {
        let count = frame.header.count;
        // 100 to 120 µs on the network.
        let delay = 100_000.0 + random(&mut random_numbers, 20_000.0);
        let arrived = frame.at + Span::from_nanos(delay as i64);
        clock.message(1, count, arrived, frame.header.send_stamp);
        let now = arrived + Span::from_micros(300);
        let _ = clock.cycle(now, |_, _| {});
        let n = count as i64 - i64::from(plc.first_index);
        // Settled: five seconds after the start.
        if n < 5_000 {
            continue;
        }
        at_gateway.push(frame.start.as_nanos() as f64 - plc.start(n));
        if let Some(far) = clock.far_time_at(now) {
            let shown = far.time.since(Instant::from_nanos(count as i64 * CYCLE)).0 * 1e9;
            let true_time = (now.as_nanos() as f64 - plc.start(n)) / (1.0 + plc.drift_ppm * 1e-6);
            at_receiver.push(shown - true_time);
        }
    }
    (scatter(&at_gateway) * 1e-3, scatter(&at_receiver) * 1e-3)
}

/// Additional error of polling, against notifications: docs/PLC.md has the figures.
#[test]
fn polling_at_half_the_cycle_costs_microseconds_and_notifications_less() {
    let plc = Plc {
        drift_ppm: 80.0,
        first_index: 0,
    };
    let (gateway, receiver) = errors(plc, plc.polled(30), 30);
    println!("polled: gateway {gateway:.2} µs rms, receiver {receiver:.2} µs rms");
    let (own, behind) = errors(plc, plc.notifying(30), 30);
    println!("notifying: gateway {own:.2} µs rms, receiver {behind:.2} µs rms");
    assert!(receiver < 40.0, "{receiver}");
    assert!(behind < 3.0, "{behind}");
    assert!(behind < receiver);
}
