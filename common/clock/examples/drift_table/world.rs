//! A sender whose drift changes and a path whose delay does, in virtual time, with time exchanges. The receiver's clock is the
//! true one.

use std::collections::VecDeque;

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::far_clock::{DelaySource, FarClock, FarClockOutput};
use coaxle_clock::observer::ObserverParameters;
use coaxle_clock::{CycleTime, Instant, Local, Span};
use rand_distr::{Distribution, Exp1, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// Cycle time of both, s, and the least delay of either way, s.
const CYCLE: f64 = 1e-3;
const LATENCY: f64 = 200e-6;
/// The drift before anything changes, ppm.
const DRIFT: f64 = 50.0;
/// Time from the beginning of its cycle to the departure of a response, s.
const RESPONDS_AFTER: f64 = 20e-6;

/// The link, and the receiver's handling of its delay.
#[derive(Clone, Copy)]
pub(crate) struct Link {
    /// Jitter of the sender's waking, normal, s.
    pub(crate) sender: f64,
    /// Jitter of each way, exponential, s.
    pub(crate) network: f64,
    /// The magnitude of an autoregressive process on top of that of messages: width and time constant, s.
    pub(crate) correlated: Option<(f64, f64)>,
    /// True if messages have send stamps.
    pub(crate) stamps: bool,
    /// True if the receiver sends time requests.
    pub(crate) exchanges: bool,
}

/// Course of the changes over time, s.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// Excess drift of the sender's clock, ppm.
    pub(crate) drift: fn(f64) -> f64,
    /// Excess delay of all ways, s.
    pub(crate) delay: fn(f64) -> f64,
}

/// A cycle of the receiver.
pub(crate) struct Cycle {
    pub(crate) time: f64,
    /// Far time minus the sender's, s; with the least delay taken away where it is not measured.
    pub(crate) error: f64,
    /// Far time minus the sender's at the exchange with the least round trip of the last second, if there were any.
    pub(crate) best_exchange: Option<f64>,
    pub(crate) output: FarClockOutput,
}

/// A message under way: when it arrives, its count, and how late it was sent, s.
struct Message {
    arrival: f64,
    count: u64,
    late: f64,
}

struct World<'a> {
    link: &'a Link,
    course: &'a Course,
    random: Xoshiro256PlusPlus,
    /// Beginning of each of the sender's cycles.
    sends: Vec<f64>,
}

/// Runs a world for `seconds`.
pub(crate) fn run(
    link: &Link,
    course: &Course,
    seed: u64,
    seconds: f64,
    mut each: impl FnMut(&Cycle),
) {
    let mut world = World::new(link, course, seed, seconds);
    let messages = world.messages();
    let cycle_time = CycleTime::new(Span::from_secs_f64(CYCLE)).expect("a cycle time");
    let source = match link.exchanges {
        true => DelaySource::Measured,
        false => DelaySource::Off,
    };
    let mut clock = FarClock::new(cycle_time, ObserverParameters::default(), source, 5)
        .expect("good parameters");
    let mut messages = messages.iter().peekable();
    let mut responses = VecDeque::new();
    let mut exchanges: VecDeque<(f64, f64, f64)> = VecDeque::new();
    for cycle in 1..world.sends.len() - 4 {
        let now = CYCLE * cycle as f64;
        while let Some(message) = messages.next_if(|message| message.arrival <= now) {
            let stamp = link.stamps.then(|| Span::from_secs_f64(message.late));
            clock.message(9, message.count, at(message.arrival), stamp);
        }
        while responses
            .front()
            .is_some_and(|(arrival, _)| *arrival <= now)
            && let Some((arrival, response)) = responses.pop_front()
        {
            let (round_trip, error) = world.as_exchange(arrival, &response);
            exchanges.push_back((arrival, round_trip, error));
            clock.response(at(arrival), &response);
        }
        let output = *clock.cycle(at(now), |_, _| {});
        if let Some(number) = clock.request(at(now)) {
            responses.push_back(world.response(now, number));
        }
        exchanges.retain(|(arrival, ..)| *arrival >= now - 1.0);
        let best = exchanges.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(far) = output.observer.far_time {
            // Without exchanges far time lags by the least delay, which is known here.
            let lag = if link.exchanges { 0.0 } else { LATENCY };
            each(&Cycle {
                time: now,
                error: far.since(Instant::EPOCH).0 - CYCLE * world.far_cycles(now) + lag,
                best_exchange: best.map(|(_, _, error)| *error),
                output,
            });
        }
    }
}

