//! A schedule: nodes, faults of their clocks and links, events and commands,
//! all from one seed, as the text of a scenario. For some seconds any fault may occur; the rest is quiet.

mod extra_draws;
mod wide;

use std::fmt::Write as _;

use coaxle_node::faults::Random;

use extra_draws::ExtraDraws;
use wide::Wide;

/// End of the last fault, s.
// Absences of up to 2.5 s that begin by 5 s are over by then.
const QUIET_FROM: f64 = 8.0;

/// Length of the quiet phase afterwards, s: TS5066 needs some beats, which mostly come within 4 s, and an observer that
/// began to lock while frames came half a second late needs half a minute.
const QUIET_FOR: f64 = 32.0;

/// Length of a schedule, s.
pub const DURATION_S: f64 = QUIET_FROM + QUIET_FOR;

/// Cam plates for the slaves of a receiver.
const PLATES: &str = "cams = [{ table-id = 10, course = 'cyclic', point = [{ master = 0, slave = 0, law = 'polynom5' }, \
     { master = 180, slave = 60, law = 'polynom5' }, { master = 360, slave = 0 }] }]\n";

/// Parameters of the blocks of TS5066 that tolerate all faults of a schedule.
// 500 cycles of 0.5 ms are 250 ms, and of 2 ms a second: longer silences restart the blocks, which do so by themselves.
const TIME_SYNC: &str =
    "{ age-of-data-limit = 500, max-cycle-index-difference = 500, automatic-re-init = true }";

/// A scenario from a seed.
#[must_use]
pub fn of(seed: u64) -> String {
    written(seed, Wide::none(seed))
}

/// A scenario from a seed that also draws masters in motion, cycle times and limits of many decades, blocks of TS5066 with
/// low tolerance, receivers that are stopped again and again, several faults in one cycle, couplings with strategies, and cam
/// plates with points and plates that wait.
#[must_use]
pub fn wide(seed: u64) -> String {
    written(seed, Wide::all(seed))
}

fn written(seed: u64, wide: Wide) -> String {
    let mut schedule = SoakSchedule {
        random: Random::new(seed),
        extra_draws: ExtraDraws::new(seed),
        wide,
        text: String::new(),
        events: String::new(),
    };
    schedule.write(seed);
    schedule.text + &schedule.events
}

struct SoakSchedule {
    random: Random,
    extra_draws: ExtraDraws,
    wide: Wide,
    text: String,
    /// Tables of their own, behind those of the nodes.
    events: String,
}

impl SoakSchedule {
    fn write(&mut self, seed: u64) {
        let _ = write!(
            self.text,
            "title = 'Random schedule {seed}'\nduration-s = {DURATION_S}\nseed = {}\n\n[network]\nlatency-us = {}\n\
             jitter = {{ exponential-us = {} }}\n",
            // Scenarios count seeds from 1.
            1 + seed,
            self.random.whole(50, 2_000),
            self.random.whole(1, 200),
        );
        let senders = self.random.whole(1, 2);
        let cycles: Vec<u64> = (0..senders).map(|_| self.cycle_time()).collect();
        for (sender, cycle) in cycles.iter().enumerate() {
            self.sender(sender as u64, *cycle);
        }
        let receivers = self.random.whole(1, 2);
        let mut first = 0;
        for receiver in 0..receivers {
            let sender = self.random.below(senders);
            // FB_TimeSync wants one cycle time to be a multiple of the other.
            let cycle = if receiver == 0 {
                first = cycles[sender as usize];
                first
            } else {
                cycles[sender as usize]
            };
            let follows = if receiver > 0 && self.random.chance(0.4) {
                Follows::Receiver { cycle: first }
            } else {
                let cycle = self.wide.cycle_time_beside(cycle);
                if receiver == 0 {
                    first = cycle;
                }
                Follows::Sender { sender, cycle }
            };
            self.receiver(receiver, &follows);
        }
    }

