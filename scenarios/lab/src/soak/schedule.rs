//! A schedule: nodes, faults of their clocks and links, events and commands,
//! all from one seed, as the text of a scenario. For some seconds any fault may occur; the rest is quiet.

mod draw;
mod extra_draws;
mod late_draws;
mod link_faults;
mod orders;
mod receiver;
mod sender;
mod slave;
mod swarm;
mod wide;

use std::fmt::Write as _;

use coaxle_node::faults::Random;

use draw::Draw;
use extra_draws::ExtraDraws;
pub use extra_draws::before_lags;
pub use late_draws::{before_dead_times, before_followers, before_locks};
use wide::Wide;

/// End of the last fault, s.
// Absences of up to 2.5 s that begin by 5 s are over by then.
const QUIET_FROM: f64 = 8.0;

/// Length of the quiet phase afterwards, s: TS5066 needs some beats, which mostly come within 4 s, and an observer that
/// began to lock while frames came half a second late needs half a minute.
const QUIET_FOR: f64 = 32.0;

/// Length of a schedule that is not a swarm's, s.
const DURATION_S: f64 = QUIET_FROM + QUIET_FOR;

/// A kind of schedules.
#[derive(Clone, Copy, Debug)]
pub struct ScheduleKind {
    /// The scenario of a seed.
    pub text: fn(u64) -> String,
    /// Length of each, s.
    pub length_s: f64,
}

/// Schedules of one or two lines and followers, with all faults.
pub const PLAIN: ScheduleKind = ScheduleKind {
    text: of,
    length_s: DURATION_S,
};

/// Schedules that draw more than usual.
pub const WIDE: ScheduleKind = ScheduleKind {
    text: wide,
    length_s: DURATION_S,
};

/// Schedules that switch whole features on and off, and whose liveness is judged.
pub const SWARM: ScheduleKind = ScheduleKind {
    text: swarm::written,
    length_s: swarm::LENGTH,
};

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
    late_draws::with_followers(seed, schedule.text + &schedule.events)
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

    /// A moment before `end`, not at the very start: s.
    fn moment(&mut self, end: f64) -> String {
        // Half a second for the first messages: a fault before them meets no state.
        let drawn = self.random.between(0.5, end);
        format!("{:.3}", self.wide.moment(drawn, end))
    }
}

enum Follows {
    Sender { sender: u64, cycle: u64 },
    Receiver { cycle: u64 },
}
