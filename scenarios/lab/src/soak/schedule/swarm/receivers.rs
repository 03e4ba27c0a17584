//! Receivers of a swarm schedule: whom they follow, and how.

use std::fmt::Write as _;

use coaxle_node::faults::Random;

use super::super::draw::Draw as _;
use super::super::{QUIET_FROM, TIME_SYNC};
use super::features::Feature;
use super::{SwarmSchedule, plates, timing_port};

/// A receiver, as its followers have to know it.
#[derive(Clone)]
struct Followed {
    name: String,
    cycle: u64,
    slaves: u64,
    publishes_far_axes: bool,
}

/// A node that a receiver follows.
enum FollowedSource {
    Sender { line: u64, cycle: u64 },
    Receiver(Followed),
}

impl SwarmSchedule {
    /// Writes the receivers; the cycle times of the lines are in µs.
    pub(super) fn receivers(&mut self, cycles: &[u64]) {
        let is_chain = self.features.has(Feature::Chain);
        let count = match is_chain {
            true => self.base.random.whole(3, 5),
            false => self.base.random.whole(1, 3),
        };
        let mut last: Option<Followed> = None;
        for receiver in 0..count {
            let upstream = match &last {
                Some(last) if is_chain => FollowedSource::Receiver(last.clone()),
                _ => {
                    let line = self.base.random.below(cycles.len() as u64);
                    let cycle = cycles[line as usize];
                    FollowedSource::Sender { line, cycle }
                }
            };
            last = Some(self.receiver(receiver, &upstream));
        }
    }

    fn receiver(&mut self, receiver: u64, upstream: &FollowedSource) -> Followed {
        let name = format!("follower{receiver}");
        let drift = match (self.base.random.between(-100.0, 100.0), upstream) {
            (drift, FollowedSource::Sender { .. }) => drift,
            // Far enough from the clock that it follows for a beat every few seconds, and to the other side of the next one.
            (drift, FollowedSource::Receiver(_)) if receiver.is_multiple_of(2) => drift,
            (drift, FollowedSource::Receiver(_)) => (500.0 + 3.0 * drift.abs()).copysign(drift),
        };
        let clock = self.clock(drift);
        let cycle = match upstream {
            FollowedSource::Sender { cycle, .. } => *cycle,
            FollowedSource::Receiver(followed) => followed.cycle,
        };
        let cycle = match self.features.has(Feature::CycleTimes) {
            true => cycle_time_beside(&mut self.base.random, cycle),
            false => cycle,
        };
        let publishes_far_axes = self.base.random.chance(0.3);
        let _ = write!(
            self.base.text,
            "\n[[receiver]]\nname = '{name}'\ncycle-time-us = {cycle}\npublish-far-axes = {publishes_far_axes}\n{clock}{}",
            plates::PLATES
        );
        let (far, mode, axes) = self.far(upstream);
        let mut masters: Vec<_> = (1..=axes).map(|n| format!("m{n}")).collect();
        if self.features.has(Feature::VirtualMasters) {
            let later = self.base.extra_draws.virtual_present_after(cycle);
            self.base
                .add("\n[[receiver.virtual-axis]]\nid = 1\nname = 'shaft'\nunit = 'mm'\n");
            // Behind a chain the hold-back of the node depends on whether its far axes have come, which no truth by the config knows.
            if !self.features.has(Feature::Chain) {
                self.base.add(&later);
            }
            self.motion();
            masters.push("shaft".to_owned());
        }
        let slaves = self.base.random.whole(1, 3);
        for slave in 0..slaves {
            self.slave(&name, slave, &masters);
        }
        if self.features.has(Feature::Absences) {
            self.base.life_of(&name, &["restart", "freeze", "stop"]);
        }
        if self.features.has(Feature::FarOrders) {
            self.far_orders(&name, &far, mode);
        }
        self.nodes.push(name.clone());
        Followed {
            name,
            cycle,
            slaves,
            publishes_far_axes,
        }
    }

