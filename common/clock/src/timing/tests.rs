//! The timing channel of a whole far clock, as it comes, ends, is contradicted and comes back.

mod common_time;

use std::vec::Vec;

use rand_distr::{Distribution, Exp, Normal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::cycle::CycleTime;
use crate::delay::{DelayState, TimeResponse};
use crate::far_clock::{DelaySource, FarClock, FarClockOutput};
use crate::instant::{Instant, Local, Span};
use crate::observer::ObserverParameters;
use crate::timing::{EXCHANGES_OF_A_CHANGE, TimingState};

const CYCLE: i64 = 1_000_000;
const DRIFT: f64 = 30e-6;
/// Least way of messages and responses, ns; requests are quicker, so exchanges are off by half of the difference.
const MESSAGE: f64 = 200_000.0;
const REQUEST: f64 = 150_000.0;
/// A way of the timing channel, ns.
const BEACON: f64 = 600.0;
/// Cycles between two of its exchanges.
const EVERY: i64 = 20;

/// A change of a clock's rate.
#[derive(Default)]
struct RateChange {
    /// Local instant, ns.
    at: f64,
    /// Gain until then beside the first rate, ns.
    gained: f64,
    /// Excess over the first rate before it, s/s, and after it.
    before: f64,
    after: f64,
}

struct World {
    clock: FarClock,
    random: Xoshiro256PlusPlus,
    /// Leap of the sender's clock, ns.
    leapt: f64,
    /// Newest change of the rate of the sender's clock.
    changed: RateChange,
    /// Excess of the way back of the timing channel over the way there, ns.
    unequal: f64,
    beacons: bool,
    /// Mean jitter of the timing channel, ns.
    jitter: f64,
    /// Correlated part of the delay of messages.
    correlated: f64,
    epoch: u64,
}

fn local(ns: f64) -> Instant<Local> {
    Instant::from_nanos(ns.round() as i64)
}

impl World {
    fn new(seed: u64) -> Self {
        let cycle_time = CycleTime::new(Span::from_nanos(CYCLE)).unwrap();
        let parameters = ObserverParameters::default();
        Self {
            clock: FarClock::new(cycle_time, parameters, DelaySource::Measured, 5).unwrap(),
            random: Xoshiro256PlusPlus::seed_from_u64(seed),
            leapt: 0.0,
            changed: RateChange::default(),
            unequal: 0.0,
            beacons: true,
            jitter: 200.0,
            correlated: 0.0,
            epoch: 1,
        }
    }

    fn late(&mut self, mean_ns: f64) -> f64 {
        Exp::new(1.0 / mean_ns).unwrap().sample(&mut self.random)
    }

    /// Time of the sender's clock at a local instant, ns.
    fn far(&self, at: f64) -> f64 {
        let change = &self.changed;
        let since = at - change.at;
        let excess = if since > 0.0 {
            change.after
        } else {
            change.before
        };
        at * (1.0 + DRIFT) + self.leapt + change.gained + excess * since
    }

    /// Local instant at which the sender's clock shows `far`, ns.
    fn instant_of(&self, far: f64) -> f64 {
        let change = &self.changed;
        let rest = far - self.far(change.at);
        let excess = if rest > 0.0 {
            change.after
        } else {
            change.before
        };
        change.at + rest / (1.0 + DRIFT + excess)
    }

    /// Changes the rate of the sender's clock by `by`, s/s, in this cycle.
    fn change_rate(&mut self, cycle: i64, by: f64) {
        let RateChange {
            at, gained, after, ..
        } = self.changed;
        let now = (cycle * CYCLE) as f64;
        self.changed = RateChange {
            at: now,
            gained: gained + after * (now - at),
            before: after,
            after: after + by,
        };
    }

    fn far_span(&self, at: f64) -> Span {
        Span::from_nanos(self.far(at).round() as i64)
    }

    fn response(&self, number: u32, t1: f64, t2: f64, t3: f64) -> TimeResponse {
        TimeResponse {
            run: 5,
            number,
            requested: local(t1),
            epoch: self.epoch,
            received: self.far_span(t2),
            responded: self.far_span(t3),
        }
    }

    /// Runs one cycle of the receiver; returns its output, and the error of the far time at its beginning, ns.
    fn cycle(&mut self, n: i64) -> (FarClockOutput, Option<f64>) {
        let now = (n * CYCLE) as f64;
        let noise = Normal::new(0.0, 1_000.0).unwrap().sample(&mut self.random);
        self.correlated += noise - self.correlated * 1e-2;
        // Every cycle of the sender that ended meanwhile.
        let before = self.far(now - CYCLE as f64).div_euclid(CYCLE as f64) as i64;
        let newest = self.far(now).div_euclid(CYCLE as f64) as i64;
        for count in before + 1..=newest {
            let sent = self.instant_of(count as f64 * CYCLE as f64);
            let arrived = sent + MESSAGE + self.late(20_000.0) + self.correlated.abs();
            (self.clock).message(self.epoch, count as u64, local(arrived), Some(Span::ZERO));
        }
        if self.beacons && n % EVERY == 0 {
            let sent = now - 5e6;
            let received = sent + BEACON + self.late(self.jitter);
            let responded = received + 400_000.0;
            let arrived = responded + BEACON + self.unequal + self.late(self.jitter);
            let exchange = self.response(0, sent, received, responded);
            self.clock.timing_exchange(local(arrived), &exchange);
        }
        let output = *self.clock.cycle(local(now), |_, _| {});
        if let Some(number) = self.clock.request(local(now)) {
            let received = now + REQUEST + self.late(20_000.0);
            let responded = received + 300_000.0;
            let arrived = responded + MESSAGE + self.late(20_000.0);
            let response = self.response(number, now, received, responded);
            self.clock.response(local(arrived), &response);
        }
        let shown = output.observer.far_time.filter(|_| output.is_sure);
        let error = shown.map(|far| far.since(Instant::from_nanos(0)).0 * 1e9 - self.far(now));
        (output, error)
    }

    /// Runs `cycles` cycles from `from`; returns the last output, and the error of the far time in each, ns.
    fn run(&mut self, from: i64, cycles: i64) -> (FarClockOutput, Vec<f64>) {
        let mut newest = None;
        let mut errors = Vec::new();
        for n in from..from + cycles {
            let (output, error) = self.cycle(n);
            errors.extend(error);
            newest = Some(output);
        }
        (newest.expect("a cycle"), errors)
    }
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// The largest change from one cycle to the next, ns.
fn largest_step(errors: &[f64]) -> f64 {
    let steps = errors.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    steps.fold(0.0, f64::max)
}

/// Greatest slew of the delay and of the line beside it in a cycle, ns.
const SLEWED: f64 = 1_100.0;
/// Greatest step where nothing is to be slewed, ns.
const SMOOTH: f64 = 120.0;

#[test]
fn the_far_time_is_as_sharp_as_the_stamps() {
    for seed in 0..4 {
        let mut world = World::new(seed);
        let (output, _) = world.run(1, 20_000);
        assert_eq!(output.timing.state, TimingState::InUse);
        let (output, errors) = world.run(20_001, 40_000);
        assert!(rms(&errors) < 60.0, "{seed}: {} ns", rms(&errors));
        let uncertainty = output.delay.uncertainty.unwrap().0 * 1e9;
        assert!((500.0..2_000.0).contains(&uncertainty), "{uncertainty}");
        assert!(errors.iter().all(|error| error.abs() < uncertainty));
        assert!(largest_step(&errors) < SMOOTH, "{}", largest_step(&errors));

        // Without it, half of what the ways differ by.
        let mut world = World::new(seed);
        world.beacons = false;
        let (output, _) = world.run(1, 20_000);
        assert_eq!(output.timing.state, TimingState::Waiting);
        let (_, errors) = world.run(20_001, 40_000);
        assert!(rms(&errors) > 20_000.0, "{seed}: {} ns", rms(&errors));
    }
}

#[test]
fn it_comes_ends_and_comes_back_without_a_step() {
    for seed in 0..4 {
        let mut world = World::new(seed);
        world.beacons = false;
        let (_, before) = world.run(1, 20_000);
        world.beacons = true;
        let (output, entering) = world.run(20_001, 10_000);
        assert_eq!(output.timing.state, TimingState::InUse);
        world.beacons = false;
        let (output, leaving) = world.run(30_001, 20_000);
        assert_eq!(output.timing.state, TimingState::Held);
        assert_eq!(output.delay.state, DelayState::Measured);
        world.beacons = true;
        let (output, back) = world.run(50_001, 10_000);
        assert_eq!(output.timing.state, TimingState::InUse);

        // Entering, 25 µs are slewed; nothing is when it ends. The last offset is not forgotten.
        let steps = [&before[10_000..], &entering, &leaving, &back].map(largest_step);
        assert!(steps[1] < SLEWED, "{seed}: {steps:?}");
        assert!(
            steps[2] < 2.0 * SMOOTH && steps[3] < 2.0 * SMOOTH,
            "{seed}: {steps:?}"
        );
        let first = &leaving[2_000..4_000];
        assert!(rms(first) < 3_000.0, "{seed}: {}", rms(first));
        let uncertainty = output.delay.uncertainty.unwrap().0 * 1e9;
        let late = &back[9_000..];
        assert!(late.iter().all(|error| error.abs() < uncertainty), "{seed}");
        assert!(rms(late) < 60.0, "{seed}: {}", rms(late));
    }
}

#[test]
fn a_gap_of_two_seconds_is_the_end_of_it() {
    let mut world = World::new(1);
    let _ = world.run(1, 20_000);
    world.beacons = false;
    let (output, _) = world.run(20_001, 1_600);
    assert_eq!(output.timing.state, TimingState::InUse);
    let (output, _) = world.run(21_601, 800);
    assert_eq!(output.timing.state, TimingState::Held);
}

#[test]
fn one_that_contradicts_the_transport_is_not_used() {
    let mut world = World::new(1);
    // No way of the transport leaves that open.
    world.unequal = 900_000.0;
    let (output, _) = world.run(1, 20_000);
    assert_eq!(output.timing.state, TimingState::Acquiring);
    let exchange = |world: &mut World, n: i64| {
        let sent = (n * CYCLE) as f64 - 5e6;
        // Short, and wrong by a millisecond.
        let (received, responded) = (sent + 1_000_600.0, sent + 1_200_000.0);
        let exchange = world.response(0, sent, received, responded);
        (world.clock).timing_exchange(local(sent + 201_200.0), &exchange);
    };
    let mut world = World::new(1);
    world.beacons = false;
    let (_, before) = world.run(1, 20_000);
    for n in 20_001..25_000 {
        if n % EVERY == 0 {
            exchange(&mut world, n);
        }
        let (output, error) = world.cycle(n);
        assert_ne!(output.timing.state, TimingState::InUse, "{n}");
        assert!(error.unwrap().abs() < 40_000.0, "{n}: {error:?}");
    }
    assert!(rms(&before[10_000..]) < 40_000.0);
}

#[test]
fn a_clock_that_leaps_is_found_again() {
    for leap in [-20_000.0, 3_000_000.0] {
        let mut world = World::new(2);
        let (output, _) = world.run(1, 20_000);
        assert_eq!(
            (output.timing.state, output.timing.restarts),
            (TimingState::InUse, 0)
        );
        world.leapt = leap;
        let (output, _) = world.run(20_001, 30_000);
        assert_eq!(output.timing.state, TimingState::InUse, "{leap}");
        assert!(output.timing.restarts >= 1, "{leap}");
        let (_, errors) = world.run(50_001, 5_000);
        assert!(rms(&errors) < 100.0, "{leap}: {}", rms(&errors));
        assert!(largest_step(&errors) < SMOOTH);
    }
}

#[test]
fn exchanges_that_cannot_be_true_are_refused_and_move_nothing() {
    let mut world = World::new(3);
    let (output, _) = world.run(1, 20_000);
    assert_eq!(output.timing.refused, 0);
    let now = 20_001.0 * CYCLE as f64;
    let sent = now - 4e6;
    for (exchange, arrived) in [
        // Of another run, before the request, after a minute, with the response before the request.
        (
            TimeResponse {
                epoch: 9,
                ..world.response(0, sent, sent, sent)
            },
            sent + 1e3,
        ),
        (world.response(0, sent, sent, sent), sent - 1.0),
        (world.response(0, sent - 60e9, sent, sent), sent),
        (world.response(0, sent - 1.2e9, sent, sent), sent),
        (world.response(0, sent - 0.9e9, sent - 1.2e9, sent), sent),
        (world.response(0, sent, sent + 2.0, sent), sent + 1e3),
    ] {
        world.clock.timing_exchange(local(arrived), &exchange);
    }
    // Slow, but it may be true.
    let slow = world.response(0, sent - 0.8e9, sent - 0.8e9, sent);
    world.clock.timing_exchange(local(sent), &slow);
    let (output, errors) = world.run(20_001, 2_000);
    assert_eq!(output.timing.refused, 6);
    assert!(rms(&errors) < 60.0, "{}", rms(&errors));
}

#[test]
fn a_delay_that_is_not_measured_has_no_use_for_it() {
    let mut world = World::new(4);
    let _ = world.run(1, 20_000);
    world
        .clock
        .set_delay(DelaySource::Fixed(Span::from_nanos(MESSAGE as i64)));
    let (output, errors) = world.run(20_001, 10_000);
    assert_eq!(output.timing.state, TimingState::Waiting);
    assert!(largest_step(&errors) < SLEWED);
    world.clock.set_delay(DelaySource::Measured);
    let (output, errors) = world.run(30_001, 10_000);
    assert_eq!(output.timing.state, TimingState::InUse);
    assert!(rms(&errors[8_000..]) < 60.0);
}

#[test]
fn another_run_of_the_sender_is_another_clock() {
    let mut world = World::new(5);
    let _ = world.run(1, 20_000);
    world.epoch = 2;
    let mut was_used = true;
    let mut began = None;
    for n in 20_001..40_000 {
        let (output, _) = world.cycle(n);
        let in_use = output.timing.state == TimingState::InUse;
        if in_use && !was_used {
            began.get_or_insert(n);
        }
        was_used = in_use;
    }
    let began = began.expect("it is used again");
    assert!((20_500..30_000).contains(&began), "{began}");
    assert!(was_used);
}

/// Error of a cycle, and the greatest one that is stated, ns.
fn stated((output, error): (FarClockOutput, Option<f64>)) -> (f64, f64) {
    let uncertainty = output.delay.uncertainty.expect("a measured delay").0;
    let rest = output.observer.slew_remaining.0.abs();
    (error.expect("a far time").abs(), (uncertainty + rest) * 1e9)
}

#[test]
fn a_rate_that_changes_at_once_is_stated_as_soon_as_exchanges_show_it() {
    // The exchanges that show it, and the response that waits for its cycle.
    let shown_after = i64::from(EXCHANGES_OF_A_CHANGE) * EVERY + 2;
    for (seed, ppm) in (0..).zip([2.0, -5.0, 10.0, -20.0, 50.0, -200.0]) {
        let mut world = World::new(seed);
        world.jitter = if seed.is_multiple_of(2) { 200.0 } else { 500.0 };
        let _ = world.run(1, 20_000);
        // Somewhere within a group.
        let at = 20_037 + 50 * seed as i64;
        let _ = world.run(20_001, at - 20_000);
        world.change_rate(at, ppm * 1e-6);
        for n in at + 1..at + 20_000 {
            let (error, bound) = stated(world.cycle(n));
            // Until then a receiver can at best go on along the line of before: Δ·t.
            let since = n - at;
            let unknown = match since <= shown_after {
                true => ppm.abs() * 1e-6 * (since * CYCLE) as f64,
                false => 0.0,
            };
            assert!(
                error <= bound + unknown,
                "{ppm} ppm, {since} ms: {error} of {bound} ns"
            );
        }
    }
}

#[test]
fn clocks_that_wander_quickly_are_as_far_off_as_stated_at_most() {
    for walk_ppm in [0.3, 0.6, 1.0] {
        for seed in 0..4 {
            let mut world = World::new(seed);
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed + 77);
            // Ten cycles at a time: the root of 0.01 s is 0.1.
            let step = Normal::new(0.0, walk_ppm * 1e-6 * 0.1).unwrap();
            let _ = world.run(1, 30_000);
            for n in 30_001..90_000 {
                if n % 10 == 1 {
                    world.change_rate(n - 1, step.sample(&mut random));
                }
                let (error, bound) = stated(world.cycle(n));
                assert!(
                    error <= bound,
                    "{walk_ppm} ppm/√s, {seed}, {n}: {error} of {bound} ns"
                );
            }
        }
    }
}
