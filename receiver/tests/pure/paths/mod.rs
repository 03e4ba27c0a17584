//! A sender, the three paths between it and a receiver, and its clock, with the faults of real
//! ones: paths become longer and shorter, clocks stop and leap, processes freeze and skip the
//! cycles they missed.

#![allow(dead_code, reason = "each test file takes what it needs")]

use std::collections::BTreeMap;

use coaxle_clock::delay::TimeResponse;
use coaxle_clock::{CycleIndex, CycleTime, Instant, Span};
use coaxle_curve::profile::Kinematics;
use coaxle_node::config::parse;
use coaxle_node::frame::KeySeal;
use coaxle_node::{AxisSample, Channel, Frame, FrameHeader, Message, Node, TimeRequest};
use coaxle_receiver::{ContinuityState, FilterState, Receiver, ReceiverConfig};

pub(crate) const VELOCITY: f64 = 500.0;
pub(crate) const CYCLE: i64 = 1_000_000;
pub(crate) const MS: i64 = 1_000_000;
pub(crate) const SECOND: i64 = 1_000_000_000;

/// Cycles over which a change of the mode is blended, and one more.
const BLENDING: u32 = 61;

/// Path delays of messages without jitter, ns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paths {
    pub(crate) message: i64,
    pub(crate) request: i64,
    pub(crate) response: i64,
}

/// A cycle of the receiver, as slaves of the axis see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// True time, which is the receiver's, ns.
    pub(crate) at: i64,
    pub(crate) position: f64,
    /// The sender's own position at this instant.
    pub(crate) true_position: f64,
    /// The far time of the set values, ns; none where no clock moves them.
    pub(crate) far_time: Option<i64>,
    pub(crate) continuity: ContinuityState,
    pub(crate) synced: bool,
    /// True if it equals its master, by the observer, with no blending from another mode.
    pub(crate) is_followed: bool,
}

enum Arriving {
    Frame(FrameHeader, [Option<AxisSample>; 1]),
    Response(TimeResponse),
}

pub(crate) struct World {
    pub(crate) receiver: Receiver,
    pub(crate) paths: Paths,
    /// Mean of the exponential jitter of each message, ns, and the share of them that is lost.
    pub(crate) jitter: f64,
    pub(crate) loss: f64,
    pub(crate) has_stamps: bool,
    /// True if it responds to time requests.
    pub(crate) responds: bool,
    pub(crate) seen: Vec<Seen>,
    /// Cycles since its set values had another source.
    followed: u32,
    ppm: f64,
    /// Lead of true time over the sender's clock, except for the drift, ns.
    behind: i64,
    /// End of the sender's freeze, true time.
    frozen_until: i64,
    next_count: i64,
    requests: Vec<(i64, TimeRequest)>,
    arriving: BTreeMap<(i64, u64), Arriving>,
    posted: u64,
    random: u64,
    seal: KeySeal,
}

impl World {
    /// Creates a world; `rest` is the receiver's config of the far node.
    pub(crate) fn new(rest: &str, ppm: f64, seed: u64) -> Self {
        let text = format!(
            "name = 'line'\ncycle-time-us = 1000\n[[far]]\nnode = 'a'\naxes = [1]\n{rest}\n\
             [[slave]]\nname = 'x'\nmaster = 'a.1'\n"
        );
        let config: ReceiverConfig = parse("r.toml", &text).expect("a config");
        let key = config.far[0].node.channel_key(Channel::TimeRequests);
        Self {
            receiver: Receiver::new(&config, Instant::from_nanos(MS / 2), 7).expect("valid"),
            paths: Paths {
                message: MS,
                request: MS,
                response: MS,
            },
            jitter: 20e3,
            loss: 0.0,
            has_stamps: true,
            responds: true,
            seen: Vec::new(),
            followed: 0,
            ppm,
            behind: 0,
            frozen_until: 0,
            next_count: 0,
            requests: Vec::new(),
            arriving: BTreeMap::new(),
            posted: 0,
            // 2⁶⁴ divided by the golden ratio; odd, as xorshift never leaves zero.
            random: seed.wrapping_mul(2).wrapping_add(0x9E37_79B9_7F4A_7C15) | 1,
            seal: KeySeal::new(&key),
        }
    }

    pub(crate) fn now(&self) -> i64 {
        self.receiver.next_cycle().as_nanos()
    }

    /// Stops the sender's clock for this time; negative: it leaps.
    pub(crate) fn stop_clock(&mut self, nanos: i64) {
        self.behind += nanos;
    }

    /// Freezes the sender's process for this time, while its clock runs: it skips the cycles it missed.
    pub(crate) fn freeze(&mut self, nanos: i64) {
        self.frozen_until = self.now() + nanos;
    }

    pub(crate) fn step_all_paths(&mut self, by: i64) {
        self.paths.message += by;
        self.paths.request += by;
        self.paths.response += by;
    }