    fn add(&mut self, text: &str) {
        self.text += text;
    }

    fn cycle_time(&mut self) -> u64 {
        // Three in five have the usual millisecond.
        let drawn = *self.random.one_of(&[500, 1_000, 1_000, 1_000, 2_000]);
        self.wide.cycle_time(drawn)
    }

    fn sender(&mut self, sender: u64, cycle: u64) {
        let name = format!("line{sender}");
        // At least 150 ppm from the receivers' ±100: a beat of TS5066 at least every 13 s at 2 ms, and mostly within 4.
        let drift = self.random.one_of(&[-1.0, 1.0]) * self.random.between(250.0, 800.0);
        let clock = self.clock(drift);
        let _ = write!(
            self.text,
            "\n[[sender]]\nname = '{name}'\ncycle-time-us = {cycle}\n{clock}"
        );
        for axis in 1..=2 {
            self.axis(axis);
        }
        self.life_of(&name, &["restart", "freeze", "twin"]);
    }

    /// A clock that drifts, and steps during the faulty phase.
    fn clock(&mut self, drift: f64) -> String {
        let mut clock = format!(
            "clock = {{ drift-ppm = {drift:.1}, start-phase-us = {}, jitter = {{ exponential-us = {} }}",
            self.random.whole(0, 900),
            self.random.whole(1, 60),
        );
        if self.random.chance(0.3) {
            let _ = write!(
                clock,
                ", random-walk-ppm = {:.2}",
                self.random.between(0.01, 1.0)
            );
        }
        let mut steps = Vec::new();
        if self.random.chance(0.4) {
            let phase = self.random.between(1.0, 50_000.0);
            let drift = self.random.between(-100.0, 100.0);
            let at = self.moment(QUIET_FROM);
            steps.push(format!(
                "{{ at-s = {at}, phase-us = {phase:.1}, drift-ppm = {drift:.1} }}"
            ));
        }
        steps.extend(self.extra_draws.step_back());
        if !steps.is_empty() {
            let _ = write!(clock, ", steps = [{}]", steps.join(", "));
        }
        if let Some(terms) = self.extra_draws.drift_terms() {
            let _ = write!(clock, ", {terms}");
        }
        clock + " }\n"
    }

    /// A moment before `end`, not at the very start: s.
    fn moment(&mut self, end: f64) -> String {
        // Half a second for the first messages: a fault before them meets no state.
        let drawn = self.random.between(0.5, end);
        format!("{:.3}", self.wide.moment(drawn, end))
    }

    fn axis(&mut self, id: u64) {
        if let Some(axis) = self.wide.axis() {
            let _ = write!(
                self.text,
                "\n[[sender.axis]]\nid = {id}\nname = 'axis {id}'\nunit = 'mm'\n{axis}"
            );
            return;
        }
        let is_encoder = self.random.chance(0.3);
        let place = if is_encoder {
            "encoder.program"
        } else {
            "program"
        };
        let _ = write!(
            self.text,
            "\n[[sender.axis]]\nid = {id}\nname = 'axis {id}'\nunit = 'mm'\n"
        );
        if is_encoder {
            let resolution = self.random.one_of(&[0.001, 0.01, 0.1]);
            let window = self.random.whole(1, 16);
            let differentiated = self.random.chance(0.3);
            let _ = write!(
                self.text,
                "encoder.resolution = {resolution}\nencoder.velocity-window-cycles = {window}\n\
                 encoder.differentiate-acceleration = {differentiated}\n"
            );
        }
        let start = self.random.between(-400.0, 400.0);
        let _ = write!(
            self.text,
            "{place}.start-velocity = {start:.1}\n{place}.limits = {{ velocity = 500, acceleration = {}, jerk = {} \
             }}\n{place}.repeat = true\n{place}.steps = [\n  {{ enable = true }},\n",
            self.random.whole(500, 3_000),
            self.random.whole(5_000, 60_000),
        );
        for _ in 0..self.random.whole(1, 4) {
            let step = match self.random.below(4) {
                0 => format!(
                    "{{ move-relative = {{ distance = {:.1} }} }}",
                    self.random.between(-900.0, 900.0)
                ),
                1 => format!(
                    "{{ dwell = {{ for-s = {:.3} }} }}",
                    self.random.between(0.1, 2.0)
                ),
                _ => format!(
                    "{{ velocity = {{ value = {:.1}, for-s = {:.3} }} }}",
                    self.random.between(-450.0, 450.0),
                    self.random.between(0.2, 3.0)
                ),
            };
            let _ = writeln!(self.text, "  {step},");
        }
        // A step of zero length would run for ever within a cycle.
        self.add("  { dwell = { for-s = 0.2 } },\n]\n");
    }

