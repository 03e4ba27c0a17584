//! A far clock with time exchanges: paths that change differently, clocks that stop, silences and a timing channel.

use std::collections::VecDeque;

use coaxle_clock::delay::{Asymmetry, TimeResponse};
use coaxle_clock::far_clock::{DelaySource, FarClock};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::outcome::RunOutcome;

/// Cycle time of both sides, s, and the least delay of each way, s.
const CYCLE: f64 = 1e-3;
const LATENCY: f64 = 200e-6;

/// A course over time, s.
type Course = fn(f64) -> f64;

/// A step of this size at a time.
pub(crate) fn step(time: f64, at: f64, size: f64) -> f64 {
    if time < at { 0.0 } else { size }
}

/// A sine of this size from a time on.
pub(crate) fn swing(time: f64, from: f64, size: f64, period: f64) -> f64 {
    size * f64::sin((time - from).max(0.0) * std::f64::consts::TAU / period)
}

/// A link and its changes.
#[derive(Clone, Copy)]
pub(crate) struct FarCase {
    pub(crate) seconds: f64,
    /// Normal jitter of the sender, and exponential jitter of each way, s.
    pub(crate) sender: f64,
    pub(crate) network: f64,
    /// True if messages have send stamps.
    pub(crate) stamps: bool,
    /// Drift, ppm.
    pub(crate) drift: Course,
    /// Excess delay of messages and responses, and of requests, s.
    pub(crate) back: Course,
    pub(crate) there: Course,
    /// Times at which the sender's clock stands still, and for how long, s.
    pub(crate) stops: &'static [(f64, f64)],
    /// Spans without messages, and without responses, s.
    pub(crate) silent: (f64, f64),
    pub(crate) mute: (f64, f64),
    /// Part of all messages and responses that is lost.
    pub(crate) loss: f64,
    /// Noise of the stamps of a timing channel, s, and the time at which it ends.
    pub(crate) timing: Option<(f64, f64)>,
    /// Interval at which the receiver polls for messages, s.
    pub(crate) polled: Option<f64>,
    /// Asymmetry that is stated, s, and how far it may be wrong.
    pub(crate) stated: Option<(f64, f64)>,
}

impl FarCase {
    pub(crate) const QUIET: Self = Self {
        seconds: 30.0,
        sender: 5e-6,
        network: 20e-6,
        stamps: true,
        drift: |_| 50.0,
        back: |_| 0.0,
        there: |_| 0.0,
        stops: &[],
        silent: (0.0, 0.0),
        mute: (0.0, 0.0),
        loss: 0.01,
        timing: None,
        polled: None,
        stated: None,
    };

    /// The case with this excess delay of each way.
    pub(crate) const fn both_ways(self, course: Course) -> Self {
        Self {
            back: course,
            there: course,
            ..self
        }
    }

    /// Runs the case once.
    pub(crate) fn outcome(&self) -> RunOutcome {
        let mut run = FarRun::new(self);
        let mut outcome = RunOutcome::default();
        let mut sums = FarSums::default();
        for cycle in 1..(self.seconds / CYCLE) as u64 {
            run.cycle(CYCLE * cycle as f64, &mut outcome, &mut sums);
        }
        let newest = *run.clock.newest().unwrap();
        let n = sums.count.max(1.0);
        outcome.add("rms, µs", (sums.squares / n).sqrt() * 1e6, 0.2);
        outcome.add("largest, µs", sums.largest * 1e6, 1.0);
        outcome.add("uncertainty, µs", sums.uncertainty / n * 1e6, 1.0);
        outcome.add("not covered, cycles", sums.beyond, 100.0);
        outcome.add("requests", f64::from(run.number), 50.0);
        outcome.add("shifts", f64::from(newest.observer.shifts), 1.0);
        outcome.add("drift steps", f64::from(newest.observer.drift_steps), 1.0);
        outcome.add("rebases", f64::from(newest.observer.rebases), 1.0);
        outcome
    }
}

/// FarSums over the cycles in which far time is known.
#[derive(Default)]
struct FarSums {
    count: f64,
    squares: f64,
    largest: f64,
    uncertainty: f64,
    beyond: f64,
}

struct FarRun<'a> {
    case: &'a FarCase,
    random: Xoshiro256PlusPlus,
    clock: FarClock,
    /// Beginnings of the sender's cycles.
    due: Vec<f64>,
    /// Messages under way: arrival, count and stamp, s.
    messages: VecDeque<(f64, u64, f64)>,
    responses: VecDeque<(f64, TimeResponse)>,
    timing: VecDeque<(f64, TimeResponse)>,
    number: u32,
}

impl<'a> FarRun<'a> {
    fn new(case: &'a FarCase) -> Self {
        let mut due = vec![0.3 * CYCLE];
        let mut stops = case.stops.iter().peekable();
        while due[due.len() - 1] < case.seconds + 0.1 {
            let last = due[due.len() - 1];
            let stopped = stops
                .next_if(|(at, _)| *at <= last)
                .map_or(0.0, |(_, by)| *by);
            due.push(last + CYCLE * (1.0 - 1e-6 * (case.drift)(last)) + stopped);
        }
        let cycle = CycleTime::new(Span::from_secs_f64(CYCLE)).unwrap();
        let parameters = ObserverParameters::default();
        let mut clock = FarClock::new(cycle, parameters, DelaySource::Measured, 5).unwrap();
        clock.state_asymmetry(case.stated.map(|(longer, within)| Asymmetry {
            longer: Span::from_secs_f64(longer),
            within: Span::from_secs_f64(within),
        }));
        let mut run = Self {
            case,
            // Any seed, and always this one: only differences to the run without a change count.
            random: Xoshiro256PlusPlus::seed_from_u64(11),
            clock,
            due,
            messages: VecDeque::new(),
            responses: VecDeque::new(),
            timing: VecDeque::new(),
            number: 0,
        };
        run.send_all();
        run
    }