    pub(crate) fn run(&mut self, seconds: f64) {
        let until = self.now() + (seconds * 1e9) as i64;
        while self.now() < until {
            self.cycle();
        }
    }

    fn cycle(&mut self) {
        let now = self.now();
        self.send_until(now);
        while let Some((&(at, number), _)) = self.arriving.first_key_value()
            && at <= now
        {
            let arriving = self.arriving.remove(&(at, number)).expect("it is there");
            let at = Instant::from_nanos(at);
            match arriving {
                Arriving::Frame(header, axes) => {
                    let axes = &axes;
                    let message = Message::Frame(Frame { header, axes });
                    self.receiver.receive(at, 0, &message);
                }
                Arriving::Response(response) => {
                    let message = Message::TimeResponse(response);
                    self.receiver.receive(at, 1, &message);
                }
            }
        }
        let _ = self.receiver.cycle(Instant::from_nanos(now));
        let mut sealed = Vec::new();
        while let Some(outgoing) = self.receiver.transmit() {
            if outgoing.channel == Channel::TimeRequests && self.responds {
                self.seal.seal(outgoing.body, Some(Span::ZERO), &mut sealed);
                let request = self.seal.open_time_request(&sealed).expect("a request");
                let way = self.paths.request + (self.jitter * exponential(&mut self.random)) as i64;
                self.requests.push((now + way, request));
            }
        }
        self.look(now);
    }

    pub(crate) fn is_synced(&self) -> bool {
        self.seen.last().is_some_and(|seen| seen.synced)
    }

    fn look(&mut self, now: i64) {
        let row = &self.receiver.snapshot().signals;
        let axis = &row.axes[0];
        let by_observer = axis.state == Some(FilterState::Observer);
        let follows = axis.continuity == ContinuityState::Following;
        self.followed = if by_observer && follows {
            self.followed + 1
        } else {
            0
        };
        if let Some(position) = axis.corrected_position {
            self.seen.push(Seen {
                at: now,
                position,
                true_position: VELOCITY * self.sender_time(now) * 1e-9,
                far_time: axis.far_time_ns,
                continuity: axis.continuity,
                synced: axis.synced,
                is_followed: self.followed > BLENDING,
            });
        }
    }

    /// Reading of the sender's clock, ns.
    fn sender_time(&self, truth: i64) -> f64 {
        (truth - self.behind) as f64 / (1.0 + self.ppm * 1e-6)
    }

    fn due(&self, count: i64) -> i64 {
        (count as f64 * CYCLE as f64 * (1.0 + self.ppm * 1e-6)) as i64 + self.behind
    }

    /// Runs the cycles of the sender up to now.
    fn send_until(&mut self, now: i64) {
        loop {
            let at = self.due(self.next_count).max(self.frozen_until);
            if at > now {
                return;
            }
            // The newest cycle that has begun; earlier ones are skipped.
            // Rounding must not take the begin of a cycle for the one before.
            let newest = (self.sender_time(at) / CYCLE as f64 + 1e-6).floor() as i64;
            let count = newest.max(self.next_count);
            self.next_count = count + 1;
            self.send_frame(count, at);
            self.send_responses(at);
        }
    }

    fn send_frame(&mut self, count: i64, at: i64) {
        let late = (self.sender_time(at) - (count * CYCLE) as f64) as i64;
        let header = FrameHeader {
            sender: 1,
            epoch: 1,
            index: CycleIndex::of_count(count as u64),
            count: count as u64,
            cycle_time: CycleTime::new(Span::from_nanos(CYCLE)).expect("in range"),
            present_after: None,
            send_stamp: self.has_stamps.then_some(Span::from_nanos(late)),
        };
        let set = Kinematics {
            position: VELOCITY * count as f64 * 1e-3,
            velocity: VELOCITY,
            acceleration: 0.0,
        };
        let sample = AxisSample {
            set,
            ..AxisSample::default()
        };
        self.post(
            at,
            self.paths.message,
            Arriving::Frame(header, [Some(sample)]),
        );
    }

    fn send_responses(&mut self, at: i64) {
        let waiting = std::mem::take(&mut self.requests);
        for (received, request) in waiting {
            if received > at {
                self.requests.push((received, request));
                continue;
            }
            let span = |truth| Span::from_nanos(self.sender_time(truth) as i64);
            let response = TimeResponse {
                run: request.run,
                number: request.number,
                requested: Instant::from_nanos(request.requested),
                epoch: 1,
                received: span(received),
                responded: span(at),
            };
            self.post(at, self.paths.response, Arriving::Response(response));
        }
    }

    fn post(&mut self, at: i64, way: i64, what: Arriving) {
        if uniform(&mut self.random) < self.loss {
            return;
        }
        let jitter = (self.jitter * exponential(&mut self.random)) as i64;
        self.posted += 1;
        self.arriving.insert((at + way + jitter, self.posted), what);
    }
}

fn uniform(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    // Never 0, so that its logarithm is finite.
    ((*state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

fn exponential(state: &mut u64) -> f64 {
    -uniform(state).ln()
}
