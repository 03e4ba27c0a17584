//! Additional draws of wide schedules, from a random stream of its own. All other seeds keep their earlier schedules.

use std::fmt::Write as _;

use coaxle_node::faults::{Random, seed_of};

use super::{Draw as _, QUIET_FROM};

/// The separate random stream.
pub(super) struct Wide {
    random: Random,
    /// True for a wide schedule.
    is_on: bool,
    /// Time at which several events occur in one cycle, s.
    together: Option<f64>,
    /// The length of the turns of all masters, if they turn.
    modulo: Option<u32>,
}

impl Wide {
    /// Draws of a wide schedule.
    pub(super) fn all(seed: u64) -> Self {
        Self::new(seed, true)
    }

    /// Draws of other schedules, without effect.
    pub(super) fn none(seed: u64) -> Self {
        Self::new(seed, false)
    }

    /// Draws of other schedules whose events meet at one instant.
    pub(super) fn in_one_instant(seed: u64) -> Self {
        let Self { random, .. } = Self::none(seed);
        // In the middle of the faulty phase: absences may begin there, too, and are over in time.
        let together = Some(QUIET_FROM / 2.0);
        Self {
            random,
            is_on: false,
            together,
            modulo: None,
        }
    }

    fn new(seed: u64, is_on: bool) -> Self {
        let mut random = Random::new(seed_of(seed, "wide"));
        let at = random.between(1.0, QUIET_FROM - 1.0);
        // Drawn whether it is on or not: both kinds share the constructor, and the stream is their own.
        let together = random.chance(0.5).then_some(at);
        // A single length for all masters: a receiver is configured with that of the axis that it follows.
        let modulo = random.chance(0.3).then_some(360);
        Self {
            random,
            is_on,
            together: together.filter(|_| is_on),
            modulo: modulo.filter(|_| is_on),
        }
    }

    /// The cycle time of a sender, µs, in place of the one drawn.
    pub(super) fn cycle_time(&mut self, drawn: u64) -> u64 {
        let all = [250, 500, 1_000, 2_000, 4_000, 5_000, 10_000];
        match self.is_on {
            true => *self.random.one_of(&all),
            false => drawn,
        }
    }

    /// The cycle time of a receiver, µs, whose sender has this one: `FB_TimeSync` wants one to be a multiple of the other.
    pub(super) fn cycle_time_beside(&mut self, sender: u64) -> u64 {
        if !self.is_on || self.random.chance(0.5) {
            return sender;
        }
        let [times, part] = [(); 2].map(|()| *self.random.one_of(&[1, 2, 4]));
        let cycle = sender * times / part;
        // The integer division may leave a rest.
        let fits = cycle.is_multiple_of(sender) || sender.is_multiple_of(cycle);
        match (250..=10_000).contains(&cycle) && fits {
            true => cycle,
            false => sender,
        }
    }

    /// Time of an event, s, in place of the one drawn.
    pub(super) fn moment(&mut self, drawn: f64, end: f64) -> f64 {
        match self.together {
            // Some stay apart, so that there are events before and after those in one cycle.
            Some(at) if at < end && self.random.chance(0.6) => at,
            _ => drawn,
        }
    }

    /// `, modulo = 360` where masters turn.
    pub(super) fn modulo(&self) -> String {
        let modulo = self.modulo.map(|modulo| format!(", modulo = {modulo}"));
        modulo.unwrap_or_default()
    }

    /// The limits of a far axis, where it has some.
    pub(super) fn far_limits(&mut self) -> String {
        if !self.is_on || self.random.chance(0.7) {
            return String::new();
        }
        let limits = self.limits(1.0);
        format!(", limits = {{ {limits} }}")
    }

    /// Text of a sender's axis in motion, behind its id, name and unit.
    pub(super) fn axis(&mut self) -> Option<String> {
        if !self.is_on || self.random.chance(0.3) {
            return None;
        }
        let acceleration = self.random.decades(200.0, 50_000.0);
        let jerk = acceleration * self.random.decades(5.0, 500.0);
        // With 5 % of ripple at most 473, below the limit of 500.
        let speed = self.random.one_of(&[-1.0, 1.0]) * self.random.between(20.0, 450.0);
        let mut text = String::new();
        if let Some(modulo) = self.modulo {
            let _ = writeln!(text, "modulo = {modulo}");
        }
        let steps = match self.random.below(4) {
            0 => {
                let [ripple, hertz] =
                    [(0.001, 0.05), (0.5, 20.0)].map(|(from, to)| self.random.decades(from, to));
                let [fast, slow] = [1.0 + ripple, 1.0 - ripple].map(|share| speed * share);
                // Half a period each.
                two_velocities([fast, slow], [0.5 / hertz; 2])
            }
            1 => {
                let other = speed * self.random.between(0.1, 1.0);
                let times = [(); 2].map(|()| self.random.decades(0.1, 3.0));
                two_velocities([speed, other], times)
            }
            2 => {
                let time = self.random.decades(0.05, 2.0);
                two_velocities([speed, -speed], [time; 2])
            }
            _ => {
                let way = self.random.between(-500.0, 500.0);
                let rest = self.random.decades(0.01, 1.0);
                format!(
                    "  {{ move-relative = {{ distance = {way:.2} }} }},\n  {{ dwell = {{ for-s = {rest:.3} }} }},\n  \
                     {{ move-relative = {{ distance = {:.2} }} }},\n",
                    -way
                )
            }
        };
        let _ = write!(
            text,
            "program.limits = {{ velocity = 500, acceleration = {acceleration:.1}, jerk = {jerk:.1} }}\n\
             program.repeat = true\nprogram.steps = [\n  {{ enable = true }},\n{steps}  {{ dwell = {{ for-s = 0.01 }} }},\n]\n"
        );
        Some(text)
    }