    /// Absences of a node during the faulty phase.
    fn life_of(&mut self, node: &str, actions: &[&str]) {
        for action in actions {
            if !self.random.chance(0.3) {
                continue;
            }
            // An absence takes up to 2.5 s, and is over before the quiet phase.
            let drawn = self.random.between(1.0, QUIET_FROM - 3.0);
            let at = self.wide.moment(drawn, QUIET_FROM - 3.0);
            // Half of them are within the silence that the blocks tolerate: others meet timeouts.
            let how_long = if self.random.chance(0.5) {
                self.random.between(0.002, 0.2)
            } else {
                self.random.between(0.2, 2.5)
            };
            let _ = write!(
                self.events,
                "\n[[event]]\nat-s = {at:.3}\nnode = '{node}'\naction = '{action}'\nfor-s = {how_long:.3}\n"
            );
        }
    }

    fn receiver(&mut self, receiver: u64, follows: &Follows) {
        let name = format!("follower{receiver}");
        let (source, cycle) = match follows {
            Follows::Sender { sender, cycle } => (
                format!(
                    "{{ node = 'line{sender}', axis = {}{}{} }}",
                    self.random.whole(1, 2),
                    self.wide.modulo(),
                    self.wide.far_limits(),
                ),
                *cycle,
            ),
            Follows::Receiver { cycle } => (
                "{ node = 'follower0', channel = 'slaves', axis = 1 }".to_owned(),
                *cycle,
            ),
        };
        // The observer is the default, and is drawn three times as often.
        let mode = *self.random.one_of(&[
            "observer", "observer", "observer", "sync", "time", "bypass", "pt1",
        ]);
        let mode = self.wide.mode(mode);
        let drift = match (self.random.between(-100.0, 100.0), follows) {
            (drift, Follows::Sender { .. }) => drift,
            // Far enough from the clock that it follows for a beat every few seconds.
            (drift, Follows::Receiver { .. }) => (500.0 + 3.0 * drift.abs()).copysign(drift),
        };
        let clock = self.clock(drift);
        let delay = match self.random.below(4) {
            0 => "'off'".to_owned(),
            1 => format!("{{ fixed-us = {:.1} }}", self.random.between(0.0, 3_000.0)),
            _ => "'measured'".to_owned(),
        };
        let delay = if mode == "observer" {
            format!("delay = {delay}\n")
        } else {
            String::new()
        };
        let faults = self.faults();
        let time_sync = self
            .wide
            .time_sync()
            .unwrap_or_else(|| TIME_SYNC.to_owned());
        let _ = write!(
            self.text,
            "\n[[receiver]]\nname = '{name}'\ncycle-time-us = {cycle}\nmode = '{mode}'\nmaster = {source}\n{clock}{delay}{PLATES}\
             sync.time-sync = {time_sync}\n{faults}"
        );
        for slave in 0..self.random.whole(1, 3) {
            self.slave(&name, slave);
        }
        self.life_of(&name, &["restart", "freeze"]);
        for (at, how_long) in self.wide.stops() {
            let _ = write!(
                self.events,
                "\n[[event]]\nat-s = {at:.3}\nnode = '{name}'\naction = 'stop'\nfor-s = {how_long:.3}\n"
            );
        }
        let far = match follows {
            Follows::Sender { sender, .. } => format!("line{sender}"),
            Follows::Receiver { .. } => "follower0".to_owned(),
        };
        self.orders_about(&name, &far, mode);
    }

