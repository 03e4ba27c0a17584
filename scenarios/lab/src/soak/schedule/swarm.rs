//! Swarm schedules: each seed switches whole features on or off, and its masters come to rest, or to a slow and steady motion, so
//! that liveness can be judged at the end.
//!
//! A random schedule with a little of everything hides what only one feature alone, or two without a third, would show: the
//! method is that of swarm testing (Groce et al., ISSTA 2012).

mod clocks;
mod commands;
mod features;
mod motion;
mod network;
mod plates;
mod receivers;
mod recovery;
mod slaves;

use std::fmt::Write as _;

use coaxle_node::faults::{Random, seed_of};

use super::draw::Draw as _;
use super::late_draws::with_followers;
use super::{ExtraDraws, QUIET_FROM, SoakSchedule, Wide};
use features::{Feature, Features};

/// Length of a swarm schedule, s.
// The masters are steady from 28 s on: faults end at 8 s, a program that begins then takes `motion::PROGRAM`, and a clock that leapt
// back stands for up to `clocks::LEAP_BACK`. The longest way is that of a clock that leapt ahead by 10 s at the highest velocity v:
// 1.875 · 10 s · v / (v/2) = 37.5 s for the far axis, and 10 s · v / (0.6·v − 0.25·v) = 29 s for its slowest slave.
pub(super) const LENGTH: f64 = 100.0;

/// Time from which the masters are steady, s.
pub(super) const STEADY_FROM: f64 = QUIET_FROM + motion::PROGRAM + clocks::LEAP_BACK;

/// A schedule under construction.
pub(super) struct SwarmSchedule {
    /// Text, events, and the draws that all kinds of schedules share.
    base: SoakSchedule,
    features: Features,
    /// Highest velocity of all masters, u/s.
    speed: f64,
    /// Highest acceleration of all masters, u/s², and their highest jerk, u/s³.
    dynamics: [f64; 2],
    /// The names of all nodes so far.
    nodes: Vec<String>,
}

/// The schedule of a seed.
pub(super) fn written(seed: u64) -> String {
    let mut random = Random::new(seed_of(seed, "swarm"));
    let features = Features::drawn(&mut random);
    let wide = match features.has(Feature::OneInstant) {
        true => Wide::in_one_instant(seed),
        false => Wide::none(seed),
    };
    let acceleration = random.decades(500.0, 20_000.0);
    let mut schedule = SwarmSchedule {
        features,
        speed: random.between(100.0, 500.0),
        // The acceleration is reached within 10 to 200 ms.
        dynamics: [acceleration, acceleration * random.decades(5.0, 100.0)],
        nodes: Vec::new(),
        base: SoakSchedule {
            random,
            extra_draws: ExtraDraws::new(seed),
            wide,
            text: String::new(),
            events: String::new(),
        },
    };
    schedule.write(seed);
    with_followers(seed, schedule.base.text + &schedule.base.events)
}

impl SwarmSchedule {
    fn write(&mut self, seed: u64) {
        let features = self.features.names();
        let (latency, jitter) = (
            self.base.random.whole(50, 2_000),
            self.base.random.whole(1, 200),
        );
        let _ = write!(
            self.base.text,
            "title = 'Swarm schedule {seed}'\ndescription = '{features}'\nduration-s = {LENGTH}\nseed = {}\n\n[network]\n\
             latency-us = {latency}\njitter = {{ exponential-us = {jitter} }}\n",
            // Scenarios count seeds from 1.
            1 + seed,
        );
        if self.features.has(Feature::Timing) {
            self.base
                .add("\n[timing-network]\nlatency-us = 1\njitter = { exponential-us = 0.5 }\n");
        }
        let senders = self.base.random.whole(1, 2);
        let cycles: Vec<u64> = (0..senders).map(|_| self.cycle_time()).collect();
        for (sender, cycle) in (0..).zip(&cycles) {
            self.sender(&format!("line{sender}"), sender, *cycle);
            if self.features.has(Feature::Standby) {
                // Beside the first one, with its axes on another clock and from another position.
                self.sender(&format!("spare{sender}"), sender, *cycle);
            }
        }
        self.receivers(&cycles);
        if self.features.has(Feature::Routers) {
            self.routers();
        }
    }

    fn cycle_time(&mut self) -> u64 {
        let drawn = *self.base.random.one_of(&[500, 1_000, 1_000, 2_000]);
        let mixed = [250, 500, 1_000, 2_000, 4_000, 5_000, 10_000];
        match self.features.has(Feature::CycleTimes) {
            true => *self.base.random.one_of(&mixed),
            false => drawn,
        }
    }

    /// A sender; `of` is the number of the line whose timing port it has, apart from that of its standby.
    fn sender(&mut self, name: &str, of: u64, cycle: u64) {
        // At least 150 ppm from the receivers' ±100: a beat of TS5066 at least every 13 s at 2 ms.
        let drift = self.base.random.one_of(&[-1.0, 1.0]) * self.base.random.between(250.0, 800.0);
        let clock = self.clock(drift);
        let _ = write!(
            self.base.text,
            "\n[[sender]]\nname = '{name}'\ncycle-time-us = {cycle}\n{clock}"
        );
        // Only the first choice of a receiver has a timing channel.
        if self.features.has(Feature::Timing) && name.starts_with("line") {
            let _ = writeln!(
                self.base.text,
                "timing = {{ listen = '{}' }}",
                timing_port(of)
            );
        }
        let later = self.base.extra_draws.present_after(cycle);
        for axis in 1..=2 {
            let _ = write!(
                self.base.text,
                "\n[[sender.axis]]\nid = {axis}\nname = 'axis {axis}'\nunit = 'mm'\n{later}"
            );
            self.motion();
        }
        if self.features.has(Feature::Absences) {
            self.base.life_of(name, &["restart", "freeze", "twin"]);
        }
        self.nodes.push(name.to_owned());
    }
}

/// Address of the timing channel of a line.
fn timing_port(line: u64) -> String {
    // In virtual time nothing listens there.
    format!("127.0.0.1:{}", 7_450 + line)
}