    /// Writes the followed node; returns its name, the mode and the number of followed axes.
    fn far(&mut self, upstream: &FollowedSource) -> (String, &'static str, u64) {
        // The observer is the default, and is drawn three times as often.
        let mode = *self.base.random.one_of(&[
            "observer", "observer", "observer", "sync", "time", "bypass", "pt1",
        ]);
        let delay = match self.base.random.below(4) {
            0 => "'off'".to_owned(),
            1 => format!(
                "{{ fixed-us = {:.1} }}",
                self.base.random.between(0.0, 3_000.0)
            ),
            _ => "'measured'".to_owned(),
        };
        let (node, channel, all) = match upstream {
            FollowedSource::Sender { line, .. } => (format!("line{line}"), "axes", 2),
            FollowedSource::Receiver(followed) if followed.publishes_far_axes => {
                (followed.name.clone(), "far-axes", 1)
            }
            FollowedSource::Receiver(followed) => {
                (followed.name.clone(), "slaves", followed.slaves)
            }
        };
        let count = match self.features.has(Feature::TwoMasters) {
            true => all.min(2),
            false => 1,
        };
        let axes: Vec<_> = (1..=count).map(|axis| self.far_axis(axis)).collect();
        let mut text = format!(
            "\n[[receiver.far]]\nnode = '{node}'\nchannel = '{channel}'\naxes = [{}]\nmode = '{mode}'\nsync.time-sync = {TIME_SYNC}\n",
            axes.join(", ")
        );
        text += self.base.extra_draws.present();
        text += &self.base.extra_draws.lag();
        let random = &mut self.base.random;
        if random.chance(0.3) {
            let start = *random.one_of(&["bypass", "pt1", "time"]);
            let fall_back = *random.one_of(&["bypass", "pt1"]);
            let _ = writeln!(
                text,
                "sync.start-up-mode = '{start}'\nsync.fall-back-mode = '{fall_back}'"
            );
        }
        if mode == "observer" {
            let _ = writeln!(text, "delay = {delay}");
        }
        if let FollowedSource::Sender { line, .. } = upstream {
            if self.features.has(Feature::Standby) && random.chance(0.8) {
                let _ = writeln!(
                    text,
                    "standby = ['spare{line}']\ntake-over-after-ms = {}",
                    // At least four cycles, which may be as long as 10 ms.
                    random.whole(50, 300)
                );
            }
            if self.features.has(Feature::Timing) && mode == "observer" && delay == "'measured'" {
                let _ = writeln!(text, "timing = {{ connect = '{}' }}", timing_port(*line));
            }
        }
        text += &self.link_faults();
        self.base.text += &text;
        (node, mode, count)
    }

    /// A followed axis, with a name of its own.
    fn far_axis(&mut self, axis: u64) -> String {
        let mut text = format!("{{ id = {axis}, name = 'm{axis}'");
        // Slaves count through as their masters do.
        if self.features.has(Feature::WithinTurn) {
            text += ", modulo = 360, position = 'within-turn'";
        } else if self.features.has(Feature::Modulo) {
            text += ", modulo = 360";
        }
        if self.features.has(Feature::FarLimits) && self.base.random.chance(0.7) {
            let (speed, [acceleration, jerk]) = (self.speed, self.dynamics);
            let [velocity, acceleration, jerk] =
                [speed, acceleration, jerk].map(|most| most * self.base.random.decades(0.6, 10.0));
            let _ = write!(
                text,
                ", limits = {{ velocity = {velocity:.2}, acceleration = {acceleration:.1}, jerk = {jerk:.1} }}"
            );
        }
        text + " }"
    }

    /// Commands about the node that a receiver follows. In the end it follows it as configured.
    fn far_orders(&mut self, receiver: &str, far: &str, mode: &str) {
        let last = QUIET_FROM - 0.1;
        for _ in 0..self.base.random.whole(1, 6) {
            let drawn = self.base.random.between(0.5, last);
            let at = self.base.wide.moment(drawn, last);
            let command = far_order(&mut self.base.random);
            self.far_event(receiver, far, at, &command);
        }
        self.far_event(receiver, far, last, "enable = {}");
        self.far_event(receiver, far, last, &format!("filter-mode = '{mode}'"));
    }

    fn far_event(&mut self, receiver: &str, far: &str, at: f64, command: &str) {
        let _ = write!(
            self.base.events,
            "\n[[event]]\nat-s = {at:.3}\nnode = '{receiver}'\nfar = '{far}'\ncommand = {{ {command} }}\n"
        );
    }
}

/// A command about a followed node.
fn far_order(random: &mut Random) -> String {
    let fixed = random.between(0.0, 2_000.0);
    let other = *random.one_of(&["bypass", "pt1", "sync", "time", "observer"]);
    let blending = random.decades(0.01, 0.5);
    let cycles = random.decades(5.0, 200.0);
    let slope = random.between(0.3, 0.95);
    match random.below(10) {
        0 => "disable = {}".to_owned(),
        1 => "enable = {}".to_owned(),
        2 => "re-initialise = {}".to_owned(),
        3 => format!("set-delay = {{ fixed-us = {fixed:.1} }}"),
        4 => "set-delay = 'measured'".to_owned(),
        5 => format!("set-parameters = {{ extrapolate = {{ blending-time-s = {blending:.3} }} }}"),
        6 => format!(
            "set-parameters = {{ time-sync = {{ slope1-numerator = {slope:.3}, new-drift-bending-cycles = {cycles:.0}, \
             time-mode-blending-cycles = {cycles:.0} }} }}"
        ),
        7 => format!(
            "set-parameters = {{ fall-back-mode = '{}' }}",
            random.one_of(&["pt1", "bypass"])
        ),
        _ => format!("filter-mode = '{other}'"),
    }
}

/// The cycle time of a receiver, µs, that follows a node with this one: `FB_TimeSync` wants one to be a multiple of the other.
fn cycle_time_beside(random: &mut Random, other: u64) -> u64 {
    let [times, part] = [(); 2].map(|()| *random.one_of(&[1, 1, 2, 4]));
    let cycle = other * times / part;
    // The integer division may leave a rest.
    let fits = cycle.is_multiple_of(other) || other.is_multiple_of(cycle);
    match (250..=10_000).contains(&cycle) && fits {
        true => cycle,
        false => other,
    }
}