    fn faults(&mut self) -> String {
        let mut faults = Vec::new();
        let mut share = |name: &str, random: &mut Random, most: f64| {
            if random.chance(0.5) {
                faults.push(format!("{name} = {:.3}", random.between(0.0, most)));
            }
        };
        share("loss", &mut self.random, 0.7);
        share("duplication", &mut self.random, 0.5);
        share("reorder", &mut self.random, 0.5);
        faults.push(format!(
            "reorder-us = {}",
            self.random.whole(1_000, 500_000)
        ));
        if self.random.chance(0.4) {
            let (share, most) = (
                self.random.between(0.0, 0.05),
                self.random.whole(5_000, 200_000),
            );
            faults.push(format!(
                "spikes = {{ share = {share:.4}, from-us = 1000, to-us = {most} }}"
            ));
        }
        if self.random.chance(0.4) {
            // Lasting ones, limited by the network to non-negative delays.
            let steps: Vec<_> = (0..self.random.whole(1, 2))
                .map(|_| {
                    let by = self.random.between(-50_000.0, 50_000.0);
                    format!("{{ at-s = {}, by-us = {by:.1} }}", self.moment(QUIET_FROM))
                })
                .collect();
            faults.push(format!(
                // Room for steps back.
                "latency-us = 20000, delay-steps = [{}]",
                steps.join(", ")
            ));
        }
        if self.random.chance(0.4) {
            // Up to 2 s, and so over before the quiet phase.
            let how_long = self.random.between(0.01, 2.0);
            let at = self.moment(QUIET_FROM - 2.0);
            faults.push(format!(
                "partitions = [{{ at-s = {at}, for-s = {how_long:.3} }}]"
            ));
        }
        self.losses_and_delays(&mut faults);
        self.forgeries(&mut faults);
        faults.extend(self.extra_draws.delay_terms());
        format!(
            "faults = {{ {}, faults-until-s = {QUIET_FROM} }}\n",
            faults.join(", ")
        )
    }

    fn losses_and_delays(&mut self, faults: &mut Vec<String>) {
        if self.random.chance(0.3) {
            let corruption = self.random.between(0.0, 0.2);
            faults.push(format!("corruption = {corruption:.3}"));
        }
        if self.random.chance(0.3) {
            let (begins, ends) = (
                self.random.between(0.0, 0.02),
                self.random.between(0.01, 0.5),
            );
            faults.push(format!(
                "burst-loss = {{ begins = {begins:.4}, ends = {ends:.3} }}"
            ));
        }
        if self.random.chance(0.2) {
            let (sigma, time) = (self.random.whole(1, 100), self.random.between(0.1, 10.0));
            faults.push(format!(
                "correlated = {{ sigma-us = {sigma}, time-s = {time:.2} }}"
            ));
        }
        if self.random.chance(0.2) {
            let resolution = self.random.whole(1, 100);
            faults.push(format!("resolution-us = {resolution}"));
        }
        if self.random.chance(0.3) {
            let (at, length) = (
                self.moment(QUIET_FROM - 2.0),
                self.random.between(0.005, 2.0),
            );
            faults.push(format!("stalls = [{{ at-s = {at}, for-s = {length:.3} }}]"));
        }
    }