    /// Sends all messages, over a link that keeps their order.
    fn send_all(&mut self) {
        let (mut newest, due) = (0.0, self.due.clone());
        for (count, due) in (0..).zip(due) {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            let late = self.case.sender * normal;
            let arrived = due + late + self.way((self.case.back)(due));
            newest = f64::max(newest, self.seen(arrived));
            let (from, to) = self.case.silent;
            if !self.is_lost() && !(from..to).contains(&due) {
                self.messages.push_back((newest, count, late));
            }
        }
    }

    /// Time at which a message that arrived is seen: by the next poll, which wakes up a little late.
    fn seen(&mut self, arrived: f64) -> f64 {
        let Some(every) = self.case.polled else {
            return arrived;
        };
        let late: f64 = Exp1.sample(&mut self.random);
        (arrived / every).ceil() * every + 2e-6 * late
    }

    fn is_lost(&mut self) -> bool {
        ((self.random.next_u64() >> 11) as f64) < self.case.loss * (1_u64 << 53) as f64
    }

    fn way(&mut self, excess: f64) -> f64 {
        let jitter: f64 = Exp1.sample(&mut self.random);
        LATENCY + excess + self.case.network * jitter
    }

    /// Time of the sender's clock, s.
    fn far(&self, time: f64) -> f64 {
        let next = self.due.partition_point(|due| *due <= time);
        let next = next.clamp(1, self.due.len() - 1);
        let (from, to) = (self.due[next - 1], self.due[next]);
        // A clock that stands still shows the beginning of its cycle.
        let passed = (time - from - (to - from - CYCLE).max(0.0)).max(0.0);
        CYCLE * ((next - 1) as f64 + passed / (to - from).min(CYCLE))
    }

    fn cycle(&mut self, now: f64, outcome: &mut RunOutcome, sums: &mut FarSums) {
        while let Some((arrival, count, late)) = take_due(&mut self.messages, now, |m| m.0) {
            let stamp = (self.case.stamps).then(|| Span::from_secs_f64(late));
            self.clock.message(9, count, at(arrival), stamp);
        }
        while let Some((arrival, response)) = take_due(&mut self.responses, now, |r| r.0) {
            self.clock.response(at(arrival), &response);
        }
        while let Some((arrival, exchange)) = take_due(&mut self.timing, now, |r| r.0) {
            self.clock.timing_exchange(at(arrival), &exchange);
        }
        let output = *self.clock.cycle(at(now), |_, _| {});
        self.request(now);
        let (Some(far), Some(reading)) =
            (output.observer.far_time, self.clock.far_time_at(at(now)))
        else {
            return;
        };
        let error = far.since(Instant::EPOCH).0 - self.far(now);
        outcome.digest(error);
        outcome.digest(reading.uncertainty.0);
        outcome.digest(f64::from(output.observer.state as u8));
        // Before, far time is used by nothing.
        if output.is_sure {
            sums.count += 1.0;
            sums.squares += error * error;
            sums.largest = sums.largest.max(error.abs());
            sums.uncertainty += reading.uncertainty.0;
            sums.beyond += f64::from(u8::from(error.abs() > reading.uncertainty.0));
        }
    }

    /// Sends what is due at this time: a request, and an exchange of the timing channel every 20 ms.
    fn request(&mut self, now: f64) {
        if let Some(number) = self.clock.request(at(now)) {
            self.number += 1;
            let received = now + self.way((self.case.there)(now));
            let next = self.due.partition_point(|due| *due <= received);
            let responded = self.due[next.min(self.due.len() - 1)] + 20e-6;
            let arrival = responded + self.way((self.case.back)(responded));
            let (from, to) = self.case.mute;
            if !self.is_lost() && !(from..to).contains(&now) {
                let response = self.response(number, now, received, responded);
                self.responses.push_back((arrival, response));
            }
        }
        let Some((noise, ends)) = self.case.timing else {
            return;
        };
        if ((now / CYCLE) as u64).is_multiple_of(20) && now < ends {
            let mut later = |from: f64| {
                let jitter: f64 = Exp1.sample(&mut self.random);
                from + LATENCY + noise * jitter
            };
            let received = later(now);
            // By the kernel, not in the next cycle.
            let responded = received + 30e-6;
            let arrival = later(responded);
            let exchange = self.response(0, now, received, responded);
            self.timing.push_back((arrival, exchange));
        }
    }

    fn response(&self, number: u32, sent: f64, received: f64, responded: f64) -> TimeResponse {
        TimeResponse {
            run: 5,
            number,
            requested: at(sent),
            epoch: 9,
            received: Span::from_secs_f64(self.far(received)),
            responded: Span::from_secs_f64(self.far(responded)),
        }
    }
}

/// Takes the first of a queue if it is due.
fn take_due<T>(queue: &mut VecDeque<T>, now: f64, due: impl Fn(&T) -> f64) -> Option<T> {
    match queue.front() {
        Some(first) if due(first) <= now => queue.pop_front(),
        _ => None,
    }
}

fn at(seconds: f64) -> Instant<Local> {
    Instant::EPOCH + Span::from_secs_f64(seconds)
}
