//! Together with an observer: the far time shown is the sender's own.

use std::boxed::Box;
use std::vec::Vec;

use super::*;
use crate::CycleTime;
use crate::observer::{ObserverParameters, PhaseObserver};

/// A sender, a link and an observer; the requester's clock is the true one.
struct World {
    observer: PhaseObserver,
    exchange: DelayExchange,
    drift: f64,
    latency: Span,
    /// Reduction of the way of requests.
    requests_shorter: Span,
    jitters: [Box<dyn FnMut() -> Span>; 3],
    count: u64,
    responses: Vec<(Instant<Local>, TimeResponse)>,
}

impl World {
    fn new(drift_ppm: f64, seed: u64) -> Self {
        let cycle_time = CycleTime::new(Span::from_millis(1)).unwrap();
        let parameters = ObserverParameters::default();
        Self {
            observer: PhaseObserver::new(cycle_time, parameters).unwrap(),
            exchange: DelayExchange::new(RUN),
            drift: drift_ppm * 1e-6,
            latency: micros(1_000),
            requests_shorter: Span::ZERO,
            jitters: [1, 2, 3].map(|n| Box::new(jitter(20.0, seed * 3 + n)) as _),
            count: 0,
            responses: Vec::new(),
        }
    }

    /// True time at which the sender's clock shows `sender_ns` nanoseconds.
    fn truth(&self, sender_ns: f64) -> Instant<Local> {
        Instant::from_nanos((sender_ns * (1.0 + self.drift)) as i64)
    }

    fn shown(&self, truth: Instant<Local>) -> Span {
        Span::from_nanos((truth.as_nanos() as f64 / (1.0 + self.drift)) as i64)
    }

    /// Runs one cycle of both; returns the shown far time minus the sender's true time, µs.
    fn step(&mut self) -> f64 {
        let due = self.truth(self.count as f64 * 1e6);
        let arrived = due + self.latency + (self.jitters[0])();
        self.observer
            .observe(EPOCH, self.count, arrived, Some(Span::ZERO));
        self.count += 1;
        let now = due + micros(500);
        if let Some(line) = self.observer.line() {
            if let Some(jump) = self.exchange.follow(&line) {
                self.observer.attribute_step_to_path(jump);
            }
            self.observer
                .leave_steps_to_exchanges(self.exchange.can_attribute(now));
            while let Some((arrived, response)) = self.responses.pop_if(|(at, _)| *at <= now) {
                self.exchange.take(&response, arrived, &line).unwrap();
            }
            if let Some(number) = self.exchange.ask(now) {
                self.post_request(now, number);
            }
        }
        self.observer
            .set_delay(self.exchange.delay().unwrap_or(Span::ZERO));
        let output = self.observer.cycle(now);
        output.far_time.map_or(f64::NAN, |far| {
            let error = far.instant.since_epoch() - self.shown(now);
            error.as_micros_f64()
        })
    }

    fn post_request(&mut self, requested: Instant<Local>, number: u32) {
        let received = requested + self.latency - self.requests_shorter + (self.jitters[1])();
        let responded = received + micros(600);
        let arrived = responded + self.latency + (self.jitters[2])();
        let response = TimeResponse {
            run: RUN,
            number,
            requested,
            epoch: EPOCH,
            received: self.shown(received),
            responded: self.shown(responded),
        };
        self.responses.insert(0, (arrived, response));
    }

    fn worst(&mut self, seconds: f64) -> f64 {
        let cycles = (seconds * 1e3) as u64;
        (0..cycles).map(|_| self.step().abs()).fold(0.0, f64::max)
    }
}

#[test]
fn with_an_observer_the_far_time_is_the_senders_own_through_steps_of_the_delay() {
    for (drift, seed) in [(80.0, 1), (-30.0, 2), (3.0, 3)] {
        let mut world = World::new(drift, seed);
        let _ = world.worst(2.0);
        let worst = world.worst(15.0);
        assert!(worst < 3.0, "{drift} ppm: {worst} µs");
        for step in [300, -500] {
            world.latency += micros(step);
            let worst = world.worst(15.0);
            // Until it is noticed the line is pulled; then the jump is attributed to the path.
            assert!(worst < 30.0, "{drift} ppm, step {step}: {worst} µs");
            let worst = world.worst(5.0);
            assert!(worst < 3.0, "{drift} ppm, after {step}: {worst} µs");
        }
        assert_eq!(world.exchange.refused, 0);
    }
}

#[test]
fn steps_of_some_ways_below_half_a_millisecond_are_attributed_too() {
    for (drift, seed) in [(80.0, 1), (-30.0, 2), (3.0, 3), (20.0, 4)] {
        for step in [400, -400, 200] {
            let mut world = World::new(drift, seed);
            let _ = world.worst(15.0);
            // Messages and responses, but not requests.
            world.latency += micros(step);
            world.requests_shorter += micros(step);
            let worst = world.worst(15.0);
            assert!(worst < 45.0, "{drift} ppm, step {step}: {worst} µs");
            let worst = world.worst(10.0);
            assert!(worst < 8.0, "{drift} ppm, after {step}: {worst} µs");
        }
    }
}

#[test]
fn a_step_that_is_taken_back_leaves_nothing_behind() {
    for (drift, seed) in [(80.0, 1), (-30.0, 2), (3.0, 3), (20.0, 4)] {
        let mut world = World::new(drift, seed);
        let _ = world.worst(8.0);
        for step in [400, -400, 400, -400, 150, -150] {
            world.latency += micros(step);
            world.requests_shorter += micros(step);
            let worst = world.worst(8.0);
            assert!(worst < 45.0, "{drift} ppm, step {step}: {worst} µs");
        }
        let worst = world.worst(12.0);
        assert!(worst < 10.0, "{drift} ppm: {worst} µs");
    }
}