    fn forgeries(&mut self, faults: &mut Vec<String>) {
        if self.random.chance(0.6) {
            return;
        }
        let forgeries: Vec<_> = (0..self.random.whole(1, 3))
            .map(|_| {
                let (at, length) = (self.moment(QUIET_FROM - 1.0), self.random.between(0.0, 1.0));
                let ahead = self.random.between(-300.0, 300.0);
                // Within the 500 counts that the blocks tolerate, beyond them either way, and beyond any count that a node accepts.
                let count = *self.random.one_of(&[-1_000.0, 7.0, 90.0, 1_000.0, 1e12]);
                let what = match self.random.below(12) {
                    0 => "'noise'".to_owned(),
                    1 => "'first-again'".to_owned(),
                    2 => "'other-run'".to_owned(),
                    3 => "'other-node'".to_owned(),
                    4 => "'other-key'".to_owned(),
                    5 => "'other-version'".to_owned(),
                    6 => "'other-axes'".to_owned(),
                    7 => "'not-finite'".to_owned(),
                    // A cycle time that no sender of these schedules has.
                    8 => "{ cycle-time-us = 4000 }".to_owned(),
                    9 => format!("{{ count-ahead = {count} }}"),
                    10 => format!("{{ position-ahead = {ahead:.1} }}"),
                    // 0x4655.
                    _ => "{ axis-error = 18005 }".to_owned(),
                };
                let (times, instead) = (self.random.whole(1, 3), self.random.chance(0.2));
                format!(
                    "{{ at-s = {at}, for-s = {length:.3}, what = {what}, times = {times}, instead = {instead} }}"
                )
            })
            .collect();
        faults.push(format!("forgeries = [{}]", forgeries.join(", ")));
    }

    fn slave(&mut self, receiver: &str, slave: u64) {
        let name = format!("slave{slave}");
        let _ = write!(self.text, "\n[[receiver.slave]]\nname = '{name}'\n");
        let ratio = *self.random.one_of(&[1.0, 1.0, -1.0, 0.5, 2.0]);
        if self.random.chance(0.1) {
            // Without limits: it follows in any case.
            let _ = writeln!(self.text, "gear = {{ ratio = {ratio} }}");
            return;
        }
        // Masters go at up to 500: some slaves cannot keep up with the fastest.
        let velocity = f64::abs(ratio) * self.random.between(450.0, 1_500.0);
        let acceleration = self.random.between(2_000.0, 40_000.0);
        let jerk = self.random.between(30_000.0, 3e6);
        let mut limits =
            format!("velocity = {velocity:.1}, acceleration = {acceleration:.1}, jerk = {jerk:.1}");
        if let Some(wide) = self.wide.slave_limits(ratio) {
            limits = wide;
        }
        if self.random.chance(0.2) {
            let _ = write!(
                limits,
                ", deceleration = {:.1}",
                self.random.between(1_000.0, 60_000.0)
            );
        }
        if self.random.chance(0.3) {
            let _ = write!(
                limits,
                ", min-position = {:.1}, max-position = {:.1}",
                self.random.between(-900.0, -50.0),
                self.random.between(50.0, 900.0)
            );
        }
        if self.random.chance(0.25) {
            let how = *self.random.one_of(&["quick-stop", "follow"]);
            let _ = write!(limits, ", on-master-loss = '{how}'");
        }
        let _ = writeln!(self.text, "limits = {{ {limits} }}");
        if self.random.chance(0.5) {
            let _ = write!(self.text, "couple = 'gear'\ngear = {{ ratio = {ratio} }}\n");
        } else {
            self.add("couple = 'off'\n");
        }
        for _ in 0..self.random.whole(0, 14) {
            let drawn = self.command();
            let command = self.wide.command(drawn);
            // Commands come in the quiet phase, too: a slave may end in error stop, and is not judged for it.
            let at = self.moment(QUIET_FROM + QUIET_FOR);
            let _ = write!(
                self.events,
                "\n[[event]]\nat-s = {at}\nnode = '{receiver}'\nslave = '{name}'\ncommand = {{ {command} }}\n"
            );
        }
    }

