//! Slaves of a swarm schedule.

use std::fmt::Write as _;

use super::super::draw::Draw as _;
use super::SwarmSchedule;
use super::features::Feature;

impl SwarmSchedule {
    /// Writes a slave of one of these masters, or of the slave before it, and the commands to it.
    pub(super) fn slave(&mut self, receiver: &str, slave: u64, masters: &[String]) {
        let name = format!("slave{slave}");
        let random = &mut self.base.random;
        let of_slave = slave > 0 && random.chance(0.15);
        let master = match of_slave {
            true => format!("slave{}", slave - 1),
            false => random.one_of(masters).clone(),
        };
        let ratio = match of_slave || self.features.has(Feature::Chain) {
            // Its master already goes at up to twice the velocity, or its followers would.
            true => *random.one_of(&[1.0, -1.0, 0.5]),
            false => *random.one_of(&[1.0, 1.0, -1.0, 0.5, 2.0]),
        };
        let mut text = format!("\n[[receiver.slave]]\nname = '{name}'\nmaster = '{master}'\n");
        let other = masters.iter().find(|other| **other != master);
        let other = other.filter(|_| self.features.has(Feature::TwoMasters));
        if let Some(other) = other {
            let _ = writeln!(text, "further-masters = ['{other}']");
        }
        // Of two masters, or of a slave at twice the velocity, it takes the sum.
        let whole = if of_slave || other.is_some() {
            2.0
        } else {
            1.0
        };
        let scale = whole * f64::max(1.0, f64::abs(ratio));
        let limits = self.limits(scale);
        let random = &mut self.base.random;
        let _ = write!(text, "limits = {{ {limits}");
        if random.chance(0.25) {
            let how = *random.one_of(&["quick-stop", "follow"]);
            let _ = write!(text, ", on-master-loss = '{how}'");
        }
        text += " }\n";
        let _ = match random.below(10) {
            0..=5 => write!(text, "couple = 'gear'\ngear = {{ ratio = {ratio} }}\n"),
            6 | 7 if self.features.has(Feature::Plates) => {
                writeln!(
                    text,
                    "couple = {{ cam = {{ table = 10, start-mode = 'relative' }} }}"
                )
            }
            _ => writeln!(text, "couple = 'off'"),
        };
        self.base.text += &text;
        self.commands(receiver, &name, other.is_some());
        self.recovery(receiver, &name, other.is_some());
    }

    /// Limits of a slave that follows with this multiple of its masters' motion.
    fn limits(&mut self, scale: f64) -> String {
        let (speed, [acceleration, jerk]) = (self.speed, self.dynamics);
        let tight = self.features.has(Feature::TightLimits);
        let random = &mut self.base.random;
        let [velocity, acceleration, jerk] = [speed, acceleration, jerk].map(|most| {
            let share = match tight {
                // Exactly the limit of the master, and a hair above it, are as likely as all shares between.
                true => match random.below(3) {
                    0 => 1.0,
                    1 => 1.0001,
                    _ => random.between(0.6, 1.0),
                },
                false => random.decades(1.5, 20.0),
            };
            scale * most * share
        });
        format!("velocity = {velocity:.4}, acceleration = {acceleration:.3}, jerk = {jerk:.2}")
    }
}
