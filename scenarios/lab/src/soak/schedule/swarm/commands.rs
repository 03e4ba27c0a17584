//! Commands to the slaves of a swarm schedule.

use std::fmt::Write as _;

use super::super::QUIET_FROM;
use super::super::draw::Draw as _;
use super::features::Feature;
use super::recovery::RECOVERY_FROM;
use super::{SwarmSchedule, plates};

impl SwarmSchedule {
    /// Writes random commands to a slave, most of them while there are faults.
    pub(super) fn commands(&mut self, receiver: &str, slave: &str, two_masters: bool) {
        for _ in 0..self.base.random.whole(0, 10) {
            let command = self.command(two_masters);
            let end = match self.base.random.chance(0.7) {
                true => QUIET_FROM,
                false => RECOVERY_FROM - 1.0,
            };
            let at = self.base.moment(end);
            self.order(receiver, slave, &at, &command);
        }
    }

    pub(super) fn order(&mut self, receiver: &str, slave: &str, at: &str, command: &str) {
        let _ = write!(
            self.base.events,
            "\n[[event]]\nat-s = {at}\nnode = '{receiver}'\nslave = '{slave}'\ncommand = {{ {command} }}\n"
        );
    }

    fn command(&mut self, two_masters: bool) -> String {
        let turns = self.features.has(Feature::Modulo) || self.features.has(Feature::WithinTurn);
        let random = &mut self.base.random;
        if self.features.has(Feature::Plates) && random.chance(0.4) {
            return plates::command(random, turns);
        }
        if self.features.has(Feature::WrittenPoints) && random.chance(0.3) {
            return plates::online_change(random, turns);
        }
        if self.features.has(Feature::Strategies) && random.chance(0.3) {
            return self.saw(turns);
        }
        let dynamics = self.dynamics_of_command();
        let random = &mut self.base.random;
        let near = random.between(-300.0, 300.0);
        let way = random.between(-500.0, 500.0);
        let speed = random.between(-0.6, 0.6) * self.speed;
        let ratio = *random.one_of(&[1.0, -1.0, 0.5]);
        let second = *random.one_of(&[0.5, -0.5, 1.0, 0.0]);
        match random.below(22) {
            // Often, as all motions need it.
            0..=3 => "power = true".to_owned(),
            4 | 5 => "reset = {}".to_owned(),
            6 => format!("home = {{ position = {near:.2} }}"),
            7 => format!("move-absolute = {{ position = {near:.2}{dynamics} }}"),
            8 => format!(
                "move-relative = {{ distance = {way:.2}, velocity = {:.2}{dynamics} }}",
                speed.abs().max(1.0)
            ),
            9 => format!("move-velocity = {{ velocity = {speed:.2}{dynamics} }}"),
            10 => format!("halt = {{ {} }}", dynamics.trim_start_matches(", ")),
            11 => format!("stop = {{ {} }}", dynamics.trim_start_matches(", ")),
            12 | 13 => format!("gear-in = {{ ratio = {ratio}{dynamics} }}"),
            14 => "gear-out = {}".to_owned(),
            15 => format!(
                "phasing-relative = {{ shift = {:.2}{dynamics} }}",
                near / 3.0
            ),
            16 => format!(
                "phasing-absolute = {{ shift = {:.2}{dynamics} }}",
                near / 3.0
            ),
            17 | 18 => format!(
                "move-superimposed = {{ distance = {:.2}{dynamics} }}",
                near / 3.0
            ),
            19 | 20 if two_masters => {
                format!("gear-in-multi-master = {{ ratios = [{ratio}, {second}]{dynamics} }}")
            }
            19 => format!("gear-in-multi-master = {{ ratios = [{ratio}]{dynamics} }}"),
            20 => "cam-in = { table = 10, start-mode = 'relative' }".to_owned(),
            _ => "power = false".to_owned(),
        }
    }

    /// A flying saw, with a strategy or without.
    fn saw(&mut self, turns: bool) -> String {
        let random = &mut self.base.random;
        let ratio = *random.one_of(&[1.0, 1.0, -1.0, 0.5]);
        if random.chance(0.25) {
            return format!("gear-in-velo = {{ ratio = {{ numerator = {ratio} }} }}");
        }
        let master = match random.below(3) {
            0 => format!("{:.2}", random.between(-1_500.0, 1_500.0)),
            1 if turns => format!("{{ in-turn = {:.2} }}", random.between(0.0, 359.9)),
            _ => format!("{{ ahead = {:.2} }}", random.decades(1.0, 1_000.0)),
        };
        let slave = match random.chance(0.5) {
            true => format!("{:.2}", random.between(-300.0, 300.0)),
            false => format!("{{ ahead = {:.2} }}", random.decades(1.0, 500.0)),
        };
        let strategy = *random.one_of(&[
            "",
            ", strategy = 'early'",
            ", strategy = 'late'",
            ", strategy = 'slow'",
        ]);
        format!(
            "gear-in-pos = {{ ratio = {{ numerator = {ratio} }}, master-sync-position = {master}, slave-sync-position = {slave}{strategy} }}"
        )
    }

    /// Dynamics of a command, as further fields, where it has some.
    fn dynamics_of_command(&mut self) -> String {
        let [acceleration, jerk] = self.dynamics;
        let random = &mut self.base.random;
        if !self.features.has(Feature::Dynamics) || random.chance(0.3) {
            return String::new();
        }
        // From a fiftieth: a ramp to the highest velocity then takes up to 50 s at the least acceleration, and ends within the schedule.
        let [up, down, jerk] =
            [acceleration, acceleration, jerk].map(|most| most * random.decades(0.02, 0.6));
        format!(
            ", dynamics = {{ acceleration = {up:.2}, deceleration = {down:.2}, jerk = {jerk:.2} }}"
        )
    }
}