    fn command(&mut self) -> String {
        let near = self.random.between(-300.0, 300.0);
        let way = self.random.between(-500.0, 500.0);
        let speed = self.random.between(-400.0, 400.0);
        let ratio = *self.random.one_of(&[1.0, -1.0, 0.5, 2.0]);
        match self.random.below(24) {
            // Often, as all motions need it.
            0..=3 => "power = true".to_owned(),
            4 | 5 => "reset = {}".to_owned(),
            6 => format!("home = {{ position = {near:.2} }}"),
            7 => format!("move-absolute = {{ position = {near:.2} }}"),
            8 => format!("move-relative = {{ distance = {way:.2}, velocity = 300 }}"),
            9 => format!("move-velocity = {{ velocity = {speed:.2} }}"),
            10 => "halt = {}".to_owned(),
            11 => "stop = {}".to_owned(),
            12 | 13 => format!("gear-in = {{ ratio = {ratio} }}"),
            14 => "gear-out = {}".to_owned(),
            15 | 16 => format!("gear-in-velo = {{ ratio = {{ numerator = {ratio} }} }}"),
            17 => format!(
                "gear-in-pos = {{ ratio = {{ numerator = {ratio} }}, master-sync-position = {way:.2}, slave-sync-position \
                 = {near:.2} }}"
            ),
            18 => format!("phasing-relative = {{ shift = {:.2} }}", near / 3.0),
            19 | 20 => format!("move-superimposed = {{ distance = {:.2} }}", near / 3.0),
            21 => "cam-in = { table = 10, start-mode = 'relative' }".to_owned(),
            22 => format!("gear-in-multi-master = {{ ratios = [{ratio}] }}"),
            _ => "power = false".to_owned(),
        }
    }

    /// Commands about the node that a receiver follows. In the end it follows it as configured.
    fn orders_about(&mut self, receiver: &str, far: &str, mode: &str) {
        // Before the quiet phase, at the end of which the configured mode has to be in sync.
        let last = QUIET_FROM - 0.1;
        let tell = |events: &mut String, at: f64, command: &str| {
            let _ = write!(
                events,
                "\n[[event]]\nat-s = {at:.3}\nnode = '{receiver}'\nfar = '{far}'\ncommand = {{ {command} }}\n"
            );
        };
        if self.random.chance(0.6) {
            return;
        }
        for _ in 0..self.random.whole(1, 4) {
            let at = self.random.between(0.5, last);
            let fixed = self.random.between(0.0, 2_000.0);
            let other = *self
                .random
                .one_of(&["bypass", "pt1", "sync", "time", "observer"]);
            let command = match self.random.below(6) {
                0 => "disable = {}".to_owned(),
                1 => "enable = {}".to_owned(),
                2 => "re-initialise = {}".to_owned(),
                3 => format!("set-delay = {{ fixed-us = {fixed:.1} }}"),
                _ => format!("filter-mode = '{other}'"),
            };
            tell(&mut self.events, at, &command);
        }
        tell(&mut self.events, last, "enable = {}");
        tell(&mut self.events, last, &format!("filter-mode = '{mode}'"));
    }
}

enum Follows {
    Sender { sender: u64, cycle: u64 },
    Receiver { cycle: u64 },
}

/// Random draws.
trait Draw {
    fn between(&mut self, low: f64, high: f64) -> f64;
    fn below(&mut self, count: u64) -> u64;
    fn whole(&mut self, low: u64, high: u64) -> u64;
    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T;
    /// Draws from each decade equally often.
    fn decades(&mut self, low: f64, high: f64) -> f64;
}

impl Draw for Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    fn below(&mut self, count: u64) -> u64 {
        // Below the count, as `uniform` is below 1. The bias of some 2⁻⁵³ does not matter here.
        (self.uniform() * count as f64) as u64
    }

    fn whole(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }

    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        let chosen = self.below(all.len() as u64);
        &all[chosen as usize]
    }

    fn decades(&mut self, low: f64, high: f64) -> f64 {
        // Even in the logarithm: an even draw from 1 to 1e8 would be above 1e7 nine times in ten.
        low * (high / low).powf(self.uniform())
    }
}