impl<'a> World<'a> {
    fn new(link: &'a Link, course: &'a Course, seed: u64, seconds: f64) -> Self {
        // Off the receiver's cycles by a part that no event is in step with.
        let mut sends = vec![0.3 * CYCLE];
        while sends[sends.len() - 1] < seconds {
            let last = sends[sends.len() - 1];
            sends.push(last + CYCLE * (1.0 - 1e-6 * (DRIFT + (course.drift)(last))));
        }
        Self {
            link,
            course,
            random: Xoshiro256PlusPlus::seed_from_u64(seed),
            sends,
        }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// Delay of a message or response that leaves now.
    fn way(&mut self, now: f64) -> f64 {
        let jitter: f64 = Exp1.sample(&mut self.random);
        LATENCY + (self.course.delay)(now) + self.link.network * jitter
    }

    /// Messages of a link that keeps their order.
    fn messages(&mut self) -> Vec<Message> {
        let (mut newest, mut alike) = (0.0, 0.0);
        let sends = self.sends.clone();
        let messages = (0..).zip(sends).map(|(count, due)| {
            let late = self.link.sender * self.normal();
            let mut arrival = due + late + self.way(due);
            if let Some((width, time)) = self.link.correlated {
                let kept = f64::exp(-CYCLE / time);
                // Stationary: the innovation makes up for what the process forgets in a cycle.
                alike = kept * alike + (1.0 - kept * kept).sqrt() * self.normal();
                arrival += width * f64::abs(alike);
            }
            // A message never overtakes the one before, as on a TCP connection.
            newest = f64::max(newest, arrival);
            Message {
                arrival: newest,
                count,
                late,
            }
        });
        messages.collect()
    }

    /// Time of the sender's clock, in cycles.
    fn far_cycles(&self, time: f64) -> f64 {
        let next = self
            .sends
            .partition_point(|send| *send <= time)
            .clamp(1, self.sends.len() - 1);
        let (from, to) = (self.sends[next - 1], self.sends[next]);
        (next - 1) as f64 + (time - from) / (to - from)
    }

    /// The response to a request that leaves now, and when it arrives.
    fn response(&mut self, now: f64, number: u32) -> (f64, TimeResponse) {
        let received = now + self.way(now);
        // A sender responds in its next cycle.
        let cycle = self.sends.partition_point(|send| *send <= received);
        let responded = self.sends[cycle.min(self.sends.len() - 1)] + RESPONDS_AFTER;
        let far = |time| Span::from_secs_f64(CYCLE * self.far_cycles(time));
        let response = TimeResponse {
            run: 5,
            number,
            requested: at(now),
            epoch: 9,
            received: far(received),
            responded: far(responded),
        };
        (responded + self.way(responded), response)
    }

    /// Round trip of an exchange, and error of the sender's time if both ways are taken for equally long, s.
    fn as_exchange(&self, arrival: f64, response: &TimeResponse) -> (f64, f64) {
        let requested = response.requested.since_epoch().as_secs_f64();
        let held = (response.responded - response.received).as_secs_f64();
        let middle = 0.5 * (requested + arrival);
        let far = 0.5 * (response.received + response.responded).as_secs_f64();
        (
            arrival - requested - held,
            far - CYCLE * self.far_cycles(middle),
        )
    }
}

fn at(seconds: f64) -> Instant<Local> {
    Instant::EPOCH + Span::from_secs_f64(seconds)
}