    /// Mode of a receiver, in place of the one drawn.
    pub(super) fn mode(&mut self, drawn: &'static str) -> &'static str {
        const MODES: [&str; 4] = ["sync", "time", "sync", "observer"];
        match self.is_on && self.random.chance(0.3) {
            true => self.random.one_of::<&str>(&MODES),
            false => drawn,
        }
    }

    /// Parameters of the blocks of TS5066, which restart by themselves, where they differ from those of all schedules.
    pub(super) fn time_sync(&mut self) -> Option<String> {
        if !self.is_on || self.random.chance(0.3) {
            return None;
        }
        let [age, index] =
            // Down to three cycles of silence and less than half an index, with which a block may never get in sync.
            [(3.0, 500.0), (0.4, 500.0)].map(|(from, to)| self.random.decades(from, to));
        let slope = self.random.between(0.3, 0.95);
        let cycles = self.random.decades(5.0, 200.0).round();
        Some(format!(
            "{{ age-of-data-limit = {age:.0}, max-cycle-index-difference = {index:.2}, automatic-re-init = true, \
             slope1-numerator = {slope:.3}, time-mode-blending-cycles = {cycles}, new-drift-bending-cycles = {cycles} }}"
        ))
    }

    /// Stops of a receiver: beginning and duration, s.
    pub(super) fn stops(&mut self) -> Vec<(f64, f64)> {
        if !self.is_on || self.random.chance(0.6) {
            return Vec::new();
        }
        let mut at = self.random.between(0.5, 2.0);
        let mut stops = Vec::new();
        while at < QUIET_FROM - 1.0 {
            // The last one ends with the faulty phase.
            let length = self.random.decades(0.02, 2.0).min(QUIET_FROM - at);
            stops.push((at, length));
            at += length + self.random.decades(0.02, 2.0);
        }
        stops
    }

    /// The limits of a slave that follows with a ratio: of any decade.
    pub(super) fn slave_limits(&mut self, ratio: f64) -> Option<String> {
        if !self.is_on || self.random.chance(0.4) {
            return None;
        }
        Some(self.limits(ratio.abs()))
    }

    fn limits(&mut self, ratio: f64) -> String {
        // From below the speed of most masters to far above that of all.
        let velocity = ratio * self.random.decades(100.0, 20_000.0);
        let acceleration = ratio * self.random.decades(100.0, 1e7);
        // A config admits no larger jerk.
        // The acceleration is reached within a second, or within 10 ns.
        let jerk = (acceleration * self.random.decades(1.0, 1e8)).min(1e15);
        format!("velocity = {velocity:.3}, acceleration = {acceleration:.3}, jerk = {jerk:.3}")
    }

    /// A command, in place of the one drawn.
    pub(super) fn command(&mut self, drawn: String) -> String {
        if !self.is_on || self.random.chance(0.5) {
            return drawn;
        }
        let [near, way] = [300.0, 1_500.0].map(|most| self.random.between(-most, most));
        let strategy = *self.random.one_of(&["early", "late"]);
        match self.random.below(7) {
            0 | 1 => format!(
                "gear-in-pos = {{ ratio = {{ numerator = 1 }}, master-sync-position = {way:.2}, slave-sync-position = \
                 {near:.2}, strategy = '{strategy}' }}"
            ),
            2 | 3 => format!(
                "cam-in = {{ table = 10, start-mode = 'relative', activation = {{ mode = 'at-master-axis-pos', position = \
                 {way:.2} }} }}"
            ),
            4 => "cam-in = { table = 10, start-mode = 'relative' }".to_owned(),
            5 => format!(
                "set-cam-online-change-mode = {{ table = 10, mode = {{ activation = {{ mode = 'at-master-axis-pos', \
                 position = {way:.2} }} }} }}"
            ),
            _ => format!(
                "write-motion-function = {{ table = 10, points = [{{ index = 2, type = 'rest', law = 'polynom5', master = 180, \
                 slave = {:.2} }}] }}",
                60.0 + near / 10.0
            ),
        }
    }
}

/// Two velocities in turn, each for its time, s.
fn two_velocities(velocities: [f64; 2], times: [f64; 2]) -> String {
    let step = |n: usize| {
        let (value, time) = (velocities[n], times[n]);
        format!("  {{ velocity = {{ value = {value:.4}, for-s = {time:.4} }} }},\n")
    };
    step(0) + &step(1)
}
